"""What is tried against failures, and which of it helps."""

from remodel_rehearsal.core.forecast import (
    Change,
    adopted,
    changes_within,
    forecast,
    to_check,
    with_changes,
)
from remodel_run.rehearsal import Failure, Trial
from remodel_tasks.core.use_case.model import Bounds

JAMMED = Failure("InsertCable", "INSERTION_JAMMED", "stopped 4 mm deep")


def trials(wire, good, bad):
    return [
        Trial(wire, seed, True, 1, () if seed < good else (JAMMED,)) for seed in range(good + bad)
    ]


def test_forces_at_both_bounds_are_tried_but_not_the_one_that_failed():
    changes = changes_within({"force_limit": Bounds(14.0, 8.0, 20.0, 7)})
    assert [each.force_n for each in changes if each.force_n] == [8.0, 20.0]
    assert [each.force_n for each in changes_within({})] == [0.0, 0.0]


def test_the_most_doubtful_wires_are_to_check_first():
    names = ("W1", "W2", "W3", "W4", "W5")
    of = {"W1": (9, 1), "W2": (2, 8), "W3": (10, 0), "W4": (6, 4), "W5": (5, 5)}
    found = forecast(names, [t for name, counts in of.items() for t in trials(name, *counts)])
    assert to_check(found) == ("W2", "W5", "W4")


def test_a_wire_that_never_fails_is_not_to_check():
    assert to_check(forecast(("W1",), trials("W1", 3, 0))) == ()


def test_the_best_change_comes_first():
    found = forecast(("W1", "W2"), trials("W1", 1, 3) + trials("W2", 4, 0))
    tried = {("W1", "longer"): trials("W1", 1, 3), ("W1", "20 N"): trials("W1", 4, 0)}
    first, second = with_changes(found, tried).wires
    assert [each.text for each in first.changes] == ["20 N", "longer"]
    assert first.changes[0].at_once.mean > first.at_once.mean == first.changes[1].at_once.mean
    assert second.changes == ()


def test_the_other_end_is_tried_where_the_first_one_is_planned():
    assert [each.begin for each in changes_within({}, first="a")] == ["", "b", ""]
    assert [each.begin for each in changes_within({}, first="b")] == ["", "a", ""]


# What helped is entered into the order's preferences.


FIRST = Change("placed before the others", is_first=True)
END_B = Change("inserted at end b first", begin="b")
HARDER = Change("pushed with 20 N", force_n=20.0)


def lost(wire, good, bad):
    return [Trial(wire, seed, seed < good, 3, (JAMMED,)) for seed in range(good + bad)]


def entered(document=None, *, before=None, **tried):
    """Return the preferences after W1 was tried with changes: name -> how often of 10 it went."""
    changes = {"first": FIRST, "end_b": END_B, "harder": HARDER}
    found = forecast(("W1",), before or trials("W1", 2, 8))
    found = with_changes(
        found, {("W1", changes[name].text): trials("W1", n, 10 - n) for name, n in tried.items()}
    )
    return adopted(found, {"W1": [changes[name] for name in tried]}, document)


def test_what_surely_helps_is_entered():
    (entry,) = entered(first=9, end_b=4)["prefer"]
    assert entry["name"].startswith("rehearsed: W1 placed before the others, 86% at the first")
    assert (entry["pick"], entry["before"]) == ("W1", "all")
    (entry,) = entered(first=2, end_b=9)["require"]
    assert (entry["begin"], entry["at"]) == ("W1", "b")


def test_what_may_be_chance_is_not_entered_and_forces_are_learned_instead():
    assert entered(first=4, end_b=3) is None
    assert entered(harder=10, first=4) is None


def test_a_wire_that_hardly_succeeds_with_any_change_is_by_hand():
    (entry,) = entered(before=lost("W1", 0, 10), first=0, harder=1)["require"]
    assert entry["by_hand"] == "W1"
    assert entered(before=lost("W1", 0, 10), harder=6) is None


def test_what_a_user_and_earlier_rehearsals_have_entered_stays():
    own = {"name": "mine", "route": "W1", "before": "W2"}
    earlier = [{"name": f"rehearsed: {w} by hand", "by_hand": w} for w in ("W1", "W11")]
    document = {
        "format": "remodel-preferences-1",
        "zones": {"B": [1, 2]},
        "require": [own, *earlier],
    }
    after = entered(document, end_b=10)
    assert after["zones"] == {"B": [1, 2]}
    assert [each for each in after["require"] if "at" not in each] == [own, earlier[1]]
    assert entered(document, end_b=3) == document
