"""The supervisor does what comes next, keeps it, waits for what is lost, and goes on."""

import os
import threading
from pathlib import Path

import pytest
from house import HOUSE
from remodel_planner.ros.use_case_supervisor import Peers, UseCaseSupervisor, Work
from sensor_msgs.msg import Image

from flexbe_synthesizer.core.names import behavior_file
from remodel_planner.core.cell_order import USE_CASE, cell_order
from remodel_planner.core.learning.experience import Experience
from remodel_planner.core.learning.learned_responses import TriedResponse
from remodel_planner.core.panel_layout import PanelRules, lay_out
from remodel_planner.core.recovery.fault import Do
from remodel_planner.core.run import Operation
from remodel_planner.core.supervision.attempts import attempts_of
from remodel_planner.core.supervision.events import (
    Answer,
    Answered,
    Blocked,
    Command,
    Commanded,
    Decided,
    Ending,
    Interrupted,
    OperationEnded,
    Part,
    Planned,
    RunBegun,
    Settled,
    TaskBegun,
    TaskElsewhere,
)
from remodel_planner.core.supervision.state import Stage, cause_of, state_after
from remodel_planner.core.use_case.task_chart import content_mark
from remodel_planner.edge.catalogue_file import read_catalogue
from remodel_planner.edge.fault_file import read_faults
from remodel_planner.edge.production_database import ProductionDatabase
from remodel_planner.edge.run_log import RunLog
from remodel_planner.edge.task_leases import TaskLeases
from remodel_planner.edge.use_case_files import find_use_case
from remodel_planner.edge.work_planner import WorkPlanner
from remodel_planner.errors import CellError, LostError
from remodel_planner.ros import use_case_supervisor
from remodel_planner.ros.inspection import UnseenError
from remodel_planner.ros.panel_message import panel_message

CATALOGUE = read_catalogue(Path(__file__).parents[2] / "config" / "catalogue.yaml")
LAYOUT = lay_out(HOUSE, CATALOGUE, PanelRules())
JAM, LOST, SLIPPED, MISSING = 301, 4, 303, 103


class FakeCell:
    """A cell in which the wires lie that were fed."""

    def __init__(self):
        self.fed, self.loaded, self.trouble = [], [], None
        self.at = "rosrpc://cell:1"

    def wait(self, limit_s):
        pass

    def address(self):
        return self.at

    def load(self, panel, *, keep):
        self.loaded.append(keep)

    def feed(self, wire, channel):
        if self.trouble:
            raise self.trouble
        self.fed.append((wire, channel))

    def placed(self, wire):
        return True

    def picture(self, camera):
        return Image()


class FakeSynthesizer:
    def __init__(self):
        self.asked = []

    def wait(self, limit_s):
        pass

    def synthesize(self, chart_file, behavior):
        assert Path(chart_file).is_file()
        self.asked.append(behavior)


class FakeAbilities:
    """Their servers are away for some looks."""

    latest = None

    def __init__(self):
        self.away = 0

    def is_there(self, ability):
        self.away -= 1
        return self.away < 0


class FakeTasks:
    """Ends behaviors as it is told, in turn: an outcome, an error code, a loss, or a call."""

    def __init__(self):
        self.endings, self.ran, self.paused, self.stopped = [], [], [], 0
        self.back = True
        self.abilities = FakeAbilities()

    def recording(self, *, settling):
        return threading.Lock()

    def wait(self, limit_s):
        if not self.back:
            raise LostError("the engine does not come back")

    def run(self, behavior, keep, is_to_stop):
        self.ran.append(behavior)
        ending = self.endings.pop(0) if self.endings else "finished"
        if behavior.endswith(" Clear"):
            return "failed"
        if callable(ending):
            ending()
            return "preempted" if is_to_stop() else "finished"
        if isinstance(ending, Exception):
            raise ending
        if isinstance(ending, int):
            keep(
                Operation("/Connect a/InsertCable", "InsertCable", "failed", ending, "no", 2.0, 1.0)
            )
            return "failed"
        return ending

    def stop_all(self):
        self.stopped += 1

    def pause(self, paused):
        self.paused.append(paused)

    def sights(self):
        return ()

    def path(self):
        return ("/Find wire",)

    state_path = ""


