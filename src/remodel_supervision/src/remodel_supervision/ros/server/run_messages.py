"""A run as messages: the small state, its levels, tasks and failures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass

import rospy
from remodel_msgs.msg import (
    FailureState,
    HandWire,
    LevelState,
    OperatorQuestion,
    RunSums,
    TaskState,
    UseCaseState,
)

from remodel_run import progress
from remodel_run.progress import Phase, Sums, TaskPhase
from remodel_supervision.core.runs.events import Decided
from remodel_supervision.core.runs.state import RunState, Stage
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
