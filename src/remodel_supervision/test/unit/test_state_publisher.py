"""A client that starts from the service and takes in the changes has the tasks of the run."""

from io import BytesIO
from random import Random

import pytest
import rospy
from remodel_msgs.msg import TaskState, UseCaseChanges, UseCaseState
from remodel_msgs.srv import GetTasksRequest

from remodel_run.progress import Answer
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import (
    Asked,
    Command,
    Commanded,
    Decided,
    Ending,
    OperationEnded,
    Part,
    Planned,
    RunBegun,
    RunEnded,
    TaskBegun,
    TaskEnded,
)
from remodel_supervision.core.runs.state import FINISHED
from remodel_supervision.ros.server import state_publisher
from remodel_supervision.ros.server.state_publisher import RunView, StatePublisher
from remodel_supervision.supervisors.ports import Doing
from remodel_tasks.core.use_case.fault import Do


class FakeTopic:
    """Keeps what is published on it, and its bytes."""

    def __init__(self, name, kind, **options):
        self.messages, self.bytes = [], 0
        TOPICS[kind] = self

    def publish(self, message):
        buffer = BytesIO()
        message.serialize(buffer)
        self.bytes += len(buffer.getvalue()) + 4  # the length goes before each message
        self.messages.append(type(message)().deserialize(buffer.getvalue()))


TOPICS = {}


class Supervised:
    """A run whose events are published, by a clock that only moves here."""

    def __init__(self, tasks):
        self.now_s = 100.0
        self.number = 1
        self.publisher = StatePublisher(lambda: self.now_s)
        self.begin(tasks)

    def begin(self, tasks):
        cables = {"W2": "C1", "W3": "C1"}
        begun = RunBegun("house", "cabinet", "cell", tasks, "house-0042", cables=cables)
        self.state = state_after([begun])
        self.doing, self.view_fields = None, {}

    def view(self):
        return RunView(
            run=self.number,
            state=self.state,
            doing="at work",
            doing_now=self.doing,
            state_path="/Connect a/Insert",
            started=rospy.Time(5),
            expected_s=lambda name: 60.0,
            descriptions={name: f"Q1/1 to X3/{name}, BU, 1.5 mm2" for name in self.state.tasks},
            **self.view_fields,
        )

    def add(self, *events):
        self.state = state_after(events, self.state)
        self.publisher.publish(self.view())

    def wait(self, time_s):
        self.now_s += time_s
        return self.publisher.flush()

    def get(self, **request):
        return self.publisher._on_get(GetTasksRequest(**request))

    @property
    def last(self):
        return TOPICS[UseCaseState].messages[-1]

    @property
    def changes(self):
        return TOPICS[UseCaseChanges].messages


@pytest.fixture
def supervised(monkeypatch):
    monkeypatch.setattr(state_publisher.rospy, "Publisher", FakeTopic)
    monkeypatch.setattr(state_publisher.rospy, "Service", lambda *arguments: None)
    monkeypatch.setattr(state_publisher.rospy.Time, "now", lambda: rospy.Time(100))
    return Supervised(tuple(f"W{number}" for number in range(1, 7)))


def begin(task, attempt=1):
    return TaskBegun(task, attempt, Part.WHOLE, f"Place Wire {task}", "<chart/>", 10.0)


def operation(code=0):
    text = "22 N at 6 mm of 14 mm; the opening of terminal A1 may be blocked"
    return Operation("/Connect a/Insert", "InsertCable", "done", code, text, 30.0, 9.0, "g", (), ())


def failed(task, attempt=1, at_s=20.0):
    """Return the events of an attempt that fails."""
    jam = OperationEnded(task, operation(301))
    return [begin(task, attempt), jam, TaskEnded(task, "failed", at_s, False)]


def decision(task, do, at_s=20.0):
    text = "22 N at 6 mm of 14 mm; the opening of terminal A1 may be blocked"
    because = "it has failed once, and the same part may be tried again"
    return Decided(
        task, "insertion_jammed", 301, "InsertCable", "/C", text, do, (), because, "policy", at_s
    )


def planned(supervised):
    """Begin and plan the run, and return its snapshot."""
    supervised.add(Planned(supervised.state.waiting, "the run begins"))
    return supervised.get()


def states(tasks):
    return {task.name: task.state for task in tasks}


