"""What goes wrong in a fake cell, who may command it, and the account of what was done."""

from types import SimpleNamespace

import pytest
from remodel_msgs.msg import ErrorCode

from remodel_states.core.ability_error import AbilityError
from remodel_states.core.contract import NO_OWNER, owner_of
from remodel_states.serving import admitted
from remodel_states.testing.faults import Cure, InjectedFault, at_goal, when_fed, when_mended
from remodel_states.testing.world import Deed, Entry, account

CELL = "cell_1"


def goal(**fields):
    return SimpleNamespace(**{"cable_id": "W1", "force_limit": 8.0, **fields})


def jam(**fields):
    return InjectedFault("insertion_jammed", "InsertCable", ErrorCode.INSERTION_JAMMED, **fields)


def strikes(fault, goals):
    """Return which of these (ability, goal) a fault strikes."""
    faults, struck = (fault,), []
    for ability, sent in goals:
        faults, striking = at_goal(faults, ability, sent)
        struck.append(striking is not None)
    return struck


def test_a_passing_fault_strikes_from_the_nth_goal_as_often_as_it_says():
    goals = [("FixCable", goal()), *[("InsertCable", goal())] * 4]
    assert strikes(jam(nth=2, times=2), goals) == [False, False, True, True, False]


def test_a_fault_may_be_of_one_wire():
    goals = [("InsertCable", goal(cable_id=wire)) for wire in ("W1", "W2", "W2")]
    assert strikes(jam(wire="W2"), goals) == [False, True, False]


def test_a_retry_does_not_help_against_a_fault_that_needs_more():
    insert = ("InsertCable", goal())
    locate = ("LocateGearboxComponent", SimpleNamespace(component_id="Q1", terminal_id="1"))
    assert strikes(jam(cure=Cure.NEW_PART), [insert] * 4) == [True] * 4
    look = jam(cure=Cure.LOOK_AGAIN)
    same_view = ("DetectCable", SimpleNamespace(cable_id="W1", view=0))
    other_view = ("DetectCable", SimpleNamespace(cable_id="W1", view=1))
    goals = [locate, other_view, insert, locate, same_view, insert, other_view, insert]
    assert strikes(look, goals) == [False, False, True, False, False, True, False, False]
    force = jam(cure=Cure.RETRY_WITH, parameter="force_limit", at_least=12.0)
    more = ("InsertCable", goal(force_limit=13.0))
    assert strikes(force, [insert, insert, more]) == [True, True, False]


def test_feeding_cures_by_which_wire_is_fed():
    for cure, curing in ((Cure.NEW_PART, "W1"), (Cure.REPLAN, "W2")):
        (struck,), _ = at_goal((jam(cure=cure),), "InsertCable", goal())
        outcome = {wire: when_fed((struck,), wire)[0].is_over for wire in ("W1", "W2")}
        assert outcome == {"W1": curing == "W1", "W2": curing == "W2"}


def test_a_stuck_end_cannot_be_discarded_while_it_is_stuck():
    stuck = InjectedFault("extraction_stuck", "ExtractCable", 306, cure=Cure.ASK_OPERATOR)
    faults = (stuck,)
    for included, strikes_it in (((), False), (("ExtractCable",), True), (("ExtractCable",), True)):
        faults, striking = at_goal(faults, "DiscardCable", goal(), included)
        assert (striking is not None) == strikes_it
    _, striking = at_goal(when_mended(faults), "DiscardCable", goal(), ("ExtractCable",))
    assert striking is None


def test_an_operator_mends_what_has_shown():
    (struck,), _ = at_goal((jam(cure=Cure.ASK_OPERATOR),), "InsertCable", goal())
    mended, waiting = when_mended((struck, jam()))
    assert mended.is_over
    assert not waiting.is_over


@pytest.mark.parametrize("wrong", [{"nth": 0}, {"times": 0}, {"cure": Cure.RETRY_WITH}])
def test_a_senseless_fault_is_refused(wrong):
    with pytest.raises(ValueError, match="insertion_jammed"):
        jam(**wrong)


# --- who may command


@pytest.mark.parametrize("goal_id", ["17:Connect/Insert#1", "17:"])
def test_the_owner_is_in_front_of_a_goals_id(goal_id):
    assert owner_of(goal_id) == 17


@pytest.mark.parametrize("goal_id", ["Connect/Insert#1", "a:b", "W17:x", "17 x", "-1:x", "²:x", ""])
def test_an_id_without_a_number_in_front_has_no_owner(goal_id):
    assert owner_of(goal_id) == NO_OWNER


def test_an_older_supervisor_is_refused_in_its_cell():
    owners = admitted(admitted({}, CELL, 17), CELL, 18)
    assert admitted(owners, CELL, 18) == admitted(owners, CELL, 0) == {CELL: 18}
    assert admitted(owners, "cell_2", 3) == {CELL: 18, "cell_2": 3}
    with pytest.raises(AbilityError, match="supervisor 17 no longer owns cell_1") as raised:
        admitted(owners, CELL, 17)
    assert raised.value.code == ErrorCode.STALE_OWNER


# --- the account


def entries(text):
    """Return the entries of words like "feed:W1" and "fix:W1/a"."""
    found = []
    for word in text.split():
        deed, _, what = word.partition(":")
        wire, _, end = what.partition("/")
        found.append(Entry(Deed(deed), CELL, wire, end))
    return found


@pytest.mark.parametrize(
    ("deeds", "expected"),
    [
        ("feed:W1 fix:W1/a fix:W1/b", ((), (), (), ())),
        ("feed:W1 fix:W1/a", ((), (), (), ("W1/b",))),
        ("feed:W1 fix:W1/a feed:W1 fix:W1/a fix:W1/b", (("W1/a",), ("W1",), ("W1",), ())),
        ("feed:W1 fix:W1/a fix:W1/b loosen:W1/b", ((), (), (), ("W1/b",))),
        ("feed:W1 feed:W1 fix:W1/a fix:W1/b feed:W2", ((), ("W1",), (), ())),
        ("feed:W1 fix:W1/a discard:W1", ((), (), ("W1",), ("W1/a", "W1/b"))),
        (
            "feed:W1 fix:W1/a discard:W1 feed:W1 fix:W1/a fix:W1/b",
            (("W1/a",), ("W1",), ("W1",), ()),
        ),
        ("feed:W1 discard:W1 feed:W1 fix:W1/a fix:W1/b", ((), ("W1",), (), ())),
        ("feed:W1 fix:W1/a loosen:W1/a discard:W1", ((), (), (), ("W1/a", "W1/b"))),
        ("feed:W1 fix:W1/a load:p feed:W1 fix:W1/a fix:W1/b", ((), (), (), ())),
    ],
)
def test_the_account_lists_what_was_done_twice_or_left_out(deeds, expected):
    found = account(entries(deeds), ["W1"])
    assert (found.fixed_again, found.fed_again, found.scrapped, found.omitted) == expected
