"""How each event changes what is known of a run. Pure: the same events give the same state.

`event_table.py` says which event changes it how.
"""

from __future__ import annotations

from dataclasses import replace

from remodel_run.progress import Answer
from remodel_states.core.codes import Code
from remodel_supervision.core.run import EMPTYING, NOTHING_TO_LAY_DOWN, Operation
from remodel_supervision.core.runs import events
from remodel_supervision.core.runs.events import POLICY, AsLeft, Command, Part
from remodel_supervision.core.runs.state import (
    FINISHED,
    INTERRUPTION_LIMIT,
    PERSON_FIRST,
    PREEMPTED,
    SERVER_TROUBLE,
    STUCK_HAND_LIMIT,
    UNREPORTED,
    RunState,
    Stage,
    TaskProgress,
    cause_of,
    last_of_each_hand,
)
from remodel_tasks.core.use_case.fault import Do


def run_begun(event: events.RunBegun, state: RunState) -> RunState:
    """Return the state in which the order of the tasks is to be decided."""
    tasks = {name: TaskProgress(name) for name in event.tasks}
    tasks |= {name: TaskProgress(name, Stage.DONE, by_other=True) for name in event.done}
    return replace(
        state,
        order=event.order,
        use_case=event.use_case,
        cell=event.cell,
        serial=event.serial,
        keep_panel=event.keep_panel,
        timeout_s=event.timeout_s,
        tasks=tasks,
        cables=event.cables,
        by_hand=event.by_hand,
        waiting=tuple(name for name in event.tasks if tasks[name].stage is Stage.WAITING),
        to_plan="the run begins",
    )


def part_requested(event: events.PartRequested, state: RunState) -> RunState:
    """Return the state in which a piece of the task may be in the cell."""
    task = replace(state.tasks[event.task], stage=Stage.READY, piece=True)
    return replace(_under_way(state, task), fed=event.task)


def feed_refused(event: events.FeedRefused, state: RunState) -> RunState:
    """Return the state in which the task has failed without a behavior."""
    task = state.tasks[event.task]
    refused = Operation(
        "", "FeedWire", "refused", event.code, text=event.text, ended_s=event.at_s, elapsed_s=0.0
    )
    task = replace(
        task,
        stage=Stage.FAILED,
        attempts=task.attempts + 1,
        operations=(refused,),
        codes=(*task.codes, event.code),
        piece=event.code == Code.WIRE_LEFT_BEHIND,
        hand_may_hold=event.code == Code.OTHER_CABLE_HELD,
    )
    return state.with_task(task, failures=state.failures + 1)


def task_begun(event: events.TaskBegun, state: RunState) -> RunState:
    """Return the state in which a behavior of the task runs."""
    task = replace(
        state.tasks[event.task],
        stage=Stage.RUNNING,
        part=event.part,
        behavior=event.behavior,
        attempts=event.attempt,
        outcome="",
        operations=(),
        stopped_by=None,
        began_s=event.at_s,
    )
    return _under_way(state, task)


def operation_ended(event: events.OperationEnded, state: RunState) -> RunState:
    """Return the state with one operation more."""
    task, operation = state.tasks[event.task], event.operation
    operations = (*task.operations, operation)
    failures = task.failures + operation.has_failed
    return state.with_task(replace(task, operations=operations, failures=failures))


def stop_reported(event: events.StopReported, state: RunState) -> RunState:
    """Return the state in which a person is to answer before anything moves."""
    task = replace(state.tasks[event.task], stopped_by=event.operation)
    if task.stage is Stage.RUNNING:
        return state.with_task(task)  # its behavior is stopped first
    task = replace(task, hand_may_hold=True, unseen="")
    return _for_a_person(replace(state, question=None), task)


def task_ended(event: events.TaskEnded, state: RunState) -> RunState:
    """Return the state after a behavior that ended by itself."""
    task = state.tasks[event.task]
    took_s = max(0.0, event.at_s - task.began_s)
    task = replace(task, outcome=event.outcome, cell_s=task.cell_s + took_s)
    task = replace(task, hand_may_hold=_may_hold_something(task))
    state = replace(state, cell_s=state.cell_s + took_s)
    if task.stopped_by:
        return _for_a_person(state, replace(task, hand_may_hold=True))
    if task.needs_person:
        return _failed(state, task)
    if task.part is Part.CLEAR and not task.hand_may_hold:
        return _with_empty_hand(state, replace(task, stuck_hand=0))
    if task.part is Part.DISCARD and event.outcome == FINISHED:
        task = replace(task, piece=False, misplaced=False, undiscarded=False, connected=())
        return _do(task.then or Do.NEW_PART, state, task, "the piece is discarded")
    if task.part.is_attempt and event.outcome == FINISHED:
        if event.denied:
            then = _then_of_skipped(state, task)
            return state.with_task(
                replace(task, stage=Stage.UNVERIFIED, part=Part.AGAIN, then=then)
            )
        return _leave(state, replace(task, stage=Stage.DONE))
    return _failed(state, task)


