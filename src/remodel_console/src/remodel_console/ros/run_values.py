"""Messages about a run, as the console's values."""

from __future__ import annotations

from dataclasses import fields

from remodel_msgs import msg, srv

from remodel_console.core.use_case.task_copy import Changes, Snapshot, TaskCopy
from remodel_console.core.use_case.use_case import Failure, Level, Question, Task, UseCase
from remodel_run.progress import Answer, Count, HandWire, Phase, Sums, TaskPhase


def use_case_of(message: msg.UseCaseState, copy: TaskCopy) -> UseCase:
    """Return the run of a state, with the tasks and failures of a copy if it is of this run."""
    has_tasks = copy.series == message.series
    return UseCase(
        phase=Phase(message.phase),
        stamp_s=message.stamp.to_sec(),
        message=message.message,
        cell=message.cell,
        run=message.run,
        order=message.order,
        use_case=message.use_case,
        serial=message.serial,
        started_s=message.started.to_sec(),
        interruptions=message.interruptions,
        stopped_by=message.stopped_by,
        controllers=tuple(message.controllers),
        sums=sums_of(message.sums),
        by_hand=copy.by_hand if has_tasks else (),
        tasks=copy.in_order if has_tasks else (),
        task=message.task,
        levels=tuple(Level(m.level, m.name, m.doing, m.since.to_sec()) for m in message.levels),
        failures=copy.failures if has_tasks else (),
        question=_question(message.question) if message.question.number else None,
    )


def changes_of(message: msg.UseCaseChanges) -> Changes:
    """Return what has changed in the tasks."""
    return Changes(
        message.series,
        message.number,
        tuple(map(_task, message.tasks)),
        tuple(map(_failure, message.failures)),
        replanned=message.replanned,
    )


def snapshot_of(answer: srv.GetTasksResponse) -> Snapshot:
    """Return all tasks."""
    return Snapshot(
        answer.series,
        answer.number,
        tuple(map(_task, answer.tasks)),
        tuple(map(_failure, answer.failures)),
        tuple(map(_hand_wire, answer.by_hand)),
    )


def sums_of(message: msg.RunSums) -> Sums:
    """Return the sums of a run."""
    return Sums(**{each.name: getattr(message, each.name) for each in fields(Sums)})


def _hand_wire(message: msg.HandWire) -> HandWire:
    return HandWire(
        name=message.name,
        marker=message.marker,
        a=message.a,
        b=message.b,
        colour=message.colour,
        section_mm2=message.section,
        length_m=message.length,
        reason=message.reason,
    )


def _question(message: msg.OperatorQuestion) -> Question:
    known = {choice.value: choice for choice in Answer}
    return Question(
        number=message.number,
        task=message.task,
        text=message.text,
        choices=tuple(known[one] for one in message.choices if one in known),
        asked_s=message.asked.to_sec(),
        timeout_s=message.timeout,
    )


def _task(message: msg.TaskState) -> Task:
    return Task(
        name=message.name,
        description=message.description,
        phase=TaskPhase(message.state),
        attempts=message.attempts,
        first_pass=message.first_pass,
        taken_s=message.taken_s,
        expected_s=message.expected_s,
        cable=message.cable,
        counts_as=Count(message.counts_as),
    )


def _failure(message: msg.FailureState) -> Failure:
    return Failure(
        time_s=message.stamp.to_sec(),
        task=message.task,
        fault=message.fault,
        error_code=message.error_code,
        ability=message.ability,
        text=message.text,
        decision=message.decision,
        because=message.because,
    )
