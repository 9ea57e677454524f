"""Failures are distinguished, answered in order, and never forever."""

import json
import os
from dataclasses import replace

import hypothesis.strategies as st
import pytest
from hypothesis import given

from remodel_production.errors import PlannerError
from remodel_supervision.core.recovery.decide import Failure, Spent, decide
from remodel_tasks.core.use_case.fault import Change, Do, Limits, Policy, Response, policy_from
from remodel_tasks.edge.fault_file import read_faults
from remodel_tasks.errors import UseCaseError

FAULTS = read_faults()
LITTLE = Spent(task_attempts=1, task_s=10.0, run_failures=1, run_s=100.0)
PLAIN = Policy()
ATTENDED = tuple(Do)
UNATTENDED = tuple(set(Do) - {Do.ASK_OPERATOR})


def failure(name, **parameters):
    fault = FAULTS[name]
    values = tuple((key, str(value)) for key, value in parameters.items())
    return Failure("W1", fault, min(fault.codes), "InsertCable", "/a", "no", 1.0, values)


def answers(name, policy=PLAIN, possible=ATTENDED, spent=LITTLE, **parameters):
    """Return what is done about the same failure again and again, up to something lasting."""
    decisions = []
    while not decisions or not decisions[-1].do.is_lasting:
        earlier = [(name, decision.do) for decision in decisions]
        decisions.append(decide(failure(name, **parameters), earlier, spent, policy, possible))
    return [decision.do for decision in decisions]


@pytest.mark.parametrize("name", FAULTS.names)
def test_each_code_has_its_fault(name):
    fault = FAULTS[name]
    for code in fault.codes:
        assert FAULTS.diagnose([code] * fault.after) is fault


def test_a_row_of_misses_is_a_misjudged_tip():
    assert FAULTS.diagnose([300]).name == "insertion_misaligned"
    assert FAULTS.diagnose([300, 302]).name == "tip_misjudged"
    assert FAULTS.diagnose([300, 301, 302]).name == "insertion_misaligned"


def test_an_overlays_table_is_read_and_a_faulty_one_reported(tmp_path, monkeypatch):
    package = tmp_path / "crimping"
    package.mkdir()
    (package / "package.xml").write_text(
        "<package><name>crimping</name><export>"
        '<remodel_states faults="${prefix}/faults.yaml"/></export></package>'
    )
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{tmp_path}:{os.environ['ROS_PACKAGE_PATH']}")
    row = {
        "fault": "ferrule_missing",
        "family": "grasping",
        "codes": [{"code": 1000, "name": "FERRULE_MISSING", "meaning": "-", "remedy": "-"}],
        "severity": "recoverable",
        "symptoms": "The jaw closes on nothing.",
        "first_level": "task",
        "responses": [{"do": "ask_operator", "because": "Only a person can feed ferrules."}],
        "cause": {"interface": {"ability": "CrimpFerrule", "code": "FERRULE_MISSING"}},
    }
    (package / "faults.yaml").write_text(json.dumps({"faults": [row]}))
    assert read_faults().of(1000).responses == (Response(Do.ASK_OPERATOR),)
    (package / "faults.yaml").write_text(json.dumps({"faults": [{**row, "family": "other"}]}))
    with pytest.raises(PlannerError, match=r"crimping/faults\.yaml: 1 problem:\n.*family"):
        read_faults()


def test_what_no_fault_knows_is_none():
    assert FAULTS.diagnose([0]) is None
    assert FAULTS.diagnose([]) is None


def test_responses_come_in_order():
    assert answers("grasp_missed") == [*[Do.LOOK_AGAIN] * 2, Do.NEW_PART, Do.SET_ASIDE]


def test_each_repeated_observation_of_a_task_has_a_viewpoint_of_its_own():
    earlier = []
    for view, name in enumerate(("grasp_missed", "grasp_missed", "slipped"), 1):
        decision = decide(failure(name), earlier, LITTLE, PLAIN)
        assert (decision.do, decision.change) == (Do.LOOK_AGAIN, (("view", view),))
        earlier.append((name, decision.do))
    assert decide(failure("slipped"), earlier, LITTLE, PLAIN).change == ()


