"""A run is followed from its request on, whatever the supervisor reports of earlier ones."""

import itertools
import threading

import pytest
import rospy
from house import HOUSE, owner_of
from remodel_msgs.msg import LevelState, OperatorQuestion, UseCaseState

from remodel_planner.commands.runs import run_follower
from remodel_planner.commands.runs.run_follower import RunFollower, attempt_line, doing, share
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_supervision.core.run import Execution
from remodel_supervision.core.runs.attempts import Attempt
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import Ending, Part, RunBegun, RunEnded
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.errors import CellError


class FakeGoal:
    """A goal that is under way, or was refused."""

    succeeded, lost, ending = False, False, "rejected: run 1 is under way"

    def __init__(self, refused):
        self.refused = refused

    def wait(self, limit_s):
        return self.refused or threading.Event().wait(0.001)


class FakeServer:
    """Accepts or refuses each goal, and then calls what a test has set."""

    is_there, refuses = True, False
    on_goal = staticmethod(lambda: None)

    def __init__(self, name, action, node):
        pass

    def wait(self, limit_s):
        pass

    def send(self, goal):
        type(self).sent = goal
        self.on_goal()
        return FakeGoal(self.refuses)


BEGUN = RunBegun("house", "cabinet", "cell", ("W1", "W2"))


class Supervised:
    """An order's runs, and a follower of them."""

    def __init__(self, url, monkeypatch):
        self.hear = None
        monkeypatch.setattr(run_follower, "ActionServer", FakeServer)
        monkeypatch.setattr(run_follower.rospy, "Subscriber", self.subscribe)
        monkeypatch.setattr(run_follower.rospy, "get_time", itertools.count(3.0, 0.25).__next__)
        self.database = ProductionDatabase(url)
        self.database.add_order(HOUSE)
        self.log = RunLog(self.database)
        self.owner = owner_of(self.database)
        self.do_run()
        self.follower = RunFollower(self.log, HOUSE)
        self.publish(1)

    def subscribe(self, topic, kind, callback):
        if kind is UseCaseState:
            self.hear = callback

    def publish(self, run):
        self.hear(UseCaseState(run=run, order="house"))

    def begin_a_run_soon(self, monkeypatch):
        """Have a run begin and end some time after a goal is sent."""
        begins = threading.Timer(0.05, lambda: self.publish(self.do_run()))
        monkeypatch.setattr(FakeServer, "on_goal", staticmethod(begins.start))

    def do_run(self):
        """Begin a run and end it, and return its number."""
        run, _ = self.log.begin(BEGUN, self.owner)
        ended = RunEnded(Ending.COMPLETE, f"run {run}")
        self.log.append(run, ended, state_after([BEGUN]), self.owner)
        return run


@pytest.fixture
def supervised(monkeypatch, tmp_path):
    made = Supervised(f"sqlite:///{tmp_path}/production.sqlite", monkeypatch)
    yield made
    made.database.close()


def test_the_run_of_the_goal_is_followed_and_timed_by_both_clocks(supervised, monkeypatch):
    supervised.begin_a_run_soon(monkeypatch)
    state = supervised.follower.run(2, use_case="cabinet")
    assert (FakeServer.sent.order, FakeServer.sent.tasks) == ("house", 2)
    assert FakeServer.sent.use_case == "cabinet"
    assert supervised.follower.number == 2
    assert state.ended.because == "run 2", "not what is said of an earlier run"
    assert supervised.follower.ros_s == 0.25, "one reading after the first"
    assert 0.0 < supervised.follower.wall_s < 1.0


def test_a_refusal_is_reported(supervised, monkeypatch):
    monkeypatch.setattr(FakeServer, "refuses", True)
    with pytest.raises(CellError, match="run 1 is under way"):
        supervised.follower.run(2)


def test_each_event_is_read_once(supervised, monkeypatch):
    reads = []
    events = supervised.log.events

    def read(run, first=0):
        reads.append((first, len(found := tuple(events(run, first)))))
        return found

    supervised.begin_a_run_soon(monkeypatch)
    monkeypatch.setattr(supervised.log, "events", read)
    supervised.follower.run(2)
    assert [first + count for first, count in reads] == [first for first, _ in reads[1:]] + [2]


def test_what_a_run_waits_for_is_reported_once(supervised):
    follower = supervised.follower
    follower.number = 1

    def lines(**fields):
        supervised.hear(UseCaseState(run=1, order="house", **fields))
        return follower._news()[1]

    begun = "order house, use case cabinet, product house-0001: 2 tasks"
    assert lines(phase="running") == [begun]
    stopped = lines(phase="protective_stop", stopped_by="light curtain 2")
    assert stopped[0].startswith("protective stop by light curtain 2; release it, then rosservice")
    assert lines(phase="protective_stop", stopped_by="light curtain 2") == []
    question = OperatorQuestion(number=1, task="W1", text="It jams.", timeout=600.0)
    asked = ["question 1 about W1, within 600 s: It jams."]
    assert lines(phase="asking", question=question) == asked
    assert lines(phase="running") == []
    assert lines(phase="asking", question=question) == asked


def state_of(**fields):
    action = LevelState(level=LevelState.ACTION, name="InsertCable", doing="push (40 %)")
    task = LevelState(level=LevelState.TASK, name="W1", since=rospy.Time(100))
    fields = {"phase": UseCaseState.RUNNING, "task": "W1", "levels": [task, action], **fields}
    return UseCaseState(**fields)


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({}, "W1: InsertCable, push (40 %)"),
        ({"levels": []}, "W1"),
        ({"phase": UseCaseState.SETTLING}, "settling W1"),
        ({"phase": UseCaseState.PROTECTIVE_STOP, "task": ""}, "protective stop"),
        ({"phase": UseCaseState.PLANNING, "task": ""}, "planning"),
    ],
)
def test_the_bar_shows_what_a_run_is_doing(fields, text):
    assert doing(state_of(**fields)) == text


@pytest.mark.parametrize(
    ("now_s", "expected_s", "shown"),
    [(100, 40.0, 0.0), (110, 40.0, 0.25), (500, 40.0, 0.95), (110, 0.0, 0.0)],
)
def test_the_bar_moves_within_a_task_and_does_not_end_it(now_s, expected_s, shown):
    assert share(state_of(stamp=rospy.Time(now_s)), {"W1": expected_s}) == shown


@pytest.mark.parametrize(
    ("part", "outcome", "placed", "said"),
    [
        (Part.DISCARD, "finished", False, "  discarded, 0 insertions, 12.0 s"),
        (Part.DISCARD, "failed", False, "  NOT discarded, 0 insertions, 12.0 s"),
        (Part.WHOLE, "finished", True, "  placed, "),
        (Part.WHOLE, "finished", False, "  finished, not confirmed by the cell's ground truth, "),
        (Part.WHOLE, "failed", False, "  NOT placed (failed), "),
        (Part.WHOLE, "failed", True, "  NOT placed (failed, both ends fixed), "),
    ],
)
def test_what_a_behavior_did_to_a_wire_is_named(part, outcome, placed, said):
    execution = Execution("W1", "Lead Wire W1", 1, outcome, placed, 0.0, 12.0, ())
    assert said in attempt_line(Attempt(execution, part, "<chart/>"), {})