def test_the_snapshot_and_the_changes_give_the_tasks(supervised):
    found = planned(supervised)
    assert [task.name for task in found.tasks] == ["W1", "W2", "W3", "W4", "W5", "W6"]
    assert found.tasks[0].description == "Q1/1 to X3/W1, BU, 1.5 mm2"
    assert [task.cable for task in found.tasks[:3]] == ["", "C1", "C1"]
    known = states(found.tasks)
    for events in (
        [begin("W1")],
        [OperationEnded("W1", operation()), TaskEnded("W1", FINISHED, 40.0, True)],
        failed("W2"),
        [decision("W2", Do.SET_ASIDE)],
        [begin("W3")],
    ):
        supervised.add(*events)
        supervised.wait(0.3)
    for number, changes in enumerate(supervised.changes, start=found.number + 1):
        assert (changes.series, changes.number) == (found.series, number)
        known |= states(changes.tasks)
    later = supervised.get()
    assert known == states(later.tasks)
    assert list(known.values()) == ["done", "set_aside", "running", "waiting", "waiting", "waiting"]
    assert supervised.last.serial == "house-0042"
    assert (later.number, supervised.last.changes) == (number, number)
    sums = supervised.last.sums
    assert (sums.tasks, sums.done, sums.skipped) == (5, 1, 0), "a cable ends with its last core"
    assert [failure.decision for failure in later.failures] == ["set_aside"]
    assert [f.task for changes in supervised.changes for f in changes.failures] == ["W2"]
    supervised.add(decision("W3", Do.SET_ASIDE))
    supervised.wait(0.3)
    sums = supervised.last.sums
    assert (sums.done, sums.skipped, sums.open) == (1, 1, 3)


def test_a_task_between_two_behaviors_is_under_way(supervised):
    planned(supervised)
    supervised.add(*failed("W1"), decision("W1", Do.RETRY))
    supervised.wait(0.3)
    assert states(supervised.changes[-1].tasks) == {"W1": TaskState.RUNNING}
    supervised.add(*failed("W1", 2, 30.0), decision("W1", Do.REPLAN, 30.0))
    supervised.wait(0.3)
    assert states(supervised.changes[-1].tasks) == {"W1": TaskState.WAITING}


def test_clients_learn_that_the_order_has_changed(supervised):
    planned(supervised)
    supervised.add(*failed("W1"))
    supervised.wait(0.3)
    assert [changes.replanned for changes in supervised.changes] == [False]
    supervised.add(decision("W1", Do.REPLAN))
    supervised.add(Planned(("W3", "W2", "W4", "W5", "W6", "W1"), "because"))
    supervised.wait(0.3)
    assert supervised.changes[-1].replanned
    names = [task.name for task in supervised.get().tasks]
    assert names == ["W3", "W2", "W4", "W5", "W6", "W1"]
    supervised.add(begin("W3"), TaskEnded("W3", FINISHED, 40.0, True))
    supervised.add(Commanded(Command.SKIP, "W5", "ann"))
    supervised.wait(0.3)
    assert not supervised.changes[-1].replanned
    assert [task.name for task in supervised.get().tasks] == names


def test_a_plan_that_keeps_the_order_still_brings_the_expected_times(supervised):
    supervised.publisher.publish(supervised.view())
    supervised.wait(0.3)
    supervised.add(Planned(supervised.state.waiting, "the run begins"))
    assert [changes.replanned for changes in supervised.changes] == [True]


def test_tasks_are_served_in_parts(supervised):
    planned(supervised)
    supervised.add(*failed("W1"), decision("W1", Do.RETRY))
    supervised.wait(0.3)
    found = supervised.get(run=1, first=1, count=4)
    rest = supervised.get(run=1, first=5, count=4)
    assert [task.name for task in (*found.tasks, *rest.tasks)] == list(supervised.state.tasks)
    assert (found.total, len(found.failures), len(rest.failures)) == (6, 1, 0)
    other = supervised.get(run=7)
    assert (other.success, other.message) == (False, "this supervisor does not have run 7")


def test_another_run_has_another_series(supervised):
    planned(supervised)
    supervised.add(begin("W1"))
    supervised.wait(0.3)
    before = supervised.last
    supervised.number = 2
    supervised.begin(("W7",))
    supervised.publisher.publish(supervised.view())
    assert (supervised.last.run, supervised.last.changes) == (2, 0)
    assert supervised.last.series != before.series
    assert supervised.get(run=1).success is False
    supervised.publisher.idle("cell", "the database is away", starting=True)
    assert (supervised.last.phase, supervised.last.series) == (UseCaseState.STARTING, 0)
    assert supervised.get().message == "this supervisor does not have a run"


