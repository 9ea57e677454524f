"""What happens in a run of an order.

An event is committed before anything that follows from it begins, so that a run whose processes
are killed goes on from the last one. Tasks, behaviors and ends are named; times are [s] ROS time.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import cast, get_args

import msgspec

from remodel_production.errors import OrderError
from remodel_run.progress import Answer, HandWire
from remodel_run.whole_task import WholeTask, whole_tasks
from remodel_supervision.core.run import Operation
from remodel_tasks.core.use_case.fault import Do

# Who decides, when no operator does.
POLICY = "policy"


class Part(Enum):
    """What of a task a behavior does.

    WHOLE: all of it, with a new piece. AGAIN: all of it, with the piece that is in the cell. REST:
    what is left after an end is connected. CLEAR: lay down whatever the hand holds. DISCARD: take
    the piece off the panel, into the scrap bin.
    """

    WHOLE = "whole"
    AGAIN = "again"
    REST = "rest"
    CLEAR = "clear"
    DISCARD = "discard"

    @property
    def is_attempt(self) -> bool:
        """Whether it works towards the task, and counts as an attempt at it."""
        return self not in (Part.CLEAR, Part.DISCARD)


class Ending(Enum):
    """How a run ends."""

    COMPLETE = "complete"
    INCOMPLETE = "incomplete"
    STOPPED = "stopped"


class AsLeft(Enum):
    """How a cell has left a task."""

    RUNNING = "running"
    DONE = "done"
    SET_ASIDE = "set aside"


class Command(Enum):
    """What an operator, or a safety controller, asks of a run.

    PAUSE lets the operation under way end; PROTECTIVE_STOP and STOP cancel it. RELEASE ends a
    protective stop, and the run stays paused. After a pause or a protective stop the run goes on
    with RESUME.
    """

    PAUSE = "pause"
    PROTECTIVE_STOP = "protective_stop"
    RELEASE = "release"
    RESUME = "resume"
    STOP = "stop"
    SKIP = "skip"
    RETRY = "retry"


@dataclass(frozen=True)
class RunBegun:
    """A run began.

    Attributes:
        serial: serial number of the product that is wired, such as "house-0003".
        keep_panel: whether wires of this product may be on its panel already.
        timeout_s: [s] ROS time after which the run stops; 0: never.
        cables: of which tasks place cores, beside others, by the task's name.
        done: tasks that earlier runs of the product, or other cells, have done.
        by_hand: wires of the order that are no tasks of the run.
    """

    order: str
    use_case: str
    cell: str
    tasks: tuple[str, ...]
    serial: str = ""
    keep_panel: bool = False
    timeout_s: float = 0.0
    cables: Mapping[str, str] = field(default_factory=dict)
    done: tuple[str, ...] = ()
    by_hand: tuple[HandWire, ...] = ()

    @property
    def whole_tasks(self) -> tuple[WholeTask, ...]:
        """The tasks as they are counted: the cores of a cable are one."""
        return whole_tasks((name, self.cables.get(name, "")) for name in self.tasks)


@dataclass(frozen=True)
class PanelLoaded:
    """The cell has the panel of the product."""

    serial: str


@dataclass(frozen=True)
class Planned:
    """The order of the tasks that wait was decided."""

    tasks: tuple[str, ...]
    because: str


@dataclass(frozen=True)
class Chosen:
    """A parameter with which a step's ability is called, as learning chose it.

    Attributes:
        step: title of the step of the task.
        ability: such as "InsertCable".
    """

    step: str
    ability: str
    parameter: str
    value: float


@dataclass(frozen=True)
class PartRequested:
    """The feeder is about to be asked for a piece of the task's wire."""

    task: str


@dataclass(frozen=True)
class FeedRefused:
    """The feeder did not present the piece.

    Attributes:
        code: remodel_msgs/ErrorCode.
    """

    task: str
    code: int
    text: str
    at_s: float


@dataclass(frozen=True)
class TaskBegun:
    """A behavior of a task is about to be started.

    Attributes:
        attempt: at the task, from 1; clearing the hand and discarding belong to the one before.
        chart: the behavior's chart, XML.
        chosen: parameters that are not those of the use case.
    """

    task: str
    attempt: int
    part: Part
    behavior: str
    chart: str
    at_s: float
    chosen: tuple[Chosen, ...] = ()


@dataclass(frozen=True)
class OperationEnded:
    """An ability was executed."""

    task: str
    operation: Operation

    @property
    def at_s(self) -> float:
        """[s] ROS time at which it ended."""
        return self.operation.ended_s


@dataclass(frozen=True)
class StopReported:
    """An operation of a behavior that was given up turned out to have ended with a fault.

    A person is to answer before anything moves again, but the behavior was stopped, or its
    supervisor killed, before the record of the operation was kept.

    Attributes:
        task: under way now.
    """

    task: str
    operation: Operation