def interrupted(event: events.Interrupted, state: RunState) -> RunState:
    """Return the state in which the progress of the task under way is unverified."""
    state = replace(state, interruptions=state.interruptions + 1)
    if not state.current or state.tasks[state.current].stage is not Stage.RUNNING:
        return state
    task = state.tasks[state.current]
    task = replace(
        task,
        interruptions=task.interruptions + 1,
        hand_may_hold=True,
        cell_s=task.cell_s + task.cut_s,
    )
    state = replace(state, cell_s=state.cell_s + task.cut_s)
    if task.stopped_by or task.needs_person:
        return _for_a_person(state, task)
    if task.interruptions > INTERRUPTION_LIMIT:
        task = replace(task, stage=Stage.FAILED, codes=(*task.codes, Code.SERVER_LOST))
        # What was decided then is interrupted, too.
        goes_on = task.interruptions <= 2 * INTERRUPTION_LIMIT
        stop = f"{task.name} was interrupted {task.interruptions} times: {event.because}"
        return state.with_task(
            task, failures=state.failures + 1, stop=state.stop if goes_on else stop
        )
    then = _then_of_skipped(state, task)
    return state.with_task(replace(task, stage=Stage.READY, part=Part.CLEAR, then=then))


def settled(event: events.Settled, state: RunState) -> RunState:
    """Return the state in which the progress of a task is known, or why it is not."""
    task = replace(state.tasks[event.task], connected=event.connected, unseen=event.unseen)
    is_connected = not event.left and not event.unseen
    if is_connected and not task.misplaced:
        return _leave(state, replace(task, stage=Stage.DONE, then=None))
    state = _under_way(state, task)
    if is_connected and task.then is None:
        codes = (*task.codes, Code.OUT_OF_DUCT)
        return state.with_task(replace(task, stage=Stage.FAILED, codes=codes))
    if task.then is not None and event.code not in PERSON_FIRST:
        return _do(task.then, state, task, "what is done was inspected")
    if event.unseen:
        return state.with_task(replace(task, stage=Stage.FAILED, codes=(*task.codes, event.code)))
    part = Part.REST if event.connected else task.part
    return state.with_task(replace(task, stage=Stage.READY, part=part))


def decided(event: events.Decided, state: RunState) -> RunState:
    """Return the state in which a decision is to be acted on."""
    task = state.tasks[event.task]
    return _act(event.do, state, replace(task, decisions=(*task.decisions, event)), event.because)


def answered(event: events.Answered, state: RunState) -> RunState:
    """Return the state in which an answer is to be acted on."""
    if state.question is None:
        return state
    task = replace(state.tasks[state.question.task], stuck_hand=0, stopped_by=None)
    state = replace(state, question=None)
    because = f"{event.by} answered {event.choice.value} to question {event.number}"
    if event.choice is Answer.FIXED:
        task = replace(task, misplaced=False)
    if event.choice is Answer.MARK_DONE:
        return _leave(state, replace(task, stage=Stage.DONE, hand_may_hold=False))
    return _act(_ANSWERED[event.choice], state, task, because)


def escalated(event: events.Escalated, state: RunState) -> RunState:
    """Return the state in which a question is not waited for any more."""
    if state.question is None or state.question.number != event.number:
        return state
    because = f"question {event.number} was not answered in time"
    task = replace(state.tasks[event.task], stopped_by=None)
    return _act(event.do, replace(state, question=None), task, because)


def commanded(event: events.Commanded, state: RunState) -> RunState:
    """Return the state after a command."""
    match event.command:
        case Command.PAUSE:
            return replace(state, paused=True)
        case Command.PROTECTIVE_STOP:
            return replace(state, paused=True, protective=event.by)
        case Command.RELEASE:
            return replace(state, protective="")
        case Command.RESUME:
            return replace(state, paused=False, protective="")
        case Command.STOP:
            return replace(state, stop=f"{event.by} stopped it")
        case Command.RETRY:
            return _retried(state, state.tasks[event.task])
        case Command.SKIP:
            return _skipped(state, state.tasks[event.task], event.by)


