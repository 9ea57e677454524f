"""A recorded run is explained cause by cause, and plays back to itself."""

import pytest
from house import HOUSE, owner_of

from remodel_planner.commands import explain
from remodel_planner.commands.runs import replay
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_run.progress import Answer
from remodel_run.whole_task import counted
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import (
    Answered,
    Asked,
    AsLeft,
    Command,
    Commanded,
    Decided,
    Ending,
    Interrupted,
    OperationEnded,
    Part,
    Planned,
    RunBegun,
    RunEnded,
    Settled,
    TaskBegun,
    TaskElsewhere,
    TaskEnded,
)
from remodel_supervision.edge.run_log import RunLog
from remodel_tasks.core.use_case.fault import Do
from remodel_tasks.edge.fault_file import read_faults

FAULTS = read_faults()
CHART = """<statemachine name="Place Wire" initial="Insert">
  <datamodel><outcome name="finished"/><outcome name="failed"/></datamodel>
  <state id="Insert" type="InsertCableState">
    <transition event="inserted" target="finished"/>
    <transition event="failed" target="failed"/>
  </state>
</statemachine>"""


def begun(task, attempt, part=Part.WHOLE):
    return TaskBegun(task, attempt, part, f"Place Wire {task}", chart=CHART, at_s=1.0)


def operation(outcome, code):
    said = "stuck at 4 mm" if code else "done"
    asked, found = (("force_limit", "8.0"),), (("depth", "0.004"), ("peak_force", "8.2"))
    return Operation("/Insert", "InsertCable", outcome, code, said, 5.0, 1.0, "", asked, found)


RUN = (
    Planned(("W1", "W2"), "the run begins"),
    begun("W1", 1),
    OperationEnded("W1", operation("failed", 301)),
    TaskEnded("W1", "failed", 9.5, False, path=("/Insert",)),
    Decided(
        "W1",
        "insertion_jammed",
        301,
        "InsertCable",
        state_path="/Insert",
        text="stuck at 4 mm",
        do=Do.ASK_OPERATOR,
        change=(),
        because="nothing else fits",
        by="policy",
        at_s=9.5,
    ),
    Asked(1, "W1", "W1 failed", (Answer.RETRY, Answer.SKIP)),
    Answered(1, Answer.RETRY, "ann"),
    Settled("W1", ("a",), 3),
    begun("W1", 2, Part.REST),
    Interrupted("the engine is gone"),
    begun("W1", 2, Part.CLEAR),
    OperationEnded("W1", operation("failed", 204)),
    TaskEnded("W1", "failed", 9.6, False),
    Settled("W1", ("a", "b"), 0),
    Commanded(Command.PAUSE, "", "ann"),
    Commanded(Command.RESUME, "", "ann"),
    TaskElsewhere("W2", "other", AsLeft.SET_ASIDE),
    RunEnded(Ending.INCOMPLETE, "set aside: W2"),
)


@pytest.fixture
def keep(database):
    """Return a function that keeps a run of some events."""

    def keep(*events):
        opened = ProductionDatabase(database)
        opened.add_order(HOUSE)
        first = RunBegun("house", "cabinet", "cell", ("W1", "W2"))
        log, state = RunLog(opened), state_after([first])
        owner = owner_of(opened)
        run, _ = log.begin(first, owner)
        for event in events:
            state = log.append(run, event, state, owner)
        opened.close()

    return keep


