"""Ask the use case supervisor for a run, and tell of it, line by line, until it has ended."""

from __future__ import annotations

import sys
import time
import uuid

import rospy
from remodel_msgs.msg import RunUseCaseAction, RunUseCaseGoal, UseCaseState
from tqdm import tqdm

from remodel_planner.core.production import Order, Wire
from remodel_planner.core.recovery.fault import Do
from remodel_planner.core.run import Execution
from remodel_planner.core.run_report import failure_line
from remodel_planner.core.supervision.attempts import Attempt, attempts_of
from remodel_planner.core.supervision.events import Part, Planned
from remodel_planner.core.supervision.state import RunState, Stage, state_after
from remodel_planner.edge.run_log import RunLog
from remodel_planner.errors import CellError
from remodel_planner.ros.action_server import ActionServer, Goal

# [s] wall time that the supervisor's node, with all that it needs, gets to come up.
_START_LIMIT_S = 60.0

# [s] wall time between two looks at what has happened; and that a supervisor may stay away.
_LOOK_S = 0.2
_AWAY_LIMIT_S = 60.0

# What is done about a failed task, told to a person.
_DONE = {
    Do.RETRY: "looking, then doing what is left",
    Do.RETRY_WITH: "trying again with other parameters",
    Do.LOOK_AGAIN: "looking again",
    Do.OTHER_METHOD: "trying another method",
    Do.NEW_PART: "feeding a new wire",
    Do.REPLAN: "its turn comes later",
    Do.SET_ASIDE: "set aside",
    Do.ASK_OPERATOR: "asking the operator",
    Do.STOP: "stopping",
}


class RunFollower:
    """Asks for a run, and tells of it while it goes on; a supervisor that dies may come again.

    Attributes:
        number: of the run.
        attempts: that have ended.
    """

    def __init__(self, log: RunLog, order: Order) -> None:
        """Connect to the supervisor; `log` has its runs."""
        self._log = log
        self._order = order
        self._wires = {wire.name: wire for wire in order.wires}
        self._server = ActionServer(
            "remodel/run_use_case", RunUseCaseAction, "remodel_planner use_case_supervisor"
        )
        self._told: UseCaseState | None = None
        self._heard_s = time.monotonic()
        self._plans = 0
        self.number = 0
        self.attempts: tuple[Attempt, ...] = ()
        rospy.Subscriber("remodel/use_case/state", UseCaseState, self._on_state)

    def run(self, again: bool) -> RunState:
        """Have the order done, and return how it ended.

        Raises:
            CellError: if the supervisor refuses, or goes away and does not come again.
        """
        goal = self._asked(again)
        total = len(self._order.wires)
        with tqdm(total=total, unit="wire", file=sys.stdout, leave=False, disable=None) as bar:
            while True:
                goal.wait(_LOOK_S)
                state, lines = self._news()
                for line in lines:
                    bar.write(line)
                bar.update(sum(task.stage.is_lasting for task in state.tasks.values()) - bar.n)
                if state.ended is not None:
                    return state
                self._require_supervisor()

    def _asked(self, again: bool) -> Goal:
        """Send the goal until a supervisor has begun the run; one may die before it does.

        What the supervisor says of an earlier run, which it does until a new one begins, is not it.
        """
        earlier = max((head.number for head in self._log.heads()), default=0)
        request = RunUseCaseGoal(
            id=f"run_order {uuid.uuid4().hex[:8]}",
            order=self._order.name,
            tasks=len(self._order.wires),
            again=again,
        )
        end = time.monotonic() + _START_LIMIT_S
        while time.monotonic() < end:
            self._server.wait(_START_LIMIT_S)
            goal = self._server.send(request)
            while self._server.is_there and time.monotonic() < end:
                if goal.wait(_LOOK_S) and not goal.succeeded and not goal.lost:
                    raise CellError(goal.ending)
                told = self._told
                if told is not None and told.run > earlier and told.order == self._order.name:
                    self.number = told.run
                    return goal
        raise CellError(f"no run began within {_START_LIMIT_S:.0f} s")

    def _require_supervisor(self) -> None:
        away_s = time.monotonic() - self._heard_s
        if away_s > _AWAY_LIMIT_S:
            raise CellError(
                f"the use case supervisor has been silent for {away_s:.0f} s; when it is started "
                f"again, run {self.number} goes on by itself"
            )

    def _news(self) -> tuple[RunState, list[str]]:
        """Return the run's state, and lines about what has ended since the last call."""
        events = [kept.event for kept in self._log.events(self.number)]
        lines = []
        plans = [event for event in events if isinstance(event, Planned)]
        lines += [f"plan: {' '.join(plan.tasks)}" for plan in plans[self._plans :]]
        self._plans = len(plans)
        attempts = attempts_of(events)
        state = state_after(events)
        if attempts and state.current and state.tasks[state.current].stage is Stage.FAILED:
            attempts = attempts[:-1]  # what is done about it comes next
        lines += [_line(attempt, self._wires) for attempt in attempts[len(self.attempts) :]]
        self.attempts = attempts
        return state, lines

    def _on_state(self, state: UseCaseState) -> None:
        self._told, self._heard_s = state, time.monotonic()


def _line(attempt: Attempt, wires: dict[str, Wire]) -> str:
    wire, execution = wires[attempt.execution.wire], attempt.execution
    result = "placed" if execution.placed else f"NOT placed ({execution.outcome})"
    if attempt.because:
        result = f"interrupted ({attempt.because})"
    if attempt.part is Part.CLEAR:
        result = "hand emptied"
    if execution.attempt > 1:
        result += f" at attempt {execution.attempt}"
    if attempt.decision:
        result += f", {_DONE[attempt.decision.do]} ({attempt.decision.because})"
    head = (
        f"{wire.name:>4}  {wire.a!s:>12} to {wire.b!s:<14} {wire.colour} "
        f"{wire.section_mm2:g} mm2  {result}, {_insertions(execution)}, {execution.cell_s:.1f} s"
    )
    return "\n".join([head, *(f"        {failure_line(f)}" for f in execution.failures)])


def _insertions(execution: Execution) -> str:
    count = execution.tries("InsertCable")
    return f"{count} insertion" + ("" if count == 1 else "s")
