"""A run as messages, and their publication: a small state, and what changes in the tasks.

All tasks are returned by a service, which clients call when they join or have missed a change.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass

import rospy
from remodel_msgs.msg import (
    FailureState,
    HandWire,
    LevelState,
    OperatorQuestion,
    RunSums,
    TaskState,
    UseCaseChanges,
    UseCaseState,
)
from remodel_msgs.srv import GetTasks, GetTasksRequest, GetTasksResponse

from remodel_run import progress
from remodel_run.progress import Phase, Sums, TaskPhase
from remodel_supervision.core.runs.events import Decided
from remodel_supervision.core.runs.state import (
    RunState,
    Stage,
    all_decisions,
    changes_between,
    in_plan_order,
)
from remodel_supervision.core.runs.step import Plan, Settle, Wait, abridged, next_step
from remodel_supervision.core.runs.sums import count_of, sums_of
from remodel_supervision.supervisors.ports import Doing

_TASK_PHASES = {
    Stage.WAITING: TaskPhase.WAITING,
    Stage.ELSEWHERE: TaskPhase.WAITING,
    Stage.DONE: TaskPhase.DONE,
    Stage.SET_ASIDE: TaskPhase.SET_ASIDE,
}


@dataclass(frozen=True)
class RunView:
    """What is published of a run.

    Attributes:
        run: its number.
        doing: what is being done now, for a person.
        doing_now: what an ability reports; None if none does anything.
        state_path: of the state in which the engine is; empty if it reports none.
        started: ROS time at which this process began the run, or resumed it.
        expected_s: returns the time that a task is expected to take [s].
        descriptions: of the tasks, for a person, by name.
        controllers: safety controllers that hold the cell by a protective stop.
        moving: whether an operation is under way, so that a pause has not taken effect yet.
    """

    run: int
    state: RunState
    doing: str
    doing_now: Doing | None
    state_path: str
    started: rospy.Time
    expected_s: Callable[[str], float]
    descriptions: Mapping[str, str]
    controllers: tuple[str, ...] = ()
    moving: bool = False


def state_message(view: RunView) -> UseCaseState:
    """Return the state of a run, without stamp, series and number of its changes."""
    state = view.state
    return UseCaseState(
        phase=_phase(view).value,
        message=abridged(state.ended.because) if state.ended else view.doing,
        cell=state.cell,
        run=view.run,
        order=state.order,
        use_case=state.use_case,
        serial=state.serial,
        started=view.started,
        interruptions=state.interruptions,
        stopped_by=state.protective,
        controllers=list(view.controllers),
        sums=sums_message(sums_of(state)),
        task=state.current,
        levels=levels(view),
        question=_question(view),
    )


def levels(view: RunView) -> list[LevelState]:
    """Return what the four levels of a run are doing, from use case to action."""
    state, doing = view.state, view.doing_now
    task = state.tasks.get(state.current)
    found = [LevelState(level=LevelState.USE_CASE, name=state.order, doing=view.doing)]
    if task is None or task.stage is not Stage.RUNNING:
        empty = (LevelState.TASK, LevelState.BEHAVIOR, LevelState.ACTION)
        return found + [LevelState(level=level) for level in empty]
    since = rospy.Time.from_sec(task.began_s)
    found.append(LevelState(LevelState.TASK, task.name, f"attempt {task.attempts}", since))
    found.append(LevelState(LevelState.BEHAVIOR, task.behavior, view.state_path, since))
    if doing is None:
        return [*found, LevelState(level=LevelState.ACTION)]
    text = f"{doing.text} ({doing.percent:.0f} %)"
    begun = rospy.Time.from_sec(max(0.0, doing.since_s))
    return [*found, LevelState(LevelState.ACTION, doing.ability, text, begun)]


def task_message(view: RunView, name: str) -> TaskState:
    """Return the state of a task."""
    task = view.state.tasks[name]
    under_way = TaskPhase.RUNNING if name == view.state.current else TaskPhase.WAITING
    return TaskState(
        name=name,
        description=view.descriptions.get(name, ""),
        cable=view.state.cables.get(name, ""),
        state=_TASK_PHASES.get(task.stage, under_way).value,
        counts_as=count_of(task, view.state).value,
        attempts=task.attempts,
        first_pass=task.first_pass,
        taken_s=task.cell_s,
        expected_s=0.0 if task.stage.is_lasting else view.expected_s(name),
    )


def sums_message(sums: Sums) -> RunSums:
    """Return the sums of a run."""
    return RunSums(**asdict(sums))


def hand_wire_message(wire: progress.HandWire) -> HandWire:
    """Return a wire that is left to a person."""
    return HandWire(
        name=wire.name,
        marker=wire.marker,
        a=wire.a,
        b=wire.b,
        colour=wire.colour,
        section=wire.section_mm2,
        length=wire.length_m,
        reason=wire.reason,
    )


def failure_message(decision: Decided) -> FailureState:
    """Return a task's failure, with what was decided about it."""
    return FailureState(
        stamp=rospy.Time.from_sec(decision.at_s),
        task=decision.task,
        fault=decision.fault,
        error_code=decision.code,
        ability=decision.ability,
        text=decision.text,
        decision=decision.do.value,
        because=decision.because,
    )


