"""What the supervisors need of the world. All calls come from the event loop's one thread."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from flexbe_synthesizer.core.chart.model import Chart
from remodel_run.progress import HandWire
from remodel_supervision.core.learning.experience import TriedResponse
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import Event
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.edge.task_leases import Claim
from remodel_supervision.edge.work_planner import WorkPlanner
from remodel_tasks.core.task_charts.planned_tasks import Demands
from remodel_tasks.core.use_case.fault import FaultTable


class Timer(Protocol):
    """A call that is repeated."""

    def cancel(self) -> None:
        """End it."""


class EventLoop(Protocol):
    """Time, and what arrives."""

    @property
    def is_leaving(self) -> bool:
        """Whether the process is to end, perhaps since another one has taken its place."""

    def now_s(self) -> float:
        """Return the ROS time [s], without jumps."""

    def wall_s(self) -> float:
        """Return the wall time [s], monotonic."""

    def run_until(
        self, holds: Callable[[], bool], limit_s: float, *, while_leaving: bool = False
    ) -> bool:
        """Process what arrives until a condition holds; return whether it does.

        Args:
            holds: the condition, checked after whatever arrives.
            limit_s: [s] wall time that it gets.
            while_leaving: go on although the process is to end.

        Raises:
            LeavingError: if the process is to end.
        """

    def every(self, period_s: float, call: Callable[[], None]) -> Timer:
        """Have something called again and again, each period of wall time [s]."""


class EndKind(Enum):
    """How a behavior ended."""

    FINISHED = "finished"
    PREEMPTED = "preempted"
    FAILED = "failed"
    LOST = "lost"


@dataclass(frozen=True)
class BehaviorEnd:
    """The end of a behavior.

    Attributes:
        text: the outcome of one that finished; otherwise why.
    """

    end: EndKind
    text: str


class Engine(Protocol):
    """The behavior engine and its action server.

    Attributes:
        state_path: of the state in which the engine is; empty if none is known.
    """

    state_path: str

    @property
    def end(self) -> BehaviorEnd | None:
        """How the behavior started last has ended; None while it runs."""

    @property
    def trouble(self) -> str:
        """Why engine or action server count as lost; empty if they do not."""

    @property
    def is_idle(self) -> bool:
        """Whether the engine has reported lately that it runs no behavior."""

    def wait(self, limit_s: float) -> None:
        """Wait until both answer, up to a limit of wall time [s]; LostError if they do not."""

    def start(self, behavior: str) -> None:
        """Have a behavior run."""

    def cancel(self, *, own_only: bool = False) -> None:
        """Have every behavior stopped, from all clients, or only the one started last here."""

    def path(self) -> tuple[str, ...]:
        """Return the paths of the states that the behavior started last has entered."""


@dataclass(frozen=True)
class Doing:
    """What an ability reports that it does.

    Attributes:
        text: for a person.
        percent: [%] 0 to 100.
        since_s: [s] ROS time of its acceptance.
    """

    ability: str
    text: str
    percent: float
    since_s: float


class Abilities(Protocol):
    """The ability servers, by what they publish.

    Attributes:
        latest: what one of them does; None if none does anything.
    """

    latest: Doing | None

    def cancel(self, owner: int | None = None) -> None:
        """Cancel every goal of every ability, or only those that an owner of the cell granted."""

    def are_quiet(self, since_s: float, owner: int | None = None) -> bool:
        """Return whether all servers that are connected have reported since then that they rest.

        Args:
            since_s: [s] wall time.
            owner: of the goals that count; None: all do.
        """

    def answers(self, ability: str, since_s: float) -> bool:
        """Return whether the server of an ability is there, and rests; see are_quiet."""

    def is_connected(self, ability: str) -> bool:
        """Return whether the server of an ability is connected, whether it answers or not."""

    def restless(self, since_s: float, owner: int | None = None) -> tuple[str, ...]:
        """Return those that keep `are_quiet` from being true, for a person."""

    def take_stops(self) -> tuple[Operation, ...]:
        """Return, once, the results after which nothing may move before a person has answered."""


def server_of(ability: str) -> str:
    """Return what the server of an ability is called, for a person."""
    return f"the server of {ability}"


class Cell(Protocol):
    """The services of the cell, below the namespace `cell`."""

    def wait(self, limit_s: float) -> None:
        """Wait for all services, up to a limit of wall time [s]; LostError if one is missing."""

    def address(self) -> str:
        """Return where the cell answers; another one after a restart. LostError if it does not."""

    def load(self, panel: object, serial: str, owner: int, *, demands: Demands, keep: bool) -> None:
        """Build a panel; RefusedError if the cell cannot, or cannot do what goals will demand."""

    def feed(self, wire: str, owner: int) -> None:
        """Present a piece of a wire; RefusedError if the feeder cannot."""

    def take_over(self, owner: int) -> bool:
        """Refuse earlier owners from now on; return whether nothing moves that they asked for.

        Only what the services were asked for counts. LostError if the cell does not answer.
        """

    def placed(self, wire: str) -> bool | None:
        """Return whether a wire is placed, by ground truth; None if there is none of it."""


class BehaviorMaker(Protocol):
    """Makes behaviors of charts."""

    def wait(self, limit_s: float) -> None:
        """Wait for the synthesizer, up to a limit of wall time [s]; LostError without it."""

    def make(self, chart: Chart) -> None:
        """Have a chart's behavior made, unless it exists; CellError if it is refused."""