def test_a_run_is_explained_cause_by_cause(keep, database, capsys):
    keep(*RUN)
    assert explain.main(["1", "--database", database]) == 0
    head, *lines = capsys.readouterr().out.splitlines()
    assert head.startswith("run 1 of order house in cell cell, begun ")
    assert head.endswith(" UTC: 2 tasks, 3 behaviors")
    assert lines == [
        "The cell planned: W1 W2, because the run begins.",
        "W1, attempt 1: Place Wire W1 ended failed after 8.5 s and 1 operation",
        "    /Insert: InsertCable, error 301: stuck at 4 mm",
        "        asked for: force_limit 8.0",
        "        found: depth 0.004, peak_force 8.2",
        "    it was insertion_jammed. " + FAULTS["insertion_jammed"].symptoms,
        "    The cell asks you, because nothing else fits.",
        "W1: asked: W1 failed (retry, skip)",
        "ann: answered: retry",
        "W1: inspected: end a connected; 3 steps left",
        "W1, attempt 2: Place Wire W1 ended interrupted after 0.0 s and 0 operations",
        "interrupted: the engine is gone",
        "W1, attempt 2: Place Wire W1 ended failed after 8.6 s and 1 operation",
        "    /Insert: InsertCable, error 204: stuck at 4 mm",
        "        asked for: force_limit 8.0",
        "        found: depth 0.004, peak_force 8.2",
        "W1: inspected: end a and end b connected; it is done",
        "ann: pause",
        "ann: resume",
        "W2: cell other has skipped it",
        "ended incomplete: set aside: W2",
        "1 of 2 tasks done, 1 skipped; not done: W2",
    ]


def test_a_run_plays_back_to_itself(keep, database, capsys):
    keep(*RUN)
    assert replay.main(["1", "--database", database]) == 0
    *lines, last = capsys.readouterr().out.splitlines()
    assert len(lines) == len(RUN) + 1
    assert last == "19 events, 3 behaviors, 0 differences"


@pytest.mark.parametrize(
    ("position", "event", "differs"),
    [
        (1, begun("W2", 1), "event 2, TaskBegun: next was Execute(task='W1'"),
        (2, OperationEnded("W2", operation("failed", 301)), "W2 was not under way"),
        (3, TaskEnded("W1", "failed", 9.5, False, path=("/Other",)), "the engine entered []"),
        (3, TaskEnded("W1", "finished", 9.5, True), "the chart leads to failed"),
        (6, Answered(1, Answer.STOP, "ann"), "has no such answer"),
    ],
)
def test_a_record_that_was_tampered_with_differs(keep, database, capsys, position, event, differs):
    events_of_run = list(RUN[: position + 1])
    events_of_run[position] = event
    keep(*events_of_run)
    assert replay.main(["1", "--quiet", "--database", database]) == 1
    assert differs in capsys.readouterr().out


@pytest.mark.parametrize(("code", "differs"), [(4, 0), (301, 1)])
def test_what_is_refused_after_a_server_was_lost_needs_no_record(
    keep, database, capsys, code, differs
):
    lay_down = """<state id="Lay" type="PlaceCableState">
      <transition event="placed" target="failed"/></state></statemachine>"""
    chart = CHART.replace('"failed" target="failed"', '"failed" target="Lay"')
    chart = chart.replace("</statemachine>", lay_down)
    keep(
        Planned(("W1", "W2"), "the run begins"),
        TaskBegun("W1", 1, Part.WHOLE, "Place Wire W1", chart=chart, at_s=1.0),
        OperationEnded("W1", operation("failed", code)),
        TaskEnded("W1", "failed", 9.5, False, path=("/Insert", "/Lay")),
    )
    assert replay.main(["1", "--quiet", "--database", database]) == differs
    assert f", {counted(differs, 'difference')}\n" in capsys.readouterr().out


@pytest.mark.parametrize("command", [explain, replay])
def test_for_a_missing_run_the_existing_ones_are_named(command, keep, database, capsys):
    keep()
    assert command.main(["7", "--database", database]) == 1
    assert "there is no record of run 7; there are 1" in capsys.readouterr().err


def test_a_run_in_which_nothing_was_done_is_explained(keep, database, capsys):
    keep()
    assert explain.main(["1", "--database", database]) == 0
    assert capsys.readouterr().out.endswith("0 of 2 tasks done; not done: W1 W2\n")