def _retried(state: RunState, task: TaskProgress) -> RunState:
    if task.stage is not Stage.SET_ASIDE:
        return state
    # Cells take up only the wire that was fed last: a piece of another one is replaced.
    is_out_of_reach = task.piece and not task.unseen and state.fed != task.name
    then = Do.NEW_PART if is_out_of_reach or task.misplaced else None
    part = Part.AGAIN if task.piece else Part.WHOLE
    task = replace(task, stage=Stage.UNVERIFIED, part=part, then=then, by_other=False)
    return state.with_task(task, waiting=(*state.waiting, task.name))


def _skipped(state: RunState, task: TaskProgress, by: str) -> RunState:
    if task.name in state.waiting:
        return _leave(state, replace(task, stage=Stage.SET_ASIDE))
    if task.name != state.current:
        return state
    state = replace(state, skipped={**state.skipped, task.name: by})
    if task.stage is Stage.RUNNING and not task.part.is_attempt:
        return state.with_task(replace(task, then=Do.SET_ASIDE))
    if task.stage in (Stage.READY, Stage.UNVERIFIED) and not task.stuck_hand:
        return _act(Do.SET_ASIDE, state, task, f"{by} skipped it")
    return state


def _then_of_skipped(state: RunState, task: TaskProgress) -> Do | None:
    """Return what follows once the hand is empty: a task that is to be skipped is left."""
    return Do.SET_ASIDE if task.name in state.skipped else task.then


def task_elsewhere(event: events.TaskElsewhere, state: RunState) -> RunState:
    """Return the state in which a task is another cell's."""
    task = state.tasks[event.task]
    stop = state.stop
    if task.stopped_by or (task.stage is Stage.RUNNING and task.needs_person):
        stop = stop or f"another cell has {task.name}; a person is needed at the arm of this one"
    task = replace(task, stage=_AS_LEFT[event.as_left], stopped_by=None, by_other=True)
    return _leave(state, task, stop=stop)


def task_returned(event: events.TaskReturned, state: RunState) -> RunState:
    """Return the state in which a task of another cell is this one's to inspect."""
    task = replace(state.tasks[event.task], stage=Stage.UNVERIFIED, part=Part.AGAIN, piece=True)
    task = replace(task, by_other=False)
    waiting = tuple(name for name in state.waiting if name != task.name)
    return state.with_task(task, waiting=(*waiting, task.name))


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
_AFTER_INSPECTING = (Do.RETRY, Do.RETRY_WITH, Do.LOOK_AGAIN, Do.OTHER_METHOD)
_WITHOUT_MOTION = (Do.ASK_OPERATOR, Do.STOP)

# These give up the piece, or its turn. After trouble with a server the ends are inspected first:
# the task may be done, whatever the server reported.
_GIVES_PIECE_UP = (Do.NEW_PART, Do.OTHER_END, Do.REPLAN, Do.SET_ASIDE)


def _may_hold_something(task: TaskProgress) -> bool:
    """Return whether a hand may hold something after the behavior that ended."""
    if task.outcome == PREEMPTED:
        return True
    if not task.operations:
        return task.part is Part.CLEAR and task.outcome != FINISHED
    if task.needs_person:
        return True  # it was not allowed to lay down what it held
    # Each operation that clears, or gives up, is of a hand of its own.
    clearing = task.part is Part.CLEAR
    telling = task.operations if clearing else last_of_each_hand(task.operations)
    return any(_may_have_left_something(each) for each in telling)


def _may_have_left_something(operation: Operation) -> bool:
    """Return whether a hand may hold something after an operation."""
    code = operation.error_code
    if code in NOTHING_TO_LAY_DOWN or not code:
        return False
    in_trouble = code in SERVER_TROUBLE or code == Code.OTHER_CABLE_HELD
    return in_trouble or operation.ability in EMPTYING


def _failed(state: RunState, task: TaskProgress) -> RunState:
    """Return the state after a behavior that did not do what it should."""
    cause = cause_of(task.operations)
    code = cause.error_code if cause else UNREPORTED
    stop = state.stop
    if task.outcome == PREEMPTED and not stop and task.name not in state.skipped:
        stop = f"the behavior of task {task.name} was stopped by another client of the engine"
    if task.part is Part.CLEAR:
        task = replace(task, stuck_hand=task.stuck_hand + 1)
        if task.stuck_hand <= STUCK_HAND_LIMIT and code not in PERSON_FIRST:
            return state.with_task(replace(task, stage=Stage.READY), stop=stop)
    task = replace(
        task,
        stage=Stage.FAILED,
        codes=(*task.codes, code),
        misplaced=task.misplaced or code == Code.OUT_OF_DUCT,
        undiscarded=task.undiscarded or task.part is Part.DISCARD,
    )
    return state.with_task(task, failures=state.failures + 1, stop=stop)


