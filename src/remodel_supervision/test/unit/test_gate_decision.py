"""What closes the gate, in which order, and which event records what it stopped."""

from dataclasses import fields, replace

import pytest

from remodel_states.core.codes import Code
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import (
    AsLeft,
    Blocked,
    Interrupted,
    Part,
    StopReported,
    TaskElsewhere,
)
from remodel_supervision.core.runs.gate import (
    Circumstances,
    cut_short_event,
    decide_halt,
    decide_hold,
    is_cut_short,
    late_stop_event,
)
from remodel_supervision.core.runs.state import RunState, Stage, TaskProgress

FAULT = Operation("/Insert", "InsertCable", "failed", Code.MOTION_FAULT, "hit", 2.0, 1.0, "7:a#1")
RUN_FIELDS = {each.name for each in fields(RunState)}
RUNNING = TaskProgress("W1", Stage.RUNNING)


def state_with(task=RUNNING, **changes):
    """Return the state of a run whose current task is this one."""
    return RunState(tasks={"W1": task}, current="W1", **changes)


def test_nothing_closes_the_gate_of_a_task_that_runs():
    assert decide_halt(state_with(), Circumstances()) == ""
    assert decide_hold(state_with(), Circumstances()) == ""


# What closes the gate, the most important first: how the run or its circumstances change by it.
REASONS = {
    "another owner": {"disowned": "another owner"},
    "protective stop by ann": {"protective": "ann"},
    "ben stopped it": {"stop": "ben stopped it"},
    "the lease ran out": {"lost_lease": "the lease ran out"},
    f"InsertCable ended with error {FAULT.error_code}; a person is to answer": {
        "tasks": {"W1": replace(RUNNING, stopped_by=FAULT)}
    },
    "cid skipped the task": {"skipped": {"W1": "cid"}},
    "the run's time limit has passed": {"is_overdue": True},
}


@pytest.mark.parametrize("first", range(len(REASONS)))
def test_the_most_important_reason_to_halt_is_given(first):
    changes = {}
    for reason in list(REASONS.values())[first:]:
        changes |= reason
    about_run = {name: changes.pop(name) for name in list(changes) if name in RUN_FIELDS}
    state, now = replace(state_with(), **about_run), Circumstances(**changes)
    assert decide_halt(state, now) == list(REASONS)[first]


@pytest.mark.parametrize("part", [Part.CLEAR, Part.DISCARD])
def test_a_skip_does_not_stop_what_empties_the_hand(part):
    state = state_with(replace(RUNNING, part=part), skipped={"W1": "cid"})
    assert decide_halt(state, Circumstances()) == ""


def test_the_skip_of_a_task_that_does_not_run_stops_nothing():
    state = state_with(replace(RUNNING, stage=Stage.READY), skipped={"W1": "cid"})
    assert decide_halt(state, Circumstances()) == ""


def test_a_pause_holds_and_so_does_a_server_that_does_not_rest():
    stalled = Circumstances(unrested=("the server of PickCable", "the server of FixCable"))
    assert decide_hold(state_with(paused=True), stalled) == "the run is paused"
    names = "the server of PickCable, the server of FixCable"
    assert decide_hold(state_with(), stalled) == f"not at rest: {names}"
    assert decide_halt(state_with(paused=True), stalled) == "", "what runs may end"


@pytest.mark.parametrize(
    ("changes", "halted", "now", "expected"),
    [
        ({}, "", Circumstances(), False),
        ({}, "a protective stop that is over", Circumstances(), True),
        ({"stop": "ben stopped it"}, "ben stopped it", Circumstances(), False),
        ({"skipped": {"W1": "cid"}}, "cid skipped the task", Circumstances(), False),
        ({"skipped": {"W2": "cid"}}, "the run's time limit has passed", Circumstances(), True),
        ({"protective": "ann", "stop": "ben stopped it"}, "", Circumstances(), True),
        ({"stop": "ben stopped it"}, "", Circumstances(disowned="another owner"), True),
        ({"stop": "ben stopped it"}, "", Circumstances(lost_lease="the lease ran out"), True),
    ],
)
def test_a_behavior_is_cut_short_by_what_is_neither_a_stop_nor_a_skip(
    changes, halted, now, expected
):
    assert is_cut_short(state_with(**changes), "W1", halted, now) is expected


def test_a_behavior_that_was_cut_short_is_interrupted_unless_another_cell_has_its_task():
    assert cut_short_event("W1", "the run's time limit has passed", Circumstances()) == Interrupted(
        "the run's time limit has passed"
    )
    taken = Circumstances(lost_lease="another cell has taken over task W1", is_taken_over=True)
    assert cut_short_event("W1", "", taken) == TaskElsewhere("W1", "", AsLeft.RUNNING)


def test_a_late_stop_is_reported_of_the_task_under_way_once():
    assert late_stop_event(state_with(), FAULT) == StopReported("W1", FAULT)
    other = replace(FAULT, goal_id="7:a#2")
    for task in (replace(RUNNING, operations=(FAULT,)), replace(RUNNING, stopped_by=FAULT)):
        assert late_stop_event(state_with(task), FAULT) is None
        assert late_stop_event(state_with(task), other) == StopReported("W1", other)


def test_a_record_that_says_cancelled_does_not_hide_a_late_stop():
    cancelled = replace(FAULT, error_code=Code.PREEMPTED)
    task = replace(RUNNING, operations=(cancelled,))
    assert late_stop_event(state_with(task), FAULT) == StopReported("W1", FAULT)


def test_a_late_stop_between_tasks_ends_the_run():
    because = f"InsertCable ended with error {FAULT.error_code}: hit; a person is needed"
    assert late_stop_event(RunState(), FAULT) == Blocked(because)
