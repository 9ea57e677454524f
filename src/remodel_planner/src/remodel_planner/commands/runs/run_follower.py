"""Ask the use case supervisor for a run, and report on it until it has ended.

A line for each attempt, and below them a bar: how far the run is, and what it is doing.
"""

from __future__ import annotations

import contextlib
import sys
import time
import uuid
from collections.abc import Mapping

import rospy
from remodel_msgs.msg import (
    LevelState,
    RunUseCaseAction,
    RunUseCaseGoal,
    UseCaseChanges,
    UseCaseState,
)
from remodel_msgs.srv import GetTasks
from tqdm import tqdm

from remodel_planner.core.run_report import attempt_result, failure_line
from remodel_production.core.production import Order, Wire
from remodel_run.record import decision_words
from remodel_run.whole_task import counted
from remodel_supervision.core.run import Execution
from remodel_supervision.core.runs.attempts import Attempt, Attempts
from remodel_supervision.core.runs.event_table import count_event, state_after
from remodel_supervision.core.runs.events import Event, Planned, RunBegun
from remodel_supervision.core.runs.state import RunState, Stage
from remodel_supervision.core.runs.steady_clock import SteadyClock
from remodel_supervision.core.runs.sums import begun_words, sums_of
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.errors import CellError
from remodel_supervision.ros.action_server import ActionServer, Goal
from remodel_supervision.ros.server.state_publisher import CHANGES, STATE, TASKS

# [1] Share of a task that is shown at most before it is done: it may take longer than expected.
_MOST = 0.95

_WIDTH = 60
"""Columns of what is being done; the rest is cut, so that the bar stays in one line."""


class RunBar:
    """One line of a terminal that is rewritten; nothing where the output is no terminal."""

    def __init__(self, wires: int) -> None:
        """Show an empty bar for a number of wires, each a part of it; a cable has several."""
        self._bar = tqdm(
            total=wires,
            file=sys.stdout,
            leave=False,
            disable=None,
            bar_format="{percentage:3.0f} % |{bar:16}| {elapsed}  {desc}",
        )

    def close(self) -> None:
        """Remove the bar."""
        self._bar.close()

    def write(self, line: str) -> None:
        """Print a line above the bar."""
        self._bar.write(line)

    def show(
        self, run: RunState, state: UseCaseState | None, expected_s: Mapping[str, float]
    ) -> None:
        """Show how far the run is.

        Args:
            run: by its log.
            state: what the supervisor has published last of this run; None if nothing yet.
            expected_s: how long each task was expected to take [s, ROS time].
        """
        now, sums = "" if state is None else doing(state), sums_of(run)
        ended = sums.done_in_all + sums.skipped
        self._bar.set_description_str(f"{ended} of {sums.tasks} tasks  {now}", refresh=False)
        wires = sum(task.stage.is_lasting for task in run.tasks.values())
        self._bar.n = wires + (0.0 if state is None else share(state, expected_s))
        self._bar.refresh()


def share(state: UseCaseState, expected_s: Mapping[str, float]) -> float:
    """Return how much of the task under way is done, 0 to 1, by the time that it was to take."""
    expected = expected_s.get(state.task, 0.0)
    since = next((level.since for level in state.levels if level.level == LevelState.TASK), None)
    if not expected or since is None or since.is_zero():
        return 0.0
    return min(_MOST, max(0.0, (state.stamp - since).to_sec() / expected))


def doing(state: UseCaseState) -> str:
    """Return what a run is doing, in some words."""
    action = next((each for each in state.levels if each.level == LevelState.ACTION), None)
    if state.phase == UseCaseState.RUNNING and state.task:
        ability = f": {action.name}, {action.doing}" if action and action.name else ""
        return f"{state.task}{ability}"[:_WIDTH]
    about = f" {state.task}" if state.task else ""
    return f"{state.phase.replace('_', ' ')}{about}"


# [s] wall time that the supervisor's node, with all that it needs, gets to come up.
_START_LIMIT_S = 60.0

# [s] wall time between two reads of what has happened; and that a supervisor may be silent.
_READ_S = 0.2
_SILENCE_LIMIT_S = 60.0