def test_nothing_is_published_more_often_than_four_times_a_second(supervised):
    planned(supervised)
    supervised.add(begin("W1"))
    supervised.add(OperationEnded("W1", operation()))
    assert not supervised.changes
    assert supervised.wait(0.2) == pytest.approx(0.05)
    assert not supervised.changes
    supervised.wait(0.05)
    assert len(supervised.changes) == 1


def test_how_a_run_ended_is_published_at_once_and_until_there_is_news(supervised):
    planned(supervised)
    supervised.add(RunEnded(Ending.STOPPED, "ann stopped it"))
    assert (supervised.last.phase, supervised.last.message) == ("ended", "ann stopped it")
    supervised.publisher.idle("cell")
    supervised.wait(1.0)
    assert (supervised.last.phase, supervised.last.message) == ("ended", "ann stopped it")
    assert len(supervised.get(run=1).tasks) == 6
    supervised.publisher.idle("cell", "the database does not answer", starting=True)
    assert (supervised.last.phase, supervised.last.run) == (UseCaseState.STARTING, 0)


def test_the_state_is_repeated_each_second_while_nothing_changes(supervised):
    planned(supervised)
    before = len(TOPICS[UseCaseState].messages)
    for _ in range(100):
        supervised.publisher.publish(supervised.view())
        supervised.wait(0.1)
    assert len(TOPICS[UseCaseState].messages) - before in (8, 9, 10)
    assert not supervised.changes


def test_phases_of_a_run_that_is_held(supervised):
    planned(supervised)

    def phase(**fields):
        supervised.view_fields = fields
        supervised.publisher.publish(supervised.view())
        supervised.wait(0.3)
        return supervised.last.phase

    supervised.add(begin("W1"))
    assert phase() == UseCaseState.RUNNING
    supervised.add(Commanded(Command.PAUSE, "", "ann"))
    assert phase(moving=True) == UseCaseState.PAUSING
    assert phase() == UseCaseState.PAUSED
    supervised.add(Commanded(Command.PROTECTIVE_STOP, "", "light curtain 2"))
    assert phase(moving=True) == UseCaseState.PROTECTIVE_STOP
    assert supervised.last.stopped_by == "light curtain 2"
    supervised.add(Commanded(Command.RESUME, "", "ann"))
    assert phase() == UseCaseState.RUNNING


def test_a_question_has_a_time_limit(supervised):
    planned(supervised)
    supervised.add(*failed("W1"), decision("W1", Do.ASK_OPERATOR))
    supervised.add(Asked(1, "W1", "It jams.", (Answer.RETRY, Answer.STOP), 20.5, 600.0))
    supervised.wait(0.3)
    question = supervised.last.question
    assert supervised.last.phase == UseCaseState.ASKING
    assert (question.asked.to_sec(), question.timeout) == (20.5, 600.0)


def test_an_order_of_5000_tasks_takes_less_than_5_kb_a_second(supervised):
    """Four changes a second, each of which moves a task on; and feedback at 20 a second."""
    supervised.number = 2
    supervised.begin(tuple(f"W{number}" for number in range(1, 5001)))
    supervised.add(Planned(supervised.state.waiting, "the run begins"))
    supervised.wait(1.0)
    for topic in TOPICS.values():
        topic.bytes = 0
    random, changes, seconds = Random(1), _changes(supervised), 10
    for tick in range(seconds * 20):
        if tick % 5 == 0:
            supervised.add(*next(changes))
        percent = random.uniform(0, 100)
        supervised.doing = Doing("InsertCable", "pushing end a into K17:A1", percent, 10.0)
        supervised.publisher.publish(supervised.view())
        supervised.wait(0.05)
    assert len(supervised.changes) > 3 * seconds
    per_second = sum(topic.bytes for topic in TOPICS.values()) / seconds
    assert 1000 < per_second < 5000


def _changes(supervised):
    """Yield events, of which one task in ten fails."""
    for number, name in enumerate(supervised.state.tasks):
        yield [begin(name)]
        yield [OperationEnded(name, operation())]
        if number % 10:
            yield [OperationEnded(name, operation()), TaskEnded(name, FINISHED, 40.0, True)]
        else:
            yield [OperationEnded(name, operation(301)), TaskEnded(name, "failed", 40.0, False)]
            yield [decision(name, Do.SET_ASIDE)]