def test_what_hardly_ever_helps_is_spared():
    decision = decide(failure("grasp_missed"), [], LITTLE, PLAIN, ATTENDED, {Do.LOOK_AGAIN})
    assert decision.do is Do.NEW_PART
    assert decision.because.endswith(", and looking from another view hardly ever helps")
    spared = {Do.LOOK_AGAIN, Do.NEW_PART, Do.SET_ASIDE}
    last = decide(failure("grasp_missed"), [], LITTLE, PLAIN, ATTENDED, spared)
    assert last.do is Do.SET_ASIDE, "what is lasting ends it"


def test_each_fault_is_counted_by_itself():
    first = decide(failure("slipped"), [], LITTLE, Policy())
    second = decide(failure("grasp_missed"), [("slipped", first.do)], LITTLE, Policy())
    assert (
        second.because
        == "that is what it does about 'grasp missed', up to 2 times; this is the first"
    )


def test_without_an_operator_no_question_is_asked():
    assert answers("server_lost", possible=UNATTENDED) == [
        *[Do.LOOK_AGAIN] * 2,
        Do.NEW_PART,
        Do.SET_ASIDE,
    ]
    stopping = Policy(unattended=Do.STOP)
    assert answers("server_lost", stopping, UNATTENDED)[-1] is Do.STOP


@pytest.mark.parametrize("name", ["motion_blocked", "server_hung", "cell_contested"])
def test_where_nothing_may_move_an_unattended_run_stops_whatever_its_use_case_says(name):
    assert answers(name, Policy(unattended=Do.SET_ASIDE), UNATTENDED)[-1] is Do.STOP
    assert answers(name)[-1] is Do.ASK_OPERATOR


@pytest.mark.parametrize("name", FAULTS.names)
@pytest.mark.parametrize("unattended", [Do.SET_ASIDE, Do.STOP])
def test_without_an_operator_nothing_is_tried_more_often_than_with_one(name, unattended):
    policy = Policy(unattended=unattended)
    *absent, last = answers(name, policy, UNATTENDED)
    *present, _ = answers(name, policy, ATTENDED)
    assert absent == present
    assert last in (Do.SET_ASIDE, Do.STOP)


@pytest.mark.parametrize("possible", [ATTENDED, UNATTENDED], ids=["attended", "unattended"])
@pytest.mark.parametrize("do", [do for do in Do if not do.is_lasting])
def test_a_use_case_that_forgot_to_end_does_not_go_on_beyond_the_limits(do, possible):
    change = (("force_limit", Change(1.0, 20.0)),) if do is Do.RETRY_WITH else ()
    policy = Policy({"grasp_missed": (Response(do, 100, change),)})
    spent = Spent(6, 1.0, 6, 1.0)
    assert decide(failure("grasp_missed"), [], spent, policy, possible).do is Do.SET_ASIDE


def test_what_is_not_possible_is_passed_over():
    possible = set(Do) - {Do.OTHER_METHOD}
    assert answers("plan_not_executable", possible=possible) == [Do.SET_ASIDE]


def test_a_parameter_changes_within_its_bound():
    one = decide(failure("insufficient_force", force_limit=8.0), [], LITTLE, Policy())
    assert (one.do, one.change) == (Do.RETRY_WITH, (("force_limit", 12.0),))
    near = decide(failure("insufficient_force", force_limit=17.0), [], LITTLE, Policy())
    assert near.change == (("force_limit", 20.0),)
    other = decide(failure("insufficient_force", force_limit=20.0), [], LITTLE, Policy())
    assert other.do is Do.NEW_PART, "at its bound already"
    bears = replace(failure("insufficient_force", force_limit=8.0), bounds=(("force_limit", 10.0),))
    assert decide(bears, [], LITTLE, Policy()).change == (("force_limit", 10.0),)
    weak = replace(bears, bounds=(("force_limit", 7.0),))
    assert decide(weak, [], LITTLE, Policy()).do is Do.NEW_PART, "the terminal bears no more"


