"""A station: a cell's robot with its servers, and the lives of its supervisor."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING

from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import Answered, Command, Commanded
from remodel_supervision.core.runs.gate import Permit
from remodel_supervision.supervisors.use_case_supervisor import UseCaseSupervisor
from schedules.cell_services import CellServices
from schedules.database import Memory
from schedules.engine import Engine
from schedules.life import Life, Setting
from schedules.node import Node
from schedules.process import Process
from schedules.server import Server
from schedules.simulation import Simulation
from schedules.site import Site

if TYPE_CHECKING:
    from schedules.invariants import Invariants

# [s] until a process that ended is respawned.
_RESPAWN_S = (0.5, 3.0)

_USED = (
    "CheckConnection",
    "DetectCable",
    "DiscardCable",
    "FixCable",
    "InsertCable",
    "LocateGearboxComponent",
    "PickCable",
    "PlaceCable",
)

Reply = Callable[[bool, str], None]


class Station:
    """One robot with its processes.

    Attributes:
        cell: name of its cell; two stations may have the same by mistake.
        life: of the supervisor's process that runs; None before the first.
        unmade_until_s: [s] until when no run can be resumed, since its use case cannot be read.
        stopped_by: persons who have stopped the cell, as the parameter server keeps them.
    """

    def __init__(
        self,
        simulation: Simulation,
        site: Site,
        memory: Memory,
        setting: Setting,
        invariants: Invariants,
        name: str,
        cell: str,
    ) -> None:
        self.simulation = simulation
        self.site = site
        self.memory = memory
        self.setting = setting
        self.invariants = invariants
        self.name = name
        self.cell = cell
        self.servers = {
            ability: Server(simulation, site, name, cell, ability=ability) for ability in _USED
        }
        self.services = CellServices(simulation, site, name, cell)
        self.synthesizer = Node(simulation, f"{name}/synthesizer")
        self.engine = Engine(simulation, name, self.servers, self)
        self.life: Life | None = None
        self.unmade_until_s = 0.0
        self.stopped_by: tuple[str, ...] = ()
        self._lives = 0
        self._start()

    @property
    def nodes(self) -> tuple[Node, ...]:
        """All processes but the supervisor's."""
        return (*self.servers.values(), self.services, self.synthesizer, self.engine)

    @property
    def process(self) -> Process | None:
        """The supervisor's process; None while there is none."""
        return self.life.process if self.life and not self.life.process.is_dead else None

    @property
    def supervisor(self) -> UseCaseSupervisor | None:
        return self.life.active if self.life and self.process else None

    def _start(self) -> None:
        self._lives += 1
        number = self._lives
        Process(
            self.simulation,
            f"{self.name}/sup{number}",
            self._main,
            lambda: self._on_end(number),
        )

    def keep_stops(self, persons: Collection[str]) -> None:
        """Keep who has stopped the cell, beyond the life of its supervisor."""
        self.stopped_by = tuple(persons)

    def _main(self, process: Process) -> None:
        self.life = Life(self, process)
        self.life.serve()

    def replace_supervisor(self, stall_s: float) -> None:
        """Start another supervisor while this one stalls, which is to end when it wakes up.

        So it is with a second node of one name, which the ROS master has the first one end for.
        """
        if self.process is not None:
            self.process.stall(stall_s)
            self.process.leave()
            self._start()

    def _on_end(self, number: int) -> None:
        if number != self._lives:
            return  # another one has taken its place
        self.simulation.after(self.simulation.random.uniform(*_RESPAWN_S), self._start)

    # --- what states and people ask

    def begin_operation(
        self,
        behavior: str,
        path: str,
        ability: str,
        answer: Callable[[tuple[Permit, int] | None], None],
    ) -> None:
        """See engine.Supervision."""

        def begin(life: Life) -> tuple[Permit, int]:
            if life.active is None:
                return (Permit.HELD if life.closed else Permit.REFUSED), 0
            permit, _ = life.active.tasks.begin_operation(behavior, path, ability)
            self.simulation.note(life.process.name, "{} {}{}", permit.value, behavior, path)
            return permit, life.active.owner

        self._request(begin, answer)

    def keep_record(
        self, behavior: str, operation: Operation, answer: Callable[[bool | None], None]
    ) -> None:
        """See engine.Supervision."""

        def keep(life: Life) -> bool:
            if life.active is None:
                return not life.closed
            return life.active.tasks.keep_record(behavior, operation)[0]

        self._request(keep, answer)

    def on_engine_death(self) -> None:
        """See engine.Supervision."""
        self.invariants.on_engine_death(self)

    def send_goal(
        self, count: int, answer: Callable[[str | None], None], *, again: bool = False
    ) -> None:
        """Ask for the order; the answer is why not, empty if it is done."""
        self._request(lambda life: life.take_goal(count, again=again), answer)

    def _request(self, call: Callable[[Life], object], answer: Callable[..., None]) -> None:
        latency_s = self.simulation.latency_s()
        self.simulation.after(latency_s, self._arrive, call, answer)

    def _arrive(self, call: Callable[[Life], object], answer: Callable[..., None]) -> None:
        life = self.life
        if life is None or self.process is None:
            self.simulation.after(self.simulation.latency_s(), answer, None)
            return
        life.process.request(lambda: call(life), answer)

    def command(self, event: Commanded, answer: Callable[[bool], None]) -> None:
        self.simulation.note("people", "{} {} at {}", event.command.value, event.task, self.name)
        if event.command is Command.PROTECTIVE_STOP and self.process is not None:
            for server in self.servers.values():
                server.deliver(self.simulation.latency_s(), server.on_cancel)
        self._ask(lambda life, reply: life.command(event, reply), answer)

    def answer(self, event: Answered, answer: Callable[[bool], None]) -> None:
        self.simulation.note("people", "answer {} at {}", event.choice.value, self.name)
        self._ask(lambda life, reply: life.answer(event, reply), answer)

    def _ask(self, call: Callable[[Life, Reply], None], answer: Callable[[bool], None]) -> None:
        def on_answer(reply: tuple[bool, str] | None) -> None:
            self.simulation.note("people", "hear from {}: {}", self.name, reply)
            answer(reply is not None and reply[0])

        def arrive() -> None:
            life = self.life
            if life is None or self.process is None:
                on_answer(None)
            else:
                life.process.ask(lambda reply: call(life, reply), on_answer)

        self.simulation.after(self.simulation.latency_s(), arrive)