class FakeInspection:
    """Sees the ends that it is told are connected."""

    def __init__(self):
        self.connected, self.trouble = set(), None

    def wait(self, limit_s):
        pass

    def is_connected(self, wire, end, component, terminal):
        if self.trouble:
            raise self.trouble
        return (wire, end) in self.connected


class Bench:
    """A supervisor of the order, with everything beside it faked but the database."""

    def __init__(self, url, folder, attended=False, explore=False, **options):
        self.database = ProductionDatabase(url)
        self.log = RunLog(self.database)
        use_case = find_use_case(USE_CASE)
        experience = Experience(use_case, self.database.ability_calls(), explore=explore)
        self.peers = Peers(FakeCell(), FakeSynthesizer(), FakeTasks(), FakeInspection())
        self.leases = TaskLeases(self.database, "house", "cell", 30.0)
        self.work = Work(
            WorkPlanner(cell_order(LAYOUT), use_case, experience, 0.0),
            read_faults(),
            panel_message(LAYOUT, PanelRules()),
            keep_panel=False,
            channels={cut.wire.name: cut.channel for cut in LAYOUT.wires},
            leases=self.leases,
            charts=folder / "charts",
            attended=attended,
            patience_s=0.1,
            **options,
        )
        begun = RunBegun("house", USE_CASE, "cell", ("W1", "W2"))
        self.number = self.log.begin(begun)
        self.take_up()

    def take_up(self):
        """Have a new supervisor take the run up."""
        state = state_after(kept.event for kept in self.log.events(self.number))
        self.supervisor = UseCaseSupervisor(
            self.number, state, self.log, self.work, self.peers, lambda *_: (), lambda: None
        )

    def run(self, *endings):
        """Let behaviors end so, and return the run's state when it has ended."""
        self.peers.tasks.endings = list(endings)
        return self.supervisor.supervise()

    def events(self, *kinds):
        return [k.event for k in self.log.events(self.number) if isinstance(k.event, kinds)]

    @property
    def ran(self):
        return [name.removeprefix("Place Wire ") for name in self.peers.tasks.ran]


@pytest.fixture
def url(tmp_path, monkeypatch):
    monkeypatch.setattr(use_case_supervisor.rospy, "get_time", lambda: 1.0)
    monkeypatch.setattr(use_case_supervisor.rospy, "is_shutdown", lambda: False)
    url = f"sqlite:///{tmp_path}/production.sqlite"
    database = ProductionDatabase(url)
    database.add_order(HOUSE)
    database.close()
    return url


@pytest.fixture
def bench(url, tmp_path):
    bench = Bench(url, tmp_path)
    yield bench
    bench.database.close()


def test_an_order_is_done_task_by_task(bench):
    state = bench.run()
    assert state.ended.ending is Ending.COMPLETE
    first, second = bench.events(Planned)[0].tasks
    assert bench.ran == [first, second]
    assert [wire for wire, _ in bench.peers.cell.fed] == [first, second]
    assert bench.peers.cell.loaded == [False]
    assert [name.removeprefix("Place Wire ") for name in bench.peers.synthesizer.asked] == bench.ran
    attempts = attempts_of(bench.events(object))
    assert [attempt.path for attempt in attempts] == [("/Find wire",)] * 2


def test_each_event_is_kept_before_what_follows_begins(bench):
    def look():
        begun = bench.events(TaskBegun)
        assert [event.task for event in begun] == bench.ran, "kept before the goal is sent"
        assert "<statemachine" in begun[-1].chart

    assert bench.run(look, look).ended.ending is Ending.COMPLETE


