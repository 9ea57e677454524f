"""A run's events as the entries that a console replays: remodel_msgs/RunEntry.

What a behavior did comes when it has ended, in the order of time, so that entries are only added.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import singledispatchmethod

import rospy
from remodel_msgs.msg import RunEntry

from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import (
    Answered,
    Asked,
    AsLeft,
    Blocked,
    Commanded,
    Decided,
    Escalated,
    Event,
    FeedRefused,
    Interrupted,
    OperationEnded,
    PanelLoaded,
    PartRequested,
    Planned,
    RunBegun,
    RunEnded,
    Settled,
    StopReported,
    TaskBegun,
    TaskElsewhere,
    TaskEnded,
    TaskReturned,
)
from remodel_supervision.core.runs.picture_name import seen_by
from remodel_supervision.core.runs.sums import begun_words

# Units of what operations measure, by the name of the result's field.
_UNITS = {"depth": "m", "peak_force": "n", "slip": "m", "residual": "m", "travelled": "m"}

_AS_LEFT = {
    AsLeft.RUNNING: "has it",
    AsLeft.DONE: "has done it",
    AsLeft.SET_ASIDE: "has skipped it",
}


def entries_of(events: Sequence[Event]) -> list[RunEntry]:
    """Return the entries of a run; a picture's entry has its file's name in `because`."""
    writer = _Writer()
    entries = [entry for event in events for entry in writer.entries(event)]
    for position, entry in enumerate(entries, 1):
        entry.position = position
    return entries


@dataclass
class _Writer:
    """Writes entries, event by event.

    Attributes:
        now_s: [s] ROS time of the latest event that has one.
        behavior: entries of the behavior that runs.
    """

    now_s: float = 0.0
    name: str = ""
    behavior: list[RunEntry] = field(default_factory=list)

    def entries(self, event: Event) -> Iterator[RunEntry]:
        """Yield what is to be written after an event."""
        for entry in self._of(event):
            if not entry.stamp:
                entry.stamp = rospy.Time.from_sec(self.now_s)
            yield entry

    @singledispatchmethod
    def _of(self, event: Event) -> Iterable[RunEntry]:
        raise TypeError(f"no event: {event!r}")

    @_of.register
    def _of_run_begun(self, event: RunBegun) -> Iterable[RunEntry]:
        return [RunEntry(kind=RunEntry.RUN, text=f"begun: {begun_words(event)}")]

    @_of.register
    def _of_planned(self, event: Planned) -> Iterable[RunEntry]:
        text = f"planned: {' '.join(event.tasks)}"
        return [RunEntry(kind=RunEntry.DECISION, text=text, because=event.because)]

    @_of.register
    def _of_task_begun(self, event: TaskBegun) -> Iterable[RunEntry]:
        self.now_s, self.name = event.at_s, event.behavior
        learned = [f"{each.parameter} {each.value:g} at {each.step}" for each in event.chosen]
        text = ", ".join([f"attempt {event.attempt}: {event.part.value}", *learned])
        entry = RunEntry(kind=RunEntry.TASK, task=event.task, behavior=event.behavior, text=text)
        self.behavior = []
        return [entry]

    @_of.register
    def _of_operation_ended(self, event: OperationEnded) -> Iterable[RunEntry]:
        self.now_s = event.operation.ended_s
        self.behavior += self._operation(event.task, event.operation)
        return []

    @_of.register
    def _of_stop_reported(self, event: StopReported) -> Iterable[RunEntry]:
        return self._operation(event.task, event.operation)

    @_of.register
    def _of_task_ended(self, event: TaskEnded) -> Iterable[RunEntry]:
        self.now_s = event.at_s
        pictures = [self._picture(event.task, name) for name in event.pictures]
        entries = sorted((*self.behavior, *pictures), key=lambda entry: entry.stamp.to_sec())
        left = RunEntry(kind=RunEntry.STATE, task=event.task, behavior=self.name)
        ended = RunEntry(kind=RunEntry.TASK, task=event.task, text=event.outcome)
        self.behavior = []
        return [*entries, left, ended]

    @_of.register
    def _of_interrupted(self, event: Interrupted) -> Iterable[RunEntry]:
        entries, self.behavior = self.behavior, []
        return [*entries, RunEntry(kind=RunEntry.RUN, text=f"interrupted: {event.because}")]

    @_of.register
    def _of_settled(self, event: Settled) -> Iterable[RunEntry]:
        seen = event.unseen or f"connected: {' '.join(event.connected) or 'no end'}"
        text = f"inspected: {seen}"
        return [RunEntry(kind=RunEntry.TASK, task=event.task, text=text, error_code=event.code)]

    @_of.register
    def _of_decided(self, event: Decided) -> Iterable[RunEntry]:
        self.now_s = event.at_s
        failure = RunEntry(
            kind=RunEntry.FAILURE,
            task=event.task,
            state_path=event.state_path,
            ability=event.ability,
            fault=event.fault,
            error_code=event.code,
            text=event.text,
        )
        decision = RunEntry(
            kind=RunEntry.DECISION,
            task=event.task,
            text=event.do.value,
            because=event.because,
            names=[name for name, _ in event.change],
            values=[value for _, value in event.change],
        )
        return [failure, decision]

    @_of.register
    def _of_asked(self, event: Asked) -> Iterable[RunEntry]:
        return [RunEntry(kind=RunEntry.OPERATOR, task=event.task, text=f"asked: {event.text}")]

    @_of.register
    def _of_answered(self, event: Answered) -> Iterable[RunEntry]:
        text = f"answered: {event.choice.value}"
        return [RunEntry(kind=RunEntry.OPERATOR, text=text, because=event.by)]

    @_of.register
    def _of_escalated(self, event: Escalated) -> Iterable[RunEntry]:
        text = f"not answered in time: {event.do.value}"
        return [RunEntry(kind=RunEntry.OPERATOR, task=event.task, text=text)]

    @_of.register
    def _of_panel_loaded(self, event: PanelLoaded) -> Iterable[RunEntry]:
        return [RunEntry(kind=RunEntry.RUN, text=f"panel of {event.serial or 'the order'} loaded")]

    @_of.register
    def _of_part_requested(self, event: PartRequested) -> Iterable[RunEntry]:
        return [RunEntry(kind=RunEntry.TASK, task=event.task, text="a new piece is presented")]

    @_of.register
    def _of_feed_refused(self, event: FeedRefused) -> Iterable[RunEntry]:
        self.now_s = event.at_s
        text = f"no piece was presented: {event.text}"
        return [RunEntry(kind=RunEntry.TASK, task=event.task, text=text, error_code=event.code)]

    @_of.register
    def _of_commanded(self, event: Commanded) -> Iterable[RunEntry]:
        text = event.command.value
        return [RunEntry(kind=RunEntry.OPERATOR, task=event.task, text=text, because=event.by)]

    @_of.register
    def _of_task_elsewhere(self, event: TaskElsewhere) -> Iterable[RunEntry]:
        text = f"cell {event.cell} {_AS_LEFT[event.as_left]}"
        return [RunEntry(kind=RunEntry.TASK, task=event.task, text=text)]

    @_of.register
    def _of_task_returned(self, event: TaskReturned) -> Iterable[RunEntry]:
        text = f"taken over from cell {event.cell}"
        return [RunEntry(kind=RunEntry.TASK, task=event.task, text=text)]

    @_of.register
    def _of_blocked(self, event: Blocked) -> Iterable[RunEntry]:
        return [RunEntry(kind=RunEntry.RUN, text=f"cannot go on: {event.because}")]

    @_of.register
    def _of_run_ended(self, event: RunEnded) -> Iterable[RunEntry]:
        text = f"ended {event.ending.value}"
        return [RunEntry(kind=RunEntry.RUN, text=text, because=event.because)]

    def _operation(self, task: str, operation: Operation) -> Iterator[RunEntry]:
        common = {
            "task": task,
            "behavior": self.name,
            "state_path": operation.state_path,
            "ability": operation.ability,
        }
        begun = rospy.Time.from_sec(max(0.0, operation.ended_s - operation.elapsed_s))
        yield RunEntry(kind=RunEntry.STATE, stamp=begun, **common)
        measured = list(_numbers(operation.measurements))
        yield RunEntry(
            kind=RunEntry.RESULT,
            stamp=rospy.Time.from_sec(operation.ended_s),
            error_code=operation.error_code,
            text=operation.text,
            names=[name for name, _ in measured],
            values=[value for _, value in measured],
            **common,
        )

    def _picture(self, task: str, name: str) -> RunEntry:
        camera, stamp_s = seen_by(name)
        return RunEntry(
            kind=RunEntry.PICTURE,
            stamp=rospy.Time.from_sec(stamp_s),
            task=task,
            behavior=self.name,
            text=camera,
            because=name,
            has_picture=True,
        )


def _numbers(pairs: Iterable[tuple[str, str]]) -> Iterator[tuple[str, float]]:
    for name, value in pairs:
        try:
            number = float(value)
        except ValueError:
            continue
        yield (f"{name}_{_UNITS[name]}" if name in _UNITS else name), number