class RunFollower:
    """Asks for a run and reports on it while it is under way; a supervisor that dies may respawn.

    What happens is read from the run's log, each event once; the supervisor's state reports which
    run it is, that its supervisor is alive, and what it waits for.

    Attributes:
        number: of the run.
        attempts: that have ended.
        wall_s: [s] wall time since the run began.
        ros_s: [s] ROS time since then.
    """

    def __init__(self, log: RunLog, order: Order) -> None:
        """Connect to the supervisor; `log` has its runs."""
        self._log = log
        self._order = order
        self._wires = {wire.name: wire for wire in order.wires}
        self._server = ActionServer(
            "remodel/run_use_case", RunUseCaseAction, "remodel_planner use_case_supervisor"
        )
        self._published: UseCaseState | None = None
        self._heard_s = time.monotonic()
        self._held = ""
        self._events = 0
        self._state = RunState()
        self._ended = Attempts()
        self.number = 0
        self.attempts: tuple[Attempt, ...] = ()
        self.wall_s = self.ros_s = 0.0
        self._expected_s: dict[str, float] = {}
        self._is_replanned = True
        self._tasks = rospy.ServiceProxy(TASKS, GetTasks)
        rospy.Subscriber(STATE, UseCaseState, self._on_state)
        rospy.Subscriber(CHANGES, UseCaseChanges, self._on_changes)

    def run(self, tasks: int, *, use_case: str = "", again: bool = False) -> RunState:
        """Run the first tasks of the order, and return how it ended.

        Args:
            tasks: how many, from the first; 0 for all.
            use_case: name of the use case that it is done by; empty: the supervisor's default.
            again: wire the next product of the order.

        Raises:
            CellError: if the supervisor refuses, or dies and does not respawn.
        """
        request = RunUseCaseGoal(
            id=f"run {uuid.uuid4().hex[:8]}",
            order=self._order.name,
            use_case=use_case,
            tasks=tasks,
            again=again,
        )
        goal = self._accepted(request)
        clock, began_s = SteadyClock(), time.monotonic()
        began_ros_s = clock.read(rospy.get_time(), began_s)
        total = len(self._log.state(self.number).tasks)
        with contextlib.closing(RunBar(total)) as bar:
            while True:
                goal.wait(_READ_S)
                now_s = time.monotonic()
                self.wall_s = now_s - began_s
                self.ros_s = clock.read(rospy.get_time(), now_s) - began_ros_s
                state, lines = self._news()
                for line in lines:
                    bar.write(line)
                now = self._published
                bar.show(
                    state,
                    now if now is not None and now.run == self.number else None,
                    self._expected(),
                )
                if state.ended is not None:
                    return state
                self._require_supervisor()

    def _accepted(self, request: RunUseCaseGoal) -> Goal:
        """Send the goal until a supervisor has begun the run; one may die before it does.

        What a supervisor publishes of an earlier run, which it does until a new one begins, is not
        this run.
        """
        earlier = max((head.number for head in self._log.heads()), default=0)
        end = time.monotonic() + _START_LIMIT_S
        while time.monotonic() < end:
            self._server.wait(_START_LIMIT_S)
            goal = self._server.send(request)
            while self._server.is_there and time.monotonic() < end:
                if goal.wait(_READ_S) and not goal.succeeded and not goal.lost:
                    raise CellError(goal.ending)
                now = self._published
                if now is not None and now.run > earlier and now.order == self._order.name:
                    self.number = now.run
                    return goal
        raise CellError(f"no run began within {_START_LIMIT_S:.0f} s")

    def _require_supervisor(self) -> None:
        silent_s = time.monotonic() - self._heard_s
        if silent_s > _SILENCE_LIMIT_S:
            raise CellError(
                f"the use case supervisor has been silent for {silent_s:.0f} s; once it is "
                f"restarted, it resumes run {self.number} by itself"
            )

    def _news(self) -> tuple[RunState, list[str]]:
        """Return the run's state, and lines about what has happened since the last call."""
        kept = tuple(self._log.events(self.number, first=self._events))
        self._events += len(kept)
        events = [each.event for each in kept]
        lines = [line for event in events for line in _event_lines(event)]
        for event in events:
            count_event(event, self._ended)
        state = self._state = state_after(events, self._state)
        attempts = self._ended.ended
        if attempts and state.current and state.tasks[state.current].stage is Stage.FAILED:
            attempts = attempts[:-1]  # what is done about it comes next
        lines += [attempt_line(attempt, self._wires) for attempt in attempts[len(self.attempts) :]]
        self.attempts = attempts
        return state, lines + self._hold_lines()

    def _hold_lines(self) -> list[str]:
        """Return a line if the run waits for a person, and it is another reason than before."""
        now = self._published
        held = _hold_line(now) if now is not None and now.run == self.number else ""
        is_new = held not in ("", self._held)
        self._held = held
        return [held] if is_new else []

    def _on_state(self, state: UseCaseState) -> None:
        self._published, self._heard_s = state, time.monotonic()

    def _on_changes(self, changes: UseCaseChanges) -> None:
        self._is_replanned |= changes.replanned

    def _expected(self) -> dict[str, float]:
        """Return how long each task was expected to take [s, ROS time], as far as that is known."""
        if self._is_replanned:
            self._is_replanned = False
            with contextlib.suppress(rospy.ServiceException):  # of a supervisor that dies: later
                for task in self._tasks(run=self.number).tasks:
                    if task.expected_s:
                        self._expected_s[task.name] = task.expected_s
        return self._expected_s


def _hold_line(state: UseCaseState) -> str:
    """Return what a run waits for an operator to do; empty if it waits for none."""
    if state.phase == UseCaseState.PROTECTIVE_STOP:
        return (
            f"protective stop by {state.stopped_by}; release it, then "
            "rosservice call /remodel/use_case/resume"
        )
    if state.phase == UseCaseState.ASKING:
        question = state.question
        limit = f", within {question.timeout:.0f} s" if question.timeout else ""
        return f"question {question.number} about {question.task}{limit}: {question.text}"
    return state.message if state.phase == UseCaseState.PAUSED else ""


def _event_lines(event: Event) -> list[str]:
    match event:
        case RunBegun():
            return [
                f"order {event.order}, use case {event.use_case}, product {event.serial}: "
                f"{begun_words(event)}"
            ]
        case Planned():
            return [f"plan: {' '.join(event.tasks)}"]
    return []


def attempt_line(attempt: Attempt, wires: dict[str, Wire]) -> str:
    """Return what a behavior did to its wire, with its failures in lines of their own."""
    execution, result = attempt.execution, attempt_result(attempt)
    if execution.attempt > 1:
        result += f" at attempt {execution.attempt}"
    if attempt.decision:
        decision = attempt.decision
        result += f", the cell {decision_words(decision.do.value)} ({decision.because})"
    wire = wires.get(execution.wire)
    about = (
        f"  {wire.a!s:>12} to {wire.b!s:<14} {wire.colour} {wire.section_mm2:g} mm2" if wire else ""
    )
    head = (
        f"{execution.wire:>4}{about}  {result}, {_insertions(execution)}, {execution.cell_s:.1f} s"
    )
    return "\n".join([head, *(f"        {failure_line(f)}" for f in execution.failures)])


def _insertions(execution: Execution) -> str:
    return counted(execution.tries("InsertCable"), "insertion")