def test_a_second_jam_ends_the_task_and_no_new_wire_is_fed(bench):
    state = bench.run(JAM, JAM)
    first = bench.events(Planned)[0].tasks[0]
    decided = [(event.task, event.do) for event in bench.events(Decided)]
    assert decided == [(first, Do.LOOK_AGAIN), (first, Do.SET_ASIDE)]
    assert [wire for wire, _ in bench.peers.cell.fed].count(first) == 1
    assert state.ended.ending is Ending.INCOMPLETE


def test_a_task_whose_order_is_planned_anew_comes_later(bench):
    state = bench.run(MISSING)
    before, after = (event.tasks for event in bench.events(Planned))
    first, second = before
    assert after == (second, first)
    assert bench.ran == [first, second, first]
    assert state.ended.ending is Ending.COMPLETE


def test_a_lost_server_may_come_back_before_the_next_try(bench):
    bench.peers.tasks.abilities.away = 2
    state = bench.run(LOST)
    assert bench.peers.tasks.abilities.away < 0, "it was waited for"
    assert [event.do for event in bench.events(Decided)] == [Do.LOOK_AGAIN]
    assert state.ended.ending is Ending.COMPLETE


def test_a_lost_server_is_not_waited_for_beyond_the_patience(bench):
    bench.peers.tasks.abilities.away = 1000
    assert bench.run(LOST).ended.ending is Ending.COMPLETE
    assert bench.peers.tasks.abilities.away > 900


def test_what_is_connected_is_not_connected_again(bench):
    first = bench.work.planner.plan(["W1", "W2"])[0]
    bench.peers.inspection.connected = {(first, "a")}
    bench.run(JAM)
    assert bench.ran[:2] == [first, f"{first} Rest"]
    chart = next(e.chart for e in bench.events(TaskBegun) if e.part is Part.REST)
    assert 'id="Connect b"' in chart
    assert 'id="Connect a"' not in chart
    assert 'id="Pick b"' in chart


def test_a_learning_supervisor_tells_what_it_chose_and_learns_from_it(url, tmp_path):
    bench = Bench(url, tmp_path, explore=True)
    state = bench.run(*[SLIPPED] * 2)
    assert state.ended.ending is Ending.COMPLETE
    chosen = [(event, each) for event in bench.events(TaskBegun) for each in event.chosen]
    assert chosen, "one of five attempts at two ends tries another force"
    for event, each in chosen:
        assert (each.ability, each.parameter) == ("InsertCable", "force_limit")
        assert 4.0 <= each.value <= 16.0
        assert f'name="force_limit" value="{each.value}"' in event.chart
    slips = [k for k in bench.events(OperationEnded) if k.operation.error_code == SLIPPED]
    assert bench.work.planner.experience.expectations.calls == len(slips) == 2
    bench.database.close()


def test_a_response_that_never_helped_is_not_given_again(url, tmp_path):
    bench = Bench(url, tmp_path, explore=True)
    bench.log.tried_responses = lambda: (
        (TriedResponse("slipped", Do.LOOK_AGAIN, helped=False),) * 30
    )
    bench.run(SLIPPED)
    decided = bench.events(Decided)
    assert decided[0].do is Do.NEW_PART
    assert "look again spared" in decided[0].because
    bench.database.close()


def test_a_run_goes_on_when_what_was_lost_comes_back(bench):
    state = bench.run(LostError("the engine is gone"))
    first = bench.events(Planned)[0].tasks[0]
    assert bench.ran[:3] == [first, f"{first} Clear", first]
    assert [event.because for event in bench.events(Interrupted)] == ["the engine is gone"]
    assert bench.peers.tasks.stopped >= 1
    assert state.ended.ending is Ending.COMPLETE
    assert bench.peers.cell.loaded == [False, True], "what is on the panel stays"


