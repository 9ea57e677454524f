"""All views of a run show the same sums: Overview, Replay, Statistics, report and terminal."""

from collections import Counter
from datetime import datetime
from random import Random

import hypothesis.strategies as st
import pytest
import rospy
from hypothesis import given
from remodel_msgs.srv import GetTasksResponse
from test_run_report import report
from test_supervision import Run, live

from remodel_console.core.use_case import TaskCopy, figures
from remodel_console.ros.use_case_link import snapshot_of, summary_of, use_case_of
from remodel_planner.core.run_report import report_data
from remodel_run.progress import Count, HandWire, sums_words
from remodel_supervision.core.runs.event_table import attempts_of
from remodel_supervision.core.runs.events import (
    AsLeft,
    Command,
    Commanded,
    Interrupted,
    RunEnded,
    TaskElsewhere,
)
from remodel_supervision.core.runs.state import Stage
from remodel_supervision.core.runs.step import EndRun
from remodel_supervision.core.runs.sums import (
    begun_words,
    count_of,
    joined,
    statistics_of_run,
    sums_of,
)
from remodel_supervision.edge.run_log import RunHead
from remodel_supervision.ros.server.record_server import summary_message
from remodel_supervision.ros.server.state_publisher import (
    RunView,
    hand_wire_message,
    state_message,
    task_message,
)

NAMES = tuple(f"W{number}" for number in range(1, 9))
CABLES = {"W2": "C1", "W3": "C1", "W5": "C2", "W6": "C2", "W7": "C2"}
BY_HAND = tuple(
    HandWire(name, "", "Q1/1", "X3/2", "BU", section_mm2=35.0, length_m=0.5, reason="thick")
    for name in ("W9", "W10", "W11")
)


def shown(state):
    """Return a run as the console shows it."""
    view = RunView(1, state, "", None, "", rospy.Time(5), lambda name: 30.0, {})
    message = state_message(view)
    message.series = 7
    answer = GetTasksResponse(
        series=7,
        tasks=[task_message(view, name) for name in state.tasks],
        by_hand=[hand_wire_message(wire) for wire in state.by_hand],
    )
    return use_case_of(message, TaskCopy().with_snapshot(snapshot_of(answer)))


def stopped(run):
    """End a run at whatever point it is."""
    if run.state.ended is None:
        run.add(Commanded(Command.STOP, "", "ann"))
        assert isinstance(run.next, EndRun)
        run.add(RunEnded(run.next.ending, run.next.because))
    return run


def require_same_sums(run):
    """Compare what the views of a run show with each other, and with what happened."""
    state, use_case = run.state, shown(run.state)
    sums, attempts = sums_of(state), attempts_of(run.events)
    # what happened
    assert sums.tasks == sums.done_before + sums.done + sums.skipped + sums.interrupted + sums.open
    assert sums.taken_s == pytest.approx(sum(each.execution.cell_s for each in attempts))
    began = {each.execution.wire for each in attempts if each.part.is_attempt}
    counts = {name: count_of(task, state) for name, task in state.tasks.items()}
    assert {name for name, count in counts.items() if count is Count.DONE} <= began
    assert {name for name, count in counts.items() if count is Count.INTERRUPTED} <= began
    # Overview
    found = figures(use_case)
    assert use_case.sums == use_case.sums.__class__(**vars(sums))
    assert len(use_case.by_hand) == sums.by_hand
    assert Counter(task.counts_as.value for task in use_case.tasks) == Counter(
        count.value for count in counts.values()
    )
    assert len(found.tasks) == sums.tried
    assert sum(found.cycles_s) == pytest.approx(sums.done_s)
    assert len(found.cycles_s) == sums.first_passes + sums.recovered
    if found.yields:
        assert found.yields[-1] == use_case.sums.first_pass_yield == sums.first_pass_yield
    assert not [t for t in use_case.tasks if t.counts_as is Count.DONE_BEFORE and t.expected_s]
    # Replay
    head = RunHead(1, "house", "cell", datetime(2026, 1, 1), state.ended is not None)
    assert summary_of(summary_message(head, state)).sums == use_case.sums
    # Statistics
    statistics = joined([statistics_of_run(1, state, run.events)])
    assert [each for _, each in statistics.sums] == ([sums] if sums.tried else [])
    assert [share for _, share in statistics.yields] == list(found.yields[-1:])
    assert dict(statistics.wires) == dict(zip(found.done, found.cycles_s, strict=True))
    # report
    made = report_data(report(sums=sums))
    assert made["sums"] == vars(sums)
    assert (made["tasks_done"], made["first_pass"]) == (sums.done_in_all, sums.first_passes)
    assert made["cell_s"] == round(sums.taken_s, 1)


@given(st.integers(0, 10_000))
def test_all_views_show_the_same_sums_of_20_runs_that_continue_each_other(seed):
    random, done = Random(seed), ()
    for _ in range(20):
        run = Run(*NAMES, cables=CABLES, done=done, by_hand=BY_HAND)
        require_same_sums(run)
        for name in run.state.waiting:
            if random.random() < 0.05:
                as_left = random.choice([AsLeft.DONE, AsLeft.SET_ASIDE])
                run.add(TaskElsewhere(name, "other", as_left))
            elif random.random() < 0.05:
                run.add(Commanded(Command.SKIP, name, "ann"))
        live(run, random, steps=random.randint(0, 60))
        require_same_sums(run)
        require_same_sums(stopped(run))
        done = run.state.in_stage(Stage.DONE)
        done = () if len(done) == len(NAMES) else done


def test_a_run_that_is_continued_counts_only_what_it_does_itself():
    run = Run("W1", "W2", "W3", done=("W1", "W2"), by_hand=BY_HAND)
    begun = "3 tasks, 2 of them done before, 3 wires by hand"
    assert begun_words(run.events[0]) == begun
    use_case = shown(run.state)
    assert [(task.words, task.expected_s) for task in use_case.tasks] == [
        ("done before", 0.0),
        ("done before", 0.0),
        ("waiting", 30.0),
    ]
    run.plan()
    run.begin("W3")
    run.end("W3")
    found = figures(shown(run.state))
    assert (found.tasks, found.yields, found.cycles_s) == (("W3",), (1.0,), (1.0,))
    assert run.next.because == (
        "all tasks of the cell are done; still to be placed by hand: 3 wires, W9, W10, W11"
    )
    assert (
        sums_words(sums_of(run.state))
        == "3 of 3 tasks done, 2 of them before this run, 3 wires by hand"
    )


def test_what_a_run_began_and_did_not_end_is_interrupted():
    run = Run("W1", "W2", "W3")
    run.plan()
    run.begin("W1")
    run.end("W1")
    run.begin("W2")
    run.add(Interrupted("killed"))
    assert sums_words(sums_of(run.state)) == "1 of 3 tasks done"
    stopped(run)
    assert sums_words(sums_of(run.state)) == "1 of 3 tasks done, 1 interrupted"
    assert [task.words for task in shown(run.state).tasks] == ["done", "interrupted", "waiting"]
