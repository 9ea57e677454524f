"""What is known of a run after some events. Pure: the same events give the same state."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import singledispatch

from remodel_planner.core.recovery.fault import Do
from remodel_planner.core.run import Operation
from remodel_planner.core.supervision.events import (
    Answer,
    Answered,
    Asked,
    AsLeft,
    Blocked,
    Command,
    Commanded,
    Decided,
    Event,
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
    TaskReturned,
)

# Outcomes of a task's behavior: it did what it should; somebody stopped it.
FINISHED = "finished"
PREEMPTED = "preempted"


class Stage(Enum):
    """How far a task is.

    WAITING: for its turn. READY: its next behavior may begin. RUNNING: its behavior runs.
    DOUBTFUL: it is to be looked what is done of it. FAILED: it is to be decided what to do.
    ASKING: an operator is to decide. ELSEWHERE: another cell has it.
    """

    WAITING = "waiting"
    READY = "ready"
    RUNNING = "running"
    DOUBTFUL = "doubtful"
    FAILED = "failed"
    ASKING = "asking"
    ELSEWHERE = "elsewhere"
    DONE = "done"
    SET_ASIDE = "set_aside"

    @property
    def is_lasting(self) -> bool:
        """Whether nothing more happens to the task by itself."""
        return self in (Stage.DONE, Stage.SET_ASIDE)


@dataclass(frozen=True)
class TaskProgress:
    """How far one task is.

    Attributes:
        part: that its next behavior does, or the one that runs.
        behavior: that was begun last.
        attempts: begun so far.
        interruptions: so far.
        connected: letters of the ends that were seen in their terminals.
        unseen: why it could not be seen what is done; empty if it could.
        operations: of the behavior that was begun last.
        failures: operations of all attempts that failed.
        then: what is done when the hand is empty, or it was looked what is done; None: nothing was
            decided yet.
        codes: that attempts ended with, the latest last.
        decisions: about it, the latest last.
        began_s: [s] ROS time of the behavior that was begun last.
        cell_s: [s] ROS time of all its behaviors that have ended.
    """

    name: str
    stage: Stage = Stage.WAITING
    part: Part = Part.WHOLE
    behavior: str = ""
    attempts: int = 0
    interruptions: int = 0
    connected: tuple[str, ...] = ()
    unseen: str = ""
    outcome: str = ""
    operations: tuple[Operation, ...] = ()
    failures: int = 0
    then: Do | None = None
    codes: tuple[int, ...] = ()
    decisions: tuple[Decided, ...] = ()
    began_s: float = 0.0
    cell_s: float = 0.0

    @property
    def hand_in_doubt(self) -> bool:
        """Whether its behavior may have ended with something in the hand: it lost its server."""
        last = self.operations[-1].error_code if self.operations else 0
        return self.part is not Part.CLEAR and last in _SERVER_TROUBLE

    @property
    def first_pass(self) -> bool:
        """Whether it was done at once, and nothing of it failed."""
        clean = self.attempts == 1 and not self.failures and not self.interruptions
        return self.stage is Stage.DONE and clean


@dataclass(frozen=True)
class RunState:
    """What is known of a run.

    Attributes:
        tasks: all tasks of the run, by name.
        waiting: names of those that wait for their turn, in the order of the plan.
        current: name of the task under way; empty between tasks.
        to_plan: why the order of the waiting tasks is to be decided anew; empty if it is not.
        skipped: names of tasks that an operator wants to be set aside, by whom.
        stop: why the run is to end; empty if it is not.
        question: that an operator is to answer; None if there is none.
        questions: how many were asked.
        failures: attempts that failed.
        cell_s: [s] ROS time of all behaviors.
    """

    order: str = ""
    use_case: str = ""
    cell: str = ""
    tasks: Mapping[str, TaskProgress] = field(default_factory=dict)
    waiting: tuple[str, ...] = ()
    current: str = ""
    to_plan: str = ""
    paused: bool = False
    skipped: Mapping[str, str] = field(default_factory=dict)
    stop: str = ""
    question: Asked | None = None
    questions: int = 0
    interruptions: int = 0
    failures: int = 0
    cell_s: float = 0.0
    ended: RunEnded | None = None

    def having(self, task: TaskProgress, **changes: object) -> RunState:
        """Return this state with other progress of a task, and other changes."""
        return replace(self, tasks={**self.tasks, task.name: task}, **changes)  # type: ignore[arg-type]

    def in_stage(self, *stages: Stage) -> tuple[str, ...]:
        """Return the names of the tasks in some stages."""
        return tuple(name for name, task in self.tasks.items() if task.stage in stages)


def state_after(events: Iterable[Event], state: RunState | None = None) -> RunState:
    """Return what is known after some events."""
    state = state or RunState()
    for event in events:
        state = applied(event, state)
    return state


def cause_of(operations: Sequence[Operation]) -> Operation | None:
    """Return the operation that a behavior failed with: the last that failed; None if none did.

    A behavior that gives up empties the hand last. That the hand is empty by then, or that a cell
    which was started anew knows nothing of the wire, is not the cause.
    """
    failed = [operation for operation in operations if operation.error_code]
    gave_up = failed[1:] and failed[-1] is operations[-1]
    if gave_up and failed[-1].error_code in _NOTHING_TO_LAY_DOWN:
        failed.pop()
    return failed[-1] if failed else None


@singledispatch
def applied(event: Event, state: RunState) -> RunState:
    """Return the state after an event."""
    raise TypeError(f"no event: {event!r}")


@applied.register
def _(event: RunBegun, state: RunState) -> RunState:
    tasks = {name: TaskProgress(name) for name in event.tasks}
    named = replace(state, order=event.order, use_case=event.use_case, cell=event.cell)
    return replace(named, tasks=tasks, waiting=event.tasks, to_plan="the run begins")


@applied.register
def _(event: Planned, state: RunState) -> RunState:
    return replace(state, waiting=event.tasks, to_plan="")


@applied.register
def _(event: TaskBegun, state: RunState) -> RunState:
    task = replace(
        state.tasks[event.task],
        stage=Stage.RUNNING,
        part=event.part,
        behavior=event.behavior,
        attempts=event.attempt,
        outcome="",
        operations=(),
        began_s=event.at_s,
    )
    return _under_way(state, task)


@applied.register
def _(event: OperationEnded, state: RunState) -> RunState:
    task, operation = state.tasks[event.task], event.operation
    failed = operation.error_code not in (0, _PREEMPTED_CODE)
    operations = (*task.operations, operation)
    return state.having(
        replace(task, operations=operations, failures=task.failures + failed),
    )


@applied.register
def _(event: TaskEnded, state: RunState) -> RunState:
    task = state.tasks[event.task]
    took_s = max(0.0, event.at_s - task.began_s)
    task = replace(task, outcome=event.outcome, cell_s=task.cell_s + took_s)
    cell_s = state.cell_s + took_s
    if task.part is Part.CLEAR:
        state = replace(state, cell_s=cell_s)
        if task.then is not None:
            return _act(task.then, state, replace(task, operations=()), "the hand is empty")
        return state.having(replace(task, stage=Stage.DOUBTFUL, part=Part.WHOLE))
    if event.outcome == FINISHED:
        return _left(state, replace(task, stage=Stage.DONE), cell_s=cell_s)
    cause = cause_of(task.operations)
    code = cause.error_code if cause else UNTOLD
    task = replace(task, stage=Stage.FAILED, codes=(*task.codes, code))
    stop = state.stop
    if event.outcome == PREEMPTED and not stop and task.name not in state.skipped:
        stop = f"somebody stopped the behavior of task {task.name}"
    return state.having(task, cell_s=cell_s, failures=state.failures + 1, stop=stop)


@applied.register
def _(event: Interrupted, state: RunState) -> RunState:
    state = replace(state, interruptions=state.interruptions + 1)
    if not state.current or state.tasks[state.current].stage is not Stage.RUNNING:
        return state
    task = state.tasks[state.current]
    task = replace(task, interruptions=task.interruptions + 1)
    if task.interruptions > INTERRUPTION_LIMIT:
        task = replace(task, stage=Stage.FAILED, codes=(*task.codes, _LOST))
        return state.having(task, failures=state.failures + 1)
    return state.having(replace(task, stage=Stage.READY, part=Part.CLEAR))


@applied.register
def _(event: Settled, state: RunState) -> RunState:
    task = replace(state.tasks[event.task], connected=event.connected, unseen=event.unseen)
    if not event.left and not event.unseen:
        return _left(state, replace(task, stage=Stage.DONE, then=None))
    if task.then is not None:
        return _do(task.then, state, replace(task, then=None), "it was looked what is done")
    if event.unseen:
        failed = replace(task, stage=Stage.FAILED, codes=(*task.codes, event.code))
        return _under_way(state, failed)
    part = Part.REST if event.connected else task.part
    return _under_way(state, replace(task, stage=Stage.READY, part=part))


@applied.register
def _(event: Decided, state: RunState) -> RunState:
    task = state.tasks[event.task]
    return _act(event.do, state, replace(task, decisions=(*task.decisions, event)), event.because)


@applied.register
def _(event: Asked, state: RunState) -> RunState:
    return replace(state, question=event, questions=event.number)


@applied.register
def _(event: Answered, state: RunState) -> RunState:
    if state.question is None:
        return state
    task = state.tasks[state.question.task]
    state = replace(state, question=None)
    because = f"{event.by} answered {event.choice.value} to question {event.number}"
    if event.choice is Answer.MARK_DONE:
        return _left(state, replace(task, stage=Stage.DONE))
    return _act(_ANSWERED[event.choice], state, task, because)


@applied.register
def _(event: Commanded, state: RunState) -> RunState:
    if event.command is Command.PAUSE:
        return replace(state, paused=True)
    if event.command is Command.RESUME:
        return replace(state, paused=False)
    if event.command is Command.STOP:
        return replace(state, stop=f"{event.by} stopped it")
    task = state.tasks[event.task]
    if event.command is Command.RETRY and task.stage is Stage.SET_ASIDE:
        again = replace(task, stage=Stage.DOUBTFUL, part=Part.WHOLE)
        return state.having(again, waiting=(*state.waiting, task.name))
    if event.command is Command.SKIP and task.name in state.waiting:
        return _left(state, replace(task, stage=Stage.SET_ASIDE))
    if event.command is Command.SKIP and task.name == state.current:
        return replace(state, skipped={**state.skipped, task.name: event.by})
    return state


@applied.register
def _(event: TaskElsewhere, state: RunState) -> RunState:
    return _left(state, replace(state.tasks[event.task], stage=_AS_LEFT[event.as_left]))


@applied.register
def _(event: TaskReturned, state: RunState) -> RunState:
    task = replace(state.tasks[event.task], stage=Stage.DOUBTFUL, part=Part.WHOLE)
    return state.having(task, waiting=(*state.waiting, task.name))


@applied.register
def _(event: Blocked, state: RunState) -> RunState:
    return replace(state, stop=event.because)


@applied.register
def _(event: RunEnded, state: RunState) -> RunState:
    return replace(state, ended=event)


# How often a task may be interrupted before that counts as its failure.
INTERRUPTION_LIMIT = 20

# remodel_msgs/ErrorCode: TIMEOUT, SERVER_LOST, INTERNAL, BUSY, SERVER_HUNG, CONTRADICTORY_RESULT.
_SERVER_TROUBLE = frozenset({1, 4, 5, 6, 7, 8})

# remodel_msgs/ErrorCode: NOTHING_HELD and WIRE_NOT_FED; PREEMPTED; SERVER_LOST; INTERNAL, of a
# task that failed though no ability told of an error.
_NOTHING_TO_LAY_DOWN = (202, 403)
_PREEMPTED_CODE = 2
_LOST = 4
UNTOLD = 5

_ANSWERED = {
    Answer.RETRY: Do.RETRY,
    Answer.FIXED: Do.RETRY,
    Answer.SKIP: Do.SET_ASIDE,
    Answer.REPLAN: Do.REPLAN,
    Answer.STOP: Do.STOP,
}
_AS_LEFT = {
    AsLeft.RUNNING: Stage.ELSEWHERE,
    AsLeft.DONE: Stage.DONE,
    AsLeft.SET_ASIDE: Stage.SET_ASIDE,
}
_AFTER_LOOKING = (Do.RETRY, Do.RETRY_WITH, Do.LOOK_AGAIN, Do.OTHER_METHOD)

# These give up the part, or its turn. After trouble with a server it is looked first: the task may
# be done, whatever the server said.
_GIVES_PART_UP = (Do.NEW_PART, Do.REPLAN, Do.SET_ASIDE)


def _act(do: Do, state: RunState, task: TaskProgress, because: str) -> RunState:
    """Return the state in which something is to be done about a task that failed."""
    if task.hand_in_doubt and do not in (Do.ASK_OPERATOR, Do.STOP):
        return state.having(replace(task, stage=Stage.READY, part=Part.CLEAR, then=do))
    in_doubt = task.codes[-1] in _SERVER_TROUBLE and task.name not in state.skipped
    if do in _GIVES_PART_UP and in_doubt:
        return state.having(replace(task, stage=Stage.DOUBTFUL, then=do))
    return _do(do, state, replace(task, then=None), because)


def _do(do: Do, state: RunState, task: TaskProgress, because: str) -> RunState:
    if do in _AFTER_LOOKING:
        return state.having(replace(task, stage=Stage.DOUBTFUL, part=Part.AGAIN))
    if do is Do.NEW_PART:
        return state.having(replace(task, stage=Stage.READY, part=Part.WHOLE, connected=()))
    if do is Do.ASK_OPERATOR:
        return state.having(replace(task, stage=Stage.ASKING))
    if do is Do.REPLAN:
        task = replace(task, stage=Stage.WAITING, part=Part.WHOLE, connected=())
        waiting = (*state.waiting, task.name)
        return state.having(task, current="", waiting=waiting, to_plan=f"{task.name}: {because}")
    state = _left(state, replace(task, stage=Stage.SET_ASIDE))
    return replace(state, stop=f"{task.name}: {because}") if do is Do.STOP else state


def _under_way(state: RunState, task: TaskProgress) -> RunState:
    waiting = tuple(name for name in state.waiting if name != task.name)
    return state.having(task, waiting=waiting, current=task.name)


def _left(state: RunState, task: TaskProgress, **changes: object) -> RunState:
    """Return the state after a task was done, set aside, or begun by another cell."""
    waiting = tuple(name for name in state.waiting if name != task.name)
    current = "" if state.current == task.name else state.current
    skipped = {name: by for name, by in state.skipped.items() if name != task.name}
    return state.having(task, waiting=waiting, current=current, skipped=skipped, **changes)
