"""Which fault a task failed with, what is done about it, and what an operator is asked."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import Enum
from itertools import pairwise
from types import MappingProxyType

from remodel_run.progress import Answer
from remodel_supervision.core.recovery.decide import Failure, Spent, counted_deeds, decide
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import POLICY, Asked, Decided
from remodel_supervision.core.runs.state import (
    PERSON_FIRST,
    STUCK_HAND_LIMIT,
    UNREPORTED,
    RunState,
    TaskProgress,
    cause_of,
)
from remodel_tasks.core.task_charts.task_chart import step_of
from remodel_tasks.core.use_case.fault import Do, FaultTable, Policy

NO_BOUNDS: Mapping[str, float] = MappingProxyType({})


def failure_of(
    task: TaskProgress,
    faults: FaultTable,
    at_s: float,
    bounds: Mapping[str, float] = NO_BOUNDS,
) -> Failure:
    """Return what a task failed with: the operation of its last attempt that failed last.

    Args:
        task: that failed.
        faults: that there are.
        at_s: [s] ROS time.
        bounds: parameter -> what it must not exceed here.
    """
    fault = faults.diagnose(task.codes) or faults.of(UNREPORTED)
    cause = cause_of(task.operations)
    if task.unseen or cause is None:
        text = task.unseen or f"the behavior ended {task.outcome}"
        return Failure(task.name, fault, task.codes[-1], "", state_path="", text=text, at_s=at_s)
    return Failure(
        task.name,
        fault,
        cause.error_code,
        cause.ability,
        state_path=cause.state_path,
        text=cause.text,
        at_s=at_s,
        parameters=_parameters(task, cause),
        bounds=tuple(bounds.items()),
    )


def _parameters(task: TaskProgress, cause: Operation) -> tuple[tuple[str, str], ...]:
    """Return the parameters of the step that failed: a fixing fails by its insertion's force."""
    values: dict[str, str] = {}
    for operation in task.operations:
        if step_of(operation.state_path) == step_of(cause.state_path):
            values |= operation.parameters
    return tuple({**values, **dict(cause.parameters)}.items())


def decide_recovery(
    state: RunState,
    name: str,
    faults: FaultTable,
    policy: Policy,
    possible: Collection[Do],
    at_s: float,
    bounds: Mapping[str, float] = NO_BOUNDS,
    unpromising: Collection[Do] = (),
) -> Decided:
    """Return what is done about a task that failed.

    Args:
        state: of the run.
        name: of the task.
        faults: that there are.
        policy: of the use case.
        possible: what can be done now.
        at_s: [s] ROS time.
        bounds: parameter -> what it must not exceed here.
        unpromising: what has hardly ever helped.
    """
    task = state.tasks[name]
    failure = failure_of(task, faults, at_s, bounds)
    spent = Spent(task.attempts - task.interruptions, task.cell_s, state.failures, state.cell_s)
    earlier = [(decision.fault, decision.do) for decision in task.decisions]
    decision = decide(
        failure,
        earlier,
        spent,
        policy,
        possible=possible,
        unpromising=unpromising,
        fruitless=fruitless(failure, task.decisions),
    )
    do, because, by = decision.do, decision.because, POLICY
    if failure.code in PERSON_FIRST and do is not Do.STOP:
        do = Do.ASK_OPERATOR if Do.ASK_OPERATOR in possible else Do.STOP
    elif task.stuck_hand > STUCK_HAND_LIMIT:
        do = Do.ASK_OPERATOR if Do.ASK_OPERATOR in possible else Do.STOP
        because = f"the hand could not be emptied in {task.stuck_hand} attempts"
    elif name in state.skipped:
        do, by = Do.SET_ASIDE, state.skipped[name]
        because = f"{by} skipped it"
    return Decided(
        name,
        failure.fault.name,
        failure.code,
        failure.ability,
        state_path=failure.state_path,
        text=failure.text,
        do=do,
        change=decision.change if do is decision.do else (),
        because=because,
        by=by,
        at_s=at_s,
    )


def fruitless(failure: Failure, decisions: Sequence[Decided]) -> frozenset[Do]:
    """Return what was done about a task's failures and led to the same one, figure for figure.

    Only if the geometry of the place decides such failures. Another value of a parameter is not
    among it: it changes with each response.

    Args:
        failure: the latest.
        decisions: about the earlier ones, the latest last.
    """
    if not failure.fault.is_geometry:
        return frozenset()
    failures = [(each.fault, each.text) for each in decisions] + [
        (failure.fault.name, failure.text)
    ]
    return frozenset(
        decision.do
        for decision, (before, after) in zip(decisions, pairwise(failures), strict=True)
        if before == after == failures[-1] and decision.do is not Do.RETRY_WITH
    )


def question_about(
    state: RunState, name: str, faults: FaultTable, at_s: float, timeout_s: float = 0.0
) -> Asked:
    """Return the question about a task whose last decision was to ask.

    Args:
        state: of the run.
        name: of the task.
        faults: that there are.
        at_s: [s] ROS time.
        timeout_s: [s] ROS time after which it escalates; 0: never.
    """
    task = state.tasks[name]
    last = task.decisions[-1]
    tried = [decision.do for decision in task.decisions[:-1]]
    parts = [
        f"{last.fault.replace('_', ' ').capitalize()}: {last.text}.",
        faults[last.fault].symptoms,
        f"Tried so far: {counted_deeds(tried)}." if tried else "",
        "The hand may hold a wire that could not be laid down." if task.stuck_hand else "",
        f"Connected: end {' and end '.join(task.connected)}." if task.connected else "",
    ]
    text = " ".join(filter(None, parts))
    # The usual one first: a person has seen to what the cell could not do, and the cell checks.
    choices = [Answer.FIXED, Answer.RETRY, Answer.MARK_DONE, Answer.SKIP]
    if state.waiting:
        choices.append(Answer.REPLAN)
    return Asked(
        state.questions + 1, name, text, (*choices, Answer.STOP), at_s=at_s, timeout_s=timeout_s
    )


class NoticeKind(Enum):
    """What has happened to a question."""

    ASKED = "question_asked"
    TIMED_OUT = "question_timed_out"


@dataclass(frozen=True)
class QuestionNotice:
    """A question that an operator is to answer, or has not answered in time.

    Attributes:
        event: what has happened.
        cell: that works on the order.
        run: number of the run.
        task: that the question is about.
        question: its number in the run.
        text: of the question.
        choices: that it has.
        timeout_s: [s] ROS time for an answer; 0: as long as it takes.
        then: what is done when it has passed, "set_aside" or "stop".
    """

    event: NoticeKind
    cell: str
    order: str
    run: int
    task: str
    question: int
    text: str
    choices: tuple[str, ...]
    timeout_s: float
    then: str

    def data(self) -> dict[str, object]:
        """Return it as plain data, for JSON."""
        return {**asdict(self), "event": self.event.value, "choices": list(self.choices)}
