"""A task that fails is tried again with a new wire, and not for ever."""

import os
import sqlite3
from pathlib import Path

import pytest
from sensor_msgs.msg import Image

from remodel_planner.core.cell_order import USE_CASE, cell_order
from remodel_planner.core.panel_layout import PanelRules, lay_out
from remodel_planner.core.production import Component, Order, Side, Terminal, TerminalRef, Wire
from remodel_planner.core.recovery.fault import Do, Response
from remodel_planner.core.recovery.history import Recovery
from remodel_planner.core.recovery.policy import Policy
from remodel_planner.core.use_case.planned_tasks import planned_tasks
from remodel_planner.core.use_case.preparation import prepare
from remodel_planner.core.use_case.task_chart import content_mark
from remodel_planner.edge.catalogue_file import read_catalogue
from remodel_planner.edge.fault_file import read_faults
from remodel_planner.edge.order_planner import plan_problem
from remodel_planner.edge.production_database import ProductionDatabase
from remodel_planner.edge.use_case_files import find_use_case
from remodel_planner.errors import CellError
from remodel_planner.ros import use_case_supervisor
from remodel_planner.ros.task_supervisor import TaskRun

CATALOGUE = read_catalogue(Path(__file__).parents[2] / "config" / "catalogue.yaml")
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
LAYOUT = lay_out(ORDER, CATALOGUE, PanelRules())

PREPARED = prepare(cell_order(LAYOUT), find_use_case(USE_CASE))
TASKS = tuple(planned_tasks(PREPARED, plan_problem(PREPARED.preferred.problem, 0.0).plan))


PLAIN = Policy()


def answering(*responses):
    """Return a policy that answers so to tasks that fail without a reason."""
    return Policy({"result_contradictory": responses})


class FakeCell:
    """A cell in which the wires lie that were fed."""

    def __init__(self):
        self.fed = []

    def load(self, panel):
        self.panel = panel

    def feed(self, wire, channel):
        if len(self.fed) == FakeTasks.stuck_after:
            raise CellError("cannot feed: the gripper holds a wire")
        self.fed.append(wire)

    def placed(self, wire):
        return FakeTasks.ended[-1] == "finished"

    def picture(self, camera):
        return Image()


class FakeSynthesizer:
    asked = ()

    def synthesize(self, chart_file, behavior):
        assert Path(chart_file).is_file()
        FakeSynthesizer.asked += (behavior,)


class FakeTasks:
    """Ends the tasks that are run as it was told, in turn."""

    outcomes, ended, stuck_after = (), [], -1

    def run(self, behavior):
        FakeTasks.ended.append(FakeTasks.outcomes[len(FakeTasks.ended)])
        return TaskRun(FakeTasks.ended[-1], 1.0, 2.0, (), ())


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Return a function: it runs the order, its tasks ending as told, and returns the runs."""
    monkeypatch.setattr(use_case_supervisor, "Cell", FakeCell)
    monkeypatch.setattr(use_case_supervisor, "BehaviorSynthesizer", FakeSynthesizer)
    monkeypatch.setattr(use_case_supervisor, "TaskSupervisor", FakeTasks)
    database = ProductionDatabase(f"sqlite:///{tmp_path}/production.sqlite")
    database.add_order(ORDER)

    def replan(names):
        return [task for task in TASKS if task.name in names]

    def run(*outcomes, stuck_after=-1, policy=PLAIN):
        FakeSynthesizer.asked = ()
        FakeTasks.outcomes, FakeTasks.ended, FakeTasks.stuck_after = outcomes, [], stuck_after
        recovery = Recovery(read_faults(), policy)
        supervisor = use_case_supervisor.UseCaseSupervisor(database, tmp_path, recovery, replan)
        started = database.start_run(ORDER)
        for wire_run in supervisor.run(started, LAYOUT, PanelRules(), TASKS):
            execution = wire_run.execution
            yield execution.wire, execution.attempt, execution.placed, wire_run.last

    yield run
    database.close()


def test_a_failed_task_takes_a_new_wire(run):
    first, second, third = run("failed", "finished", "finished")
    assert first[1:] == (1, False, False)
    assert second == (first[0], 2, True, True)
    assert third[0] != first[0]
    assert third[1:] == (1, True, True)


def test_a_wire_that_cannot_be_placed_is_given_up_and_the_next_one_goes_on(run):
    runs = list(run("failed", "failed", "failed", "finished"))
    assert [attempt for _, attempt, _, _ in runs] == [1, 2, 3, 1]
    assert [last for *_, last in runs] == [False, False, True, True]


def test_what_its_policy_puts_off_is_done_when_the_rest_is(run):
    policy = answering(Response(Do.REPLAN), Response(Do.SET_ASIDE))
    first, second, third = run("failed", "finished", "finished", policy=policy)
    assert (first[0], first[3]) == (third[0], False)
    assert second[1:] == (1, True, True)
    assert third[1:] == (2, True, True)


def test_nothing_is_put_off_behind_nothing(run):
    policy = answering(Response(Do.REPLAN, times=9), Response(Do.SET_ASIDE))
    runs = list(run("finished", "failed", policy=policy))
    assert [last for *_, last in runs] == [True, True]


def test_its_policy_may_stop_the_run(run):
    runs = list(run("failed", policy=answering(Response(Do.STOP))))
    assert len(runs) == 1


def test_a_behavior_that_somebody_stops_ends_the_run(run):
    (only,) = run("preempted", "finished")
    assert only[1:] == (1, False, True)


def test_decisions_are_kept_with_their_reasons(run, tmp_path):
    list(run("failed", "finished", "finished"))
    kept = sqlite3.connect(tmp_path / "production.sqlite").execute("SELECT * FROM decisions")
    (row,) = kept.fetchall()
    assert row[2:] == (
        "result_contradictory",
        5,
        "the behavior ended failed",
        "new_part",
        "answer 1 of 2 to result_contradictory",
    )


def test_a_cell_that_refuses_ends_the_run_after_what_was_done(run):
    runs = run("failed", stuck_after=1)
    assert next(runs)[1:] == (1, False, False)
    with pytest.raises(CellError, match="the gripper holds a wire"):
        next(runs)


MANIFEST = """<?xml version="1.0"?>
<behavior name="{name}"><description>A wire.\n{mark}</description></behavior>
"""
PACKAGE = """<package format="3"><name>made</name><version>0.0.0</version>
<description>x</description><maintainer email="a@b.c">a</maintainer><license>BSD</license>
<export><flexbe_behaviors/></export></package>"""


def test_a_behavior_that_exists_with_the_same_content_is_not_made_again(run, tmp_path, monkeypatch):
    first, second = TASKS
    manifests = tmp_path / "made" / "manifest"
    manifests.mkdir(parents=True)
    (tmp_path / "made" / "package.xml").write_text(PACKAGE)
    (manifests / "broken.xml").write_text("<behavior")
    for task, mark in ((first, content_mark(first.chart)), (second, "Content 0000.")):
        text = MANIFEST.format(name=task.chart.name, mark=mark)
        (manifests / f"{task.name}.xml").write_text(text)
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{tmp_path}:{os.environ['ROS_PACKAGE_PATH']}")
    assert len(list(run("finished", "finished"))) == 2
    assert FakeSynthesizer.asked == (second.chart.name,)