def test_a_cell_that_was_started_anew_gets_its_panel_again(bench):
    def start_anew():
        bench.peers.cell.at = "rosrpc://cell:2"

    assert bench.run(start_anew).ended.ending is Ending.COMPLETE
    assert bench.peers.cell.loaded == [False, True], "before the second wire, with the first on it"


def test_a_server_that_died_is_the_cause_and_not_what_its_heir_does_not_know():
    lost = Operation("/Connect a/InsertCable", "InsertCable", "failed", LOST, "away", 2.0, 1.0)
    unfed = Operation("/Lay down", "PlaceCable", "failed", 403, "not fed", 3.0, 1.0)
    assert cause_of([lost, unfed]) is lost
    assert cause_of([unfed]) is unfed


def test_a_run_stops_when_what_was_lost_stays_away(bench):
    bench.peers.tasks.back = False
    state = bench.run(LostError("the engine is gone"))
    assert state.ended.ending is Ending.STOPPED
    assert state.ended.because == "the engine does not come back"


def test_a_new_supervisor_goes_on_where_the_old_one_died(bench):
    class KilledError(Exception):
        pass

    with pytest.raises(KilledError):
        bench.run("finished", KilledError())
    first, second = bench.events(Planned)[0].tasks
    bench.peers.inspection.connected = {(second, "a"), (second, "b")}
    bench.take_up()
    state = bench.run()
    assert state.ended.ending is Ending.COMPLETE
    assert bench.ran == [first, second, f"{second} Clear"], "it was done: looking tells"
    assert [event.left for event in bench.events(Settled)] == [0]
    assert state.interruptions == 1


def test_what_cannot_be_seen_is_set_aside_when_nobody_is_there_to_ask(bench):
    bench.peers.inspection.trouble = UnseenError(101, "the arm is in front of it")
    state = bench.run(JAM)
    first = bench.events(Planned)[0].tasks[0]
    assert {event.unseen for event in bench.events(Settled)} == {"the arm is in front of it"}
    assert state.tasks[first].stage in (Stage.DONE, Stage.SET_ASIDE)
    assert state.ended is not None


def test_a_cell_that_refuses_blocks_the_run(bench):
    bench.peers.cell.trouble = CellError("cannot feed: the gripper holds a wire")
    state = bench.run()
    assert state.ended.because == "cannot feed: the gripper holds a wire"
    assert bench.ran == []
    assert len(bench.events(Blocked)) == 1


def test_an_operator_pauses_skips_and_stops(bench):
    def pause_and_skip():
        bench.supervisor.command(Commanded(Command.PAUSE, "", "ann"))
        bench.supervisor.command(Commanded(Command.RESUME, "", "ann"))
        bench.supervisor.command(Commanded(Command.SKIP, bench.supervisor.state.current, "ann"))

    def stop():
        bench.supervisor.command(Commanded(Command.STOP, "", "ann"))

    state = bench.run(pause_and_skip, stop)
    assert bench.peers.tasks.paused == [True, False]
    assert bench.events(Decided)[0].by == "ann"
    assert (state.ended.ending, state.ended.because) == (Ending.STOPPED, "ann stopped it")
    with pytest.raises(CellError, match="the run has ended"):
        stop()


def test_commands_that_make_no_sense_are_refused(bench):
    def refused():
        for command, task, text in (
            (Command.SKIP, "W9", "there is no task 'W9'; there are W1, W2"),
            (Command.RETRY, "W1", "only what is set aside is tried again"),
        ):
            with pytest.raises(CellError, match=text):
                bench.supervisor.command(Commanded(command, task, "ann"))
        with pytest.raises(CellError, match="question 1 is not open; open is none"):
            bench.supervisor.answer(Answered(1, Answer.RETRY, "ann"))

    assert bench.run(refused).ended.ending is Ending.COMPLETE
    assert bench.events(Commanded) == []


