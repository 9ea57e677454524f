"""Statistics across runs; no ROS."""

import pytest

from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import (
    OperationEnded,
    Part,
    Planned,
    RunBegun,
    TaskBegun,
    TaskEnded,
)
from remodel_supervision.core.runs.state import FINISHED
from remodel_supervision.core.runs.sums import joined, statistics_of_run


def operation(task, terminal, code, ability="InsertCable", ended_s=0.0, elapsed_s=0.0):
    component, name = terminal.split("/")
    parameters = (("component_id", component), ("terminal_id", name))
    return OperationEnded(
        task,
        Operation(
            "/Insert", ability, outcome="x", error_code=code, text="", ended_s=ended_s,
            elapsed_s=elapsed_s, parameters=parameters,
        ),
    )  # fmt: skip


def attempt(task, number, took_s, *operations, outcome=FINISHED):
    begun = TaskBegun(task, number, part=Part.WHOLE, behavior="B", chart="", at_s=0.0)
    return [begun, *operations, TaskEnded(task, outcome, took_s, placed=outcome == FINISHED)]


def a_run(*events):
    names = ("W1", "W2")
    return [RunBegun("o", "cabinet", "cell 1", names), Planned(names, ""), *events]


def of_run(number, *events):
    events = a_run(*events)
    return statistics_of_run(number, state_after(events), events)


def test_terminals_yields_and_times_of_several_runs():
    first = of_run(
        1,
        *attempt("W1", 1, 40.0, operation("W1", "K1/A1", 0)),
        *attempt("W2", 1, 10.0, operation("W2", "K1/A2", 303), outcome="failed"),
        *attempt("W2", 2, 50.0, operation("W2", "K1/A2", 0), operation("W2", "Q1/2", 0)),
    )
    second = of_run(
        2,
        *attempt(
            "W1", 1, 20.0, operation("W1", "K1/A1", 0), operation("W1", "Q1/9", 7, "PickCable")
        ),
    )
    found = joined([second, first, of_run(3)])
    assert found.terminals == (("K1/A2", 2, 1), ("K1/A1", 2, 0), ("Q1/2", 1, 0))
    assert [run for run, _ in found.yields] == [1, 2]  # in the third no task has ended
    assert found.yields[0][1] == pytest.approx(0.5)
    assert [wire for wire, _ in found.wires] == ["W2", "W1"]
    assert dict(found.wires)["W1"] == pytest.approx(30.0)


def test_the_utilisation_counts_time_in_which_several_arms_work_once():
    spans = ((10.0, 10.0), (12.0, 4.0), (20.0, 5.0))  # 0 to 10, 8 to 12, 15 to 20 [s]
    operations = (operation("W1", "K1/A1", 0, ended_s=e, elapsed_s=s) for e, s in spans)
    found = joined([of_run(1, *attempt("W1", 1, 40.0, *operations)), of_run(2)])
    assert found.utilisations == ((1, pytest.approx(0.85)),)


def test_without_runs_there_is_nothing():
    found = joined([])
    assert (found.yields, found.utilisations) == ((), ())
    assert (found.terminals, found.wires) == ((), ())