def test_a_use_case_may_answer_otherwise():
    policy = Policy({"slipped": (Response(Do.STOP),)})
    assert answers("slipped", policy) == [Do.STOP]


@pytest.mark.parametrize(
    ("spent", "do", "because"),
    [
        (Spent(6, 1.0, 1, 1.0), Do.SET_ASIDE, "the task has had 6 of its 6 attempts"),
        (
            Spent(1, 2000.0, 1, 1.0),
            Do.SET_ASIDE,
            "the task has taken 2000 s of the 1800 s that it may take",
        ),
        (Spent(1, 1.0, 201, 1.0), Do.STOP, "the run has failed 201 times; it may 200 times"),
        (
            Spent(1, 1.0, 1, 90000.0),
            Do.STOP,
            "the run has taken 90000 s of the 86400 s that it may take",
        ),
    ],
)
def test_limits_end_a_task_or_a_run(spent, do, because):
    decision = decide(failure("grasp_missed"), [], spent, Policy())
    assert (decision.do, decision.because) == (do, because)


@given(
    st.lists(st.sampled_from(FAULTS.names), min_size=1, max_size=60),
    st.sets(st.sampled_from(list(Do))),
    st.integers(1, 8),
)
def test_no_task_is_tried_for_ever(names, possible, attempts):
    policy = Policy(limits=Limits(task_attempts=attempts))
    decisions = []
    for count, name in enumerate(names, 1):
        spent = Spent(count, count * 10.0, count, count * 10.0)
        earlier = [(before.failure.fault.name, before.do) for before in decisions]
        decisions.append(decide(failure(name), earlier, spent, policy, possible))
        assert decisions[-1].because
        if decisions[-1].do.is_lasting:
            break
    assert len(decisions) <= attempts
    assert all(d.do in possible or d.do.is_lasting for d in decisions)
    assert Do.ASK_OPERATOR in possible or decisions[-1].do is not Do.ASK_OPERATOR


def test_an_operator_who_does_not_answer_is_escalated_as_the_use_case_says():
    jam, blocked = FAULTS["insertion_jammed"], FAULTS["motion_blocked"]
    plain = policy_from({"unattended": "stop"})
    assert (plain.question.timeout_s, plain.unanswered_for(jam)) == (0.0, Do.STOP)
    timed = policy_from({"question": {"timeout_s": 600}})
    assert (timed.question.timeout_s, timed.unanswered_for(jam)) == (600.0, Do.SET_ASIDE)
    stopping = policy_from({"question": {"timeout_s": 600, "escalate": "stop"}})
    assert (stopping.unanswered_for(jam), stopping.unattended_for(jam)) == (Do.STOP, Do.SET_ASIDE)
    lenient = policy_from({"question": {"timeout_s": 600, "escalate": "set_aside"}})
    assert lenient.unanswered_for(blocked) is Do.STOP, "nothing may move there"


def test_an_answer_to_no_fault_is_refused():
    with pytest.raises(UseCaseError, match=r"recovery\.responses\.slip: there is no such fault"):
        Policy({"slip": (Response(Do.STOP),)}).require_known(FAULTS)


def test_a_use_case_states_its_policy():
    policy = policy_from(
        {
            "limits": {"task_attempts": 2},
            "unattended": "stop",
            "responses": {
                "insufficient_force": [
                    {"do": "retry_with", "change": {"force_limit": {"by": 2, "at_most": 35}}},
                    {"do": "ask_operator"},
                ]
            },
        }
    )
    assert policy.limits == Limits(task_attempts=2)
    assert policy.unattended is Do.STOP
    stated = policy.responses_to(FAULTS["insufficient_force"])
    assert stated[0].change == (("force_limit", Change(2.0, 35.0)),)
