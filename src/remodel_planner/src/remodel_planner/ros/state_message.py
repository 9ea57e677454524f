"""What is known of a run, as remodel_msgs/UseCaseState."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import chain

import rospy
from remodel_msgs.msg import (
    FailureState,
    LevelState,
    OperatorQuestion,
    TaskState,
    UseCaseState,
)

from remodel_planner.core.supervision.events import Decided
from remodel_planner.core.supervision.state import RunState, Stage, TaskProgress
from remodel_planner.core.supervision.step import Plan, Settle, Wait, next_step
from remodel_planner.ros.use_case_supervisor import UseCaseSupervisor

_STATES = {
    Stage.WAITING: TaskState.WAITING,
    Stage.ELSEWHERE: TaskState.WAITING,
    Stage.DONE: TaskState.DONE,
    Stage.SET_ASIDE: TaskState.SET_ASIDE,
}


def state_message(
    supervisor: UseCaseSupervisor, descriptions: Mapping[str, str], started: rospy.Time
) -> UseCaseState:
    """Return the message.

    Args:
        supervisor: of the run.
        descriptions: of the tasks, for a person, by name.
        started: ROS time at which this supervisor took the run up.
    """
    state = supervisor.state
    asked = state.question
    return UseCaseState(
        stamp=rospy.Time.now(),
        phase=_phase(state),
        message=state.ended.because if state.ended else supervisor.doing,
        cell=state.cell,
        run=supervisor.run,
        order=state.order,
        use_case=state.use_case,
        started=started,
        interruptions=state.interruptions,
        tasks=[
            _task(state.tasks[name], descriptions.get(name, ""), supervisor)
            for name in _in_order(state)
        ],
        task=state.current,
        levels=levels(supervisor),
        failures=[_failure(decision) for decision in _decisions(state)],
        question=OperatorQuestion(
            asked.number, asked.task, asked.text, [choice.value for choice in asked.choices]
        )
        if asked
        else OperatorQuestion(),
    )


def levels(supervisor: UseCaseSupervisor) -> list[LevelState]:
    """Return what the four levels of a run are doing, from use case to action."""
    state = supervisor.state
    task = state.tasks.get(state.current)
    found = [LevelState(level=LevelState.USE_CASE, name=state.order, doing=supervisor.doing)]
    if task is None or task.stage is not Stage.RUNNING:
        empty = (LevelState.TASK, LevelState.BEHAVIOR, LevelState.ACTION)
        return found + [LevelState(level=level) for level in empty]
    since = rospy.Time.from_sec(task.began_s)
    doing = supervisor.doing_now
    found.append(LevelState(LevelState.TASK, task.name, f"attempt {task.attempts}", since))
    found.append(LevelState(LevelState.BEHAVIOR, task.behavior, supervisor.state_path, since))
    if doing is None:
        return [*found, LevelState(level=LevelState.ACTION)]
    text = f"{doing.text} ({doing.percent:.0f} %)"
    begun = rospy.Time.from_sec(max(0.0, doing.since_s))
    return [*found, LevelState(LevelState.ACTION, doing.ability, text, begun)]


def _phase(state: RunState) -> str:
    if state.ended is not None:
        return UseCaseState.ENDED
    if state.question is not None:
        return UseCaseState.ASKING
    if state.paused:
        return UseCaseState.PAUSED
    task = state.tasks.get(state.current)
    if task is not None and task.stage is Stage.RUNNING:
        return UseCaseState.RUNNING
    match next_step(state):
        case Plan():
            return UseCaseState.PLANNING
        case Settle():
            return UseCaseState.SETTLING
        case Wait():
            return UseCaseState.PAUSED
    return UseCaseState.RUNNING


def _in_order(state: RunState) -> list[str]:
    """Return the tasks' names: what has ended, what is under way, what waits."""
    ahead = [state.current] if state.current else []
    ahead += state.waiting
    return [name for name in state.tasks if name not in ahead] + ahead


def _task(task: TaskProgress, description: str, supervisor: UseCaseSupervisor) -> TaskState:
    return TaskState(
        name=task.name,
        description=description,
        state=_STATES.get(
            task.stage,
            TaskState.RUNNING if task.name == supervisor.state.current else TaskState.WAITING,
        ),
        attempts=task.attempts,
        first_pass=task.first_pass,
        taken_s=task.cell_s,
        expected_s=0.0 if task.stage.is_lasting else supervisor.work.planner.expected_s(task.name),
    )


def _decisions(state: RunState) -> list[Decided]:
    found = chain.from_iterable(task.decisions for task in state.tasks.values())
    return sorted(found, key=lambda decision: decision.at_s)


def _failure(decision: Decided) -> FailureState:
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
