"""A recorded run is told cause by cause."""

from datetime import datetime

import pytest

from remodel_planner.commands import explain
from remodel_planner.core.production import Component, Order, Side, Terminal, TerminalRef, Wire
from remodel_planner.core.recovery.fault import Do
from remodel_planner.core.recovery.history import Recovery
from remodel_planner.core.recovery.policy import Policy
from remodel_planner.core.run import Execution, Operation
from remodel_planner.core.run_story import RunRecord, tell
from remodel_planner.edge.fault_file import read_faults
from remodel_planner.edge.production_database import ProductionDatabase

ORDER = Order(
    "house",
    "",
    "house.qet",
    (
        Component("Q1", "", (Terminal("B1", Side.BOTTOM), Terminal("B2", Side.BOTTOM))),
        Component("Q2", "", (Terminal("T1", Side.TOP), Terminal("T2", Side.TOP))),
    ),
    (
        Wire("W1", TerminalRef("Q1", "B1"), TerminalRef("Q2", "T1"), "BU", 1.5, "line 1"),
        Wire("W2", TerminalRef("Q1", "B2"), TerminalRef("Q2", "T2"), "BU", 1.5, "line 2"),
    ),
)
FAULTS = read_faults()


def execution(wire, attempt, outcome, *codes):
    operations = tuple(
        Operation("/Connect a/Insert", "InsertCable", "failed", code, "stuck at 4 mm", 5.0, 1.0)
        for code in codes
    )
    placed = outcome == "finished"
    return Execution(wire, f"Place Wire {wire}", attempt, outcome, placed, 1.0, 9.5, operations)


@pytest.fixture
def url(tmp_path):
    url = f"sqlite:///{tmp_path}/production.sqlite"
    database = ProductionDatabase(url)
    database.add_order(ORDER)
    run = database.start_run(ORDER)
    recovery = Recovery(FAULTS, Policy())
    jammed = execution("W1", 1, "failed", 301)
    decision = recovery.decide(jammed, {Do.NEW_PART, Do.SET_ASIDE})
    database.add_execution(run, jammed, decision)
    database.add_execution(run, execution("W1", 2, "finished", 300))
    lost = execution("W2", 1, "aborted")
    database.add_execution(run, lost, recovery.decide(lost, {Do.SET_ASIDE}))
    database.close()
    return url


def test_a_run_is_told_cause_by_cause(url, capsys):
    assert explain.main(["1", "--database", url]) == 0
    head, *lines = capsys.readouterr().out.splitlines()
    assert head.startswith("run 1 of order house, begun ")
    assert head.endswith(" UTC: 2 wires, 3 attempts")
    assert lines == [
        "W1, attempt 1: Place Wire W1 ended failed after 8.5 s and 1 operation; "
        "the wire is not placed",
        "    /Connect a/Insert: InsertCable, error 301: stuck at 4 mm",
        "    it was insertion_jammed. " + FAULTS["insertion_jammed"].symptoms,
        "    so: new part, since answer 1 of 1 to insertion_jammed",
        "W1, attempt 2: Place Wire W1 ended finished after 8.5 s and 1 operation; "
        "the wire is placed",
        "    /Connect a/Insert: InsertCable, error 300: stuck at 4 mm",
        "    the behavior itself put it right",
        "W2, attempt 1: Place Wire W2 ended aborted after 8.5 s and 0 operations; "
        "the wire is not placed",
        "    it was result_contradictory. " + FAULTS["result_contradictory"].symptoms,
        "    so: set aside, since tried: nothing else fits; no operator to ask",
        "1 of 2 wires placed; not placed: W2",
    ]


def test_a_run_that_is_not_there_is_told_with_those_there_are(url, capsys):
    assert explain.main(["7", "--database", url]) == 3
    assert "there is no run 7; there are 1" in capsys.readouterr().err


def test_a_run_in_which_nothing_was_done_is_told():
    run = RunRecord(2, "house", datetime(2026, 1, 2, 3, 4, 5), ())
    assert list(tell(run, FAULTS))[-1] == "0 of 0 wires placed; all are placed"