def test_an_operator_is_asked_when_there_is_one(url, tmp_path):
    bench = Bench(url, tmp_path, attended=True)
    asked = threading.Event()

    def answer():
        while not asked.wait(0.01):
            question = bench.supervisor.state.question
            if question is not None:
                with pytest.raises(CellError, match="question 9 is not open"):
                    bench.supervisor.answer(Answered(9, Answer.REPLAN, "ann"))
                bench.supervisor.answer(Answered(question.number, Answer.MARK_DONE, "ann"))
                asked.set()

    thread = threading.Thread(target=answer, daemon=True)
    thread.start()
    first = bench.work.planner.plan(["W1", "W2"])[0]
    state = bench.run("finished", *[JAM] * 12)
    thread.join(20.0)
    assert asked.is_set()
    assert state.tasks[first].first_pass
    assert state.ended.ending is Ending.COMPLETE
    bench.database.close()


def test_another_cells_task_is_left_to_it_and_taken_over_when_it_dies(bench, url):
    other = TaskLeases(ProductionDatabase(url), "house", "other", 1.0)
    other.claim("W1")
    bench.peers.inspection.connected = {("W1", "a")}
    state = bench.run()
    assert state.ended.ending is Ending.COMPLETE
    assert [event.cell for event in bench.events(TaskElsewhere)] == ["other"]
    assert bench.ran == ["W2", "W1 Rest"]


def test_a_task_that_another_cell_has_taken_over_is_stopped(bench, url):
    bench.leases.lease_s = 0.05
    taken = []

    def be_slow():
        other = TaskLeases(ProductionDatabase(url), "house", "other", 600.0)
        name = bench.supervisor.state.current
        bench.leases.lease_s = 30.0
        with other._database.transaction() as session:
            other._row(session, name).cell = "other"
        while not bench.supervisor._lost_lease:
            threading.Event().wait(0.01)
        taken.append(name)
        bench.supervisor.command(Commanded(Command.STOP, "", "ann"))

    bench.run(be_slow)
    assert [event.task for event in bench.events(TaskElsewhere)] == taken


def test_the_time_of_a_run_may_be_limited(url, tmp_path, monkeypatch):
    bench = Bench(url, tmp_path, timeout_s=5.0)
    clock = iter(range(0, 100, 2))
    monkeypatch.setattr(use_case_supervisor.rospy, "get_time", lambda: float(next(clock)))
    state = bench.run()
    assert state.ended.because == "its time of 5 s has passed"
    bench.database.close()


MANIFEST = """<?xml version="1.0"?>
<behavior name="{name}"><description>A wire.\n{mark}</description></behavior>
"""
PACKAGE = """<package format="3"><name>made</name><version>0.0.0</version>
<description>x</description><maintainer email="a@b.c">a</maintainer><license>BSD</license>
<export><flexbe_behaviors/></export></package>"""


def test_a_behavior_that_exists_with_the_same_content_is_not_made_again(
    bench, tmp_path, monkeypatch
):
    first, second = bench.work.planner.plan(["W1", "W2"])
    charts = {name: bench.work.planner.task(name).chart for name in (first, second)}
    manifests = tmp_path / "made" / "manifest"
    manifests.mkdir(parents=True)
    (tmp_path / "made" / "package.xml").write_text(PACKAGE)
    (manifests / "broken.xml").write_text("<behavior")
    for name, mark in ((first, content_mark(charts[first])), (second, "Content 0000.")):
        text = MANIFEST.format(name=charts[name].name, mark=mark)
        (manifests / f"{behavior_file(charts[name].name)}.xml").write_text(text)
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{tmp_path}:{os.environ['ROS_PACKAGE_PATH']}")
    bench.run()
    assert bench.peers.synthesizer.asked == [charts[second].name]


def test_what_operations_did_is_kept(bench):
    bench.run(JAM)
    (kept,) = bench.events(OperationEnded)
    assert (kept.operation.ability, kept.operation.error_code) == ("InsertCable", JAM)