def _question(view: RunView) -> OperatorQuestion:
    asked = view.state.question
    if asked is None:
        return OperatorQuestion()
    return OperatorQuestion(
        number=asked.number,
        task=asked.task,
        text=asked.text,
        choices=[choice.value for choice in asked.choices],
        asked=rospy.Time.from_sec(asked.at_s),
        timeout=asked.timeout_s,
    )


def _phase(view: RunView) -> Phase:
    state = view.state
    if state.ended is not None:
        return Phase.ENDED
    if state.protective:
        return Phase.PROTECTIVE_STOP
    if state.question is not None:
        return Phase.ASKING
    if state.paused:
        return Phase.PAUSING if view.moving else Phase.PAUSED
    task = state.tasks.get(state.current)
    if task is not None and task.stage is Stage.RUNNING:
        return Phase.RUNNING
    match next_step(state):
        case Plan():
            return Phase.PLANNING
        case Settle():
            return Phase.SETTLING
        case Wait():
            return Phase.PAUSED
    return Phase.RUNNING


__all__ = ["RunView", "StatePublisher", "levels"]

STATE = "remodel/use_case/state"
CHANGES = "remodel/use_case/changes"
TASKS = "remodel/use_case/tasks"

# [s] wall time between two publications of a run; and after which the state is published though
# nothing has changed, so that clients notice a supervisor that hangs.
_INTERVAL_S = 0.25
_HEARTBEAT_S = 1.0

# Changes that wait for a slow subscriber; one that loses some gets all tasks again.
_QUEUE_SIZE = 100


@dataclass(frozen=True)
class _Published:
    """What clients know: the run as it was published last.

    Attributes:
        order: names of the tasks, as they were planned last.
        number: of the last changes in their series.
    """

    view: RunView
    series: int
    number: int
    order: tuple[str, ...]