@dataclass(frozen=True)
class TaskEnded:
    """The behavior of the task under way ended by itself.

    Attributes:
        placed: whether the cell's ground truth finds the wire placed; of a cell without one,
            whether the behavior did the task and finished.
        path: of the states that were entered, as the engine published them.
        pictures: names of files in the run's folder.
        denied: whether the cell knows the wire, and knows that it is not placed: a task that ended
            well is then inspected before it counts as done.
    """

    task: str
    outcome: str
    at_s: float
    placed: bool
    path: tuple[str, ...] = ()
    pictures: tuple[str, ...] = ()
    denied: bool = False


@dataclass(frozen=True)
class Interrupted:
    """Something that the run needs was lost; the progress of the task under way is unverified."""

    because: str


@dataclass(frozen=True)
class Settled:
    """The progress of a task was inspected.

    Attributes:
        connected: letters of the ends that were seen in their terminals.
        left: how many steps of the task are left after them.
        code: remodel_msgs/ErrorCode of the inspection that failed; 0 if none did.
        unseen: why it could not be seen; empty if it was.
    """

    task: str
    connected: tuple[str, ...]
    left: int
    code: int = 0
    unseen: str = ""


@dataclass(frozen=True)
class Decided:
    """It was decided what to do about a failure.

    Attributes:
        ability: that failed; empty if none did.
        state_path: of the state that asked for it; empty without one.
        change: parameter -> new value; only with Do.RETRY_WITH and Do.LOOK_AGAIN.
        by: who decided: POLICY, or an operator's name.
    """

    task: str
    fault: str
    code: int
    ability: str
    state_path: str
    text: str
    do: Do
    change: tuple[tuple[str, float], ...]
    because: str
    by: str
    at_s: float


@dataclass(frozen=True)
class Asked:
    """An operator was asked.

    Attributes:
        at_s: [s] ROS time.
        timeout_s: [s] ROS time after which the question escalates; 0: never.
    """

    number: int
    task: str
    text: str
    choices: tuple[Answer, ...]
    at_s: float = 0.0
    timeout_s: float = 0.0


@dataclass(frozen=True)
class Escalated:
    """A question was not answered in time.

    Attributes:
        do: what is done instead.
    """

    number: int
    task: str
    do: Do


@dataclass(frozen=True)
class Answered:
    """An operator has answered."""

    number: int
    choice: Answer
    by: str


@dataclass(frozen=True)
class Commanded:
    """A command was given; the task is empty where it is about the run."""

    command: Command
    task: str
    by: str


@dataclass(frozen=True)
class TaskElsewhere:
    """Another cell has this task, or has had it.

    Attributes:
        as_left: how that cell has left it; RUNNING while it has it.
    """

    task: str
    cell: str
    as_left: AsLeft


@dataclass(frozen=True)
class TaskReturned:
    """The cell that had this task has gone silent: the progress of the task is unverified."""

    task: str
    cell: str


@dataclass(frozen=True)
class Blocked:
    """The run cannot go on by itself."""

    because: str


@dataclass(frozen=True)
class RunEnded:
    """The run ended."""

    ending: Ending
    because: str


Event = (
    RunBegun
    | PanelLoaded
    | Planned
    | PartRequested
    | FeedRefused
    | TaskBegun
    | OperationEnded
    | StopReported
    | TaskEnded
    | Interrupted
    | Settled
    | Decided
    | Asked
    | Answered
    | Escalated
    | Commanded
    | TaskElsewhere
    | TaskReturned
    | Blocked
    | RunEnded
)


_KINDS = {kind.__name__: kind for kind in get_args(Event)}


def kind_of(event: Event) -> str:
    """Return the name of an event's kind."""
    return type(event).__name__


def data_of(event: Event) -> dict[str, object]:
    """Return an event's fields as plain data, for JSON: enumerations as their values."""
    return cast("dict[str, object]", msgspec.to_builtins(event))


def event_from(kind: str, data: Mapping[str, object]) -> Event:
    """Return the event that `data_of` has turned into plain data.

    Fields with a default may be left out.

    Raises:
        OrderError: if there is no such kind, or a field is missing, unknown or of another type.
    """
    if kind not in _KINDS:
        raise OrderError(f"there is no event {kind!r}; there are {', '.join(_KINDS)}")
    try:
        event = cast("Event", msgspec.convert(data, _KINDS[kind]))
    except msgspec.ValidationError as error:
        raise OrderError(f"event {kind} is malformed: {error}") from error
    # msgspec ignores names that are no field of a dataclass.
    if unknown := list(_unknown(data, msgspec.to_builtins(event))):
        raise OrderError(f"event {kind} is malformed: unknown field {', '.join(unknown)}")
    return event


def _unknown(data: object, known: object) -> Iterator[str]:
    """Yield the names of mappings in plain data that the same data of an event does not have."""
    if isinstance(data, Mapping) and isinstance(known, Mapping):
        for name, value in data.items():
            if name in known:
                yield from _unknown(value, known[name])
            else:
                yield name
    elif isinstance(data, list) and isinstance(known, list | tuple):
        for value, same in zip(data, known, strict=True):
            yield from _unknown(value, same)