def _for_a_person(state: RunState, task: TaskProgress) -> RunState:
    """Return the state in which a person is to be asked, whatever was to follow."""
    late = (task.stopped_by,) if task.stopped_by else ()
    task = replace(task, operations=(*task.operations, *late), failures=task.failures + len(late))
    cause = cause_of(task.operations)
    code = cause.error_code if cause else UNREPORTED
    task = replace(task, stage=Stage.FAILED, codes=(*task.codes, code))
    return state.with_task(task, failures=state.failures + 1)


def _act(do: Do, state: RunState, task: TaskProgress, because: str) -> RunState:
    """Return the state in which something is to be done about a task that failed."""
    if task.hand_may_hold and do not in _WITHOUT_MOTION:
        return state.with_task(replace(task, stage=Stage.READY, part=Part.CLEAR, then=do))
    if do in _GIVES_PIECE_UP and _is_to_be_inspected(do, task):
        return state.with_task(replace(task, stage=Stage.UNVERIFIED, then=do))
    return _do(do, state, task, because)


def _with_empty_hand(state: RunState, task: TaskProgress) -> RunState:
    """Return the state after the hand was emptied."""
    if task.then is None:
        return state.with_task(replace(task, stage=Stage.UNVERIFIED, part=Part.AGAIN))
    return _act(task.then, state, replace(task, part=Part.AGAIN), "the hand is empty")


def _is_to_be_inspected(do: Do, task: TaskProgress) -> bool:
    in_trouble = bool(task.codes) and task.codes[-1] in SERVER_TROUBLE
    loose = do is Do.SET_ASIDE and task.piece and not task.undiscarded
    return in_trouble or loose


def _do(do: Do, state: RunState, task: TaskProgress, because: str) -> RunState:
    if do in _AFTER_INSPECTING:
        is_there = task.piece and task.codes[-1:] != (Code.WIRE_NOT_FED,)
        part = Part.AGAIN if is_there else Part.WHOLE
        return state.with_task(replace(task, stage=Stage.UNVERIFIED, part=part, then=None))
    if do in _GIVES_PIECE_UP and _is_to_be_discarded(do, task):
        return state.with_task(replace(task, stage=Stage.READY, part=Part.DISCARD, then=do))
    task = replace(task, then=None)
    if do in (Do.NEW_PART, Do.OTHER_END):
        return state.with_task(replace(task, stage=Stage.READY, part=Part.WHOLE, connected=()))
    if do is Do.ASK_OPERATOR:
        return state.with_task(replace(task, stage=Stage.ASKING))
    if do is Do.REPLAN:
        task = replace(task, stage=Stage.WAITING, part=Part.WHOLE, connected=())
        waiting = (*state.waiting, task.name)
        return state.with_task(task, current="", waiting=waiting, to_plan=f"{task.name}: {because}")
    state = _leave(state, replace(task, stage=Stage.SET_ASIDE))
    return replace(state, stop=f"{task.name}: {because}") if do is Do.STOP else state


def _is_to_be_discarded(do: Do, task: TaskProgress) -> bool:
    """Return whether the piece is taken away first: left there, it would be in others' way.

    What is connected of a task that a person skips is left to that person.
    """
    if not task.piece:
        return False
    if do is not Do.SET_ASIDE:
        return True
    by = task.decisions[-1].by if task.decisions else POLICY
    to_person = bool(task.connected) and by != POLICY
    stuck = task.undiscarded or Code.EXTRACTION_STUCK in task.codes
    return not (to_person or stuck)


def _under_way(state: RunState, task: TaskProgress) -> RunState:
    waiting = tuple(name for name in state.waiting if name != task.name)
    return state.with_task(task, waiting=waiting, current=task.name)


def _leave(state: RunState, task: TaskProgress, **changes: object) -> RunState:
    """Return the state after a task was done, skipped, or begun by another cell."""
    if task.stage is Stage.DONE:
        task = replace(task, operations=())  # the log has them; a long run need not carry them
    waiting = tuple(name for name in state.waiting if name != task.name)
    current = "" if state.current == task.name else state.current
    skipped = {name: by for name, by in state.skipped.items() if name != task.name}
    return state.with_task(task, waiting=waiting, current=current, skipped=skipped, **changes)