class Inspection(Protocol):
    """The ability CheckConnection."""

    def wait(self, limit_s: float) -> None:
        """Wait for the ability, up to a limit of wall time [s]; LostError without it."""

    def is_connected(self, owner: int, wire: str, end: str, component: str, terminal: str) -> bool:
        """Return whether an end is in a terminal; UnseenError if that could not be seen."""


class Pictures(Protocol):
    """The pictures of a behavior."""

    def begin(self) -> None:
        """Forget those of the behavior before."""

    def keep(self, run: int, label: str) -> tuple[str, ...]:
        """Keep those of the behavior that ended, and return the names of their files."""


class Log(Protocol):
    """The record of a run."""

    def append(self, run: int, event: Event, before: RunState, owner: int) -> RunState:
        """Keep an event, and return the state after it.

        Raises:
            LostError: if the database does not answer.
            OwnerError: if another supervisor owns the run or the cell.
            RecordLostError: if the database has lost the run.
        """

    def state(self, run: int) -> RunState:
        """Return what is known of a run."""

    def take_up(self, run: int, owner: int) -> None:
        """Take up a run; OwnerError if another supervisor owns the cell now."""

    def tried_responses(self) -> Sequence[TriedResponse]:
        """Return what was done about faults in any run, and whether it helped."""


class Leases(Protocol):
    """This cell's leases on the tasks of one order.

    Attributes:
        lease_s: [s] wall time for which a task is taken or renewed.
    """

    lease_s: float

    def claim(self, task: str) -> Claim:
        """Take a task unless another cell has it, or it is done."""

    def begun_elsewhere(self) -> bool:
        """Return whether another cell has begun a task of the order: it has built the panel."""

    def give_back(self, task: str) -> None:
        """Let other cells have a task that was not begun."""

    def renew(self, task: str) -> bool:
        """Keep a task; False if another cell has taken it over."""


class UnseenError(Exception):
    """An inspection failed.

    Attributes:
        code: remodel_msgs/ErrorCode.
        goal_id: of the goal that failed; empty if it has no result.
    """

    def __init__(self, code: int, text: str, goal_id: str = "") -> None:
        """Keep the code, the reason and the goal."""
        super().__init__(text)
        self.code = code
        self.goal_id = goal_id


@dataclass(frozen=True)
class Work:
    """What a run is about, beside its events.

    Attributes:
        planner: of the order.
        faults: that there are.
        panel: that the cell builds; None if it stands there.
        leases: on the tasks.
        attended: whether there is an operator who can be asked.
        reconnect_s: [s] wall time that a process that is lost or silent gets to answer again.
        by_hand: wires of the order that no robot of the cell places.
        notify: is called with each question, and when it is not answered in time; returns at once.
    """

    planner: WorkPlanner
    faults: FaultTable
    panel: object
    leases: Leases
    attended: bool
    reconnect_s: float
    by_hand: tuple[HandWire, ...] = ()
    notify: Callable[[Mapping[str, object]], None] = lambda event: None


@dataclass(frozen=True)
class Peers:
    """The processes that a run needs."""

    cell: Cell
    maker: BehaviorMaker
    engine: Engine
    abilities: Abilities
    inspection: Inspection
    pictures: Pictures

    def wait(self, limit_s: float) -> None:
        """Wait until all answer; LostError if one does not within a limit of wall time [s]."""
        for peer in (self.cell, self.maker, self.engine, self.inspection):
            peer.wait(limit_s)