class StatePublisher:
    """Publishes state and changes of the run under way, and serves its tasks.

    `publish`, `flush` and `idle` are called from one thread, the service from others.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Advertise the topics and the service; `clock` returns wall time [s]."""
        self._clock = clock
        self._state = rospy.Publisher(STATE, UseCaseState, latch=True, queue_size=1)
        self._changes = rospy.Publisher(CHANGES, UseCaseChanges, queue_size=_QUEUE_SIZE)
        self._lock = threading.Lock()
        self._published: _Published | None = None
        self._waiting: RunView | None = None
        self._last = UseCaseState()
        self._sent_s = self._compared_s = -_HEARTBEAT_S
        rospy.Service(TASKS, GetTasks, self._on_get)

    def idle(
        self,
        cell: str,
        text: str = "",
        *,
        starting: bool = False,
        stopped_by: str = "",
        controllers: Sequence[str] = (),
    ) -> None:
        """Publish that there is no run.

        How a run has ended stays published, and its tasks served, as long as there is nothing to
        report about the supervisor itself.

        Args:
            cell: name of this cell.
            text: why, for a person; empty if it waits for an order.
            starting: an order cannot be taken yet.
            stopped_by: who has stopped the cell protectively; empty if it is not stopped.
            controllers: those of them that are safety controllers.
        """
        has_ended = self._published is not None and self._published.view.state.ended is not None
        if has_ended and not text and not starting:
            return
        with self._lock:
            self._published = self._waiting = None
        phase = UseCaseState.STARTING if starting else UseCaseState.IDLE
        phase = UseCaseState.PROTECTIVE_STOP if stopped_by else phase
        self._send(
            UseCaseState(
                phase=phase,
                cell=cell,
                message=text,
                stopped_by=stopped_by,
                controllers=list(controllers),
            )
        )

    def publish(self, view: RunView) -> None:
        """Publish what has changed in a run, now or with the next `flush` that is due.

        The beginning and the end of a run are published at once.
        """
        before = self._published
        is_edge = (
            before is None
            or before.view.run != view.run
            or (before.view.state.ended is None and view.state.ended is not None)
        )
        self._waiting = view
        if is_edge or self._due_in_s() <= 0:
            self._publish_waiting()

    def flush(self) -> float:
        """Publish what waits for its time, and repeat the state now and then.

        Returns:
            Wall time [s] after which there will be something to publish, if nothing changes.
        """
        if self._waiting is not None and self._due_in_s() <= 0:
            self._publish_waiting()
        if self._due_in_s() <= 0:
            self._send(self._last)
        return max(0.0, self._due_in_s())

    def _due_in_s(self) -> float:
        """Return the wall time until the next publication is due; below 0 if it is overdue [s]."""
        is_waiting = self._waiting is not None
        due_s = self._compared_s + _INTERVAL_S if is_waiting else self._sent_s + _HEARTBEAT_S
        return due_s - self._clock()

    def _publish_waiting(self) -> None:
        view, self._waiting = self._waiting, None
        assert view is not None, "only called when a view waits"
        message = state_message(view)
        changes = self._take(view)
        message.series, message.changes = self._published.series, self._published.number
        if changes is not None:
            self._changes.publish(changes)
        message.stamp, self._compared_s = self._last.stamp, self._clock()
        if changes is not None or message != self._last:
            self._send(message)

    def _take(self, view: RunView) -> UseCaseChanges | None:
        """Replace what the service returns, and return what has changed; None if nothing has."""
        before = self._published
        if before is None or before.view.run != view.run:
            published = _Published(view, time.time_ns(), 0, in_plan_order(view.state))
            with self._lock:
                self._published = published
            return None
        changed = changes_between(before.view.state, view.state)
        number = before.number + bool(changed)
        order = in_plan_order(view.state, before.order) if changed.replanned else before.order
        with self._lock:
            self._published = _Published(view, before.series, number, order)
        if not changed:
            return None
        return UseCaseChanges(
            run=view.run,
            series=before.series,
            number=number,
            replanned=changed.replanned,
            tasks=[task_message(view, name) for name in changed.tasks],
            failures=[failure_message(decision) for decision in changed.decisions],
        )

    def _send(self, message: UseCaseState) -> None:
        message.stamp = rospy.Time.now()
        self._last, self._sent_s = message, self._clock()
        self._state.publish(message)

    def _on_get(self, request: GetTasksRequest) -> GetTasksResponse:
        with self._lock:
            published = self._published
        if published is None or request.run not in (0, published.view.run):
            asked = f"run {request.run}" if request.run else "a run"
            return GetTasksResponse(success=False, message=f"this supervisor does not have {asked}")
        view, first = published.view, max(1, request.first)
        end = first - 1 + request.count if request.count else None
        decisions = all_decisions(view.state) if first == 1 else ()
        by_hand = view.state.by_hand if first == 1 else ()
        return GetTasksResponse(
            success=True,
            run=view.run,
            series=published.series,
            number=published.number,
            total=len(published.order),
            tasks=[task_message(view, name) for name in published.order[first - 1 : end]],
            failures=[failure_message(decision) for decision in decisions],
            by_hand=[hand_wire_message(wire) for wire in by_hand],
        )
