"""What goes wrong in a schedule, drawn by its seed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from random import Random

from remodel_states.testing.cell_services import FaultTable
from remodel_states.testing.faults import Cure
from remodel_supervision.core.runs.events import Command
from schedules.database import Memory
from schedules.node import Node
from schedules.people import People
from schedules.process import Ambush
from schedules.simulation import Simulation
from schedules.site import Site
from schedules.station import Station

# [s] after which nothing goes wrong any more, for each task of the order.
CALM_AFTER_S = 25.0

_STALLS_S = (0.5, 2.0, 5.0, 10.0, 45.0)

# [s] that a process takes to be restarted; a long time now and then.
_RESTARTS_S = (0.5, 1.0, 2.0, 3.0, 25.0)

Act = Callable[[], None]


class Disturbances:
    """Draws them, and has them happen."""

    def __init__(
        self,
        simulation: Simulation,
        site: Site,
        memory: Memory,
        stations: Sequence[Station],
        people: People,
    ) -> None:
        self._simulation = simulation
        self._site = site
        self._memory = memory
        self._stations = stations
        self._people = people

    def draw(self, count: int, calm_s: float) -> None:
        """Have some things go wrong before a time [s]."""
        kinds = (
            *(self._kill_supervisor,) * 5,
            *(self._stall_supervisor,) * 3,
            *(self._terminate,) * 2,
            self._lose_use_case,
            self._replace_supervisor,
            *(self._kill_node,) * 5,
            *(self._stall_node,) * 5,
            *(self._fail_database,) * 3,
            *(self._lose_commits,) * 2,
            *(self._slow_down,) * 2,
            self._repeat_requests,
            *(self._pause,) * 4,
            *(self._stop,) * 2,
            *(self._skip,) * 3,
            self._retry,
            *(self._cause_fault,) * 6,
            self._repeat_goal,
        )
        random = self._simulation.random
        for _ in range(count):
            kind, at_s = random.choice(kinds), random.uniform(0.5, calm_s)
            self._simulation.at(at_s, kind, random.choice(self._stations), random)
            if random.random() < 0.3:
                soon_s = min(calm_s, at_s + random.uniform(0.0, 5.0))
                self._simulation.at(
                    soon_s, random.choice(kinds), random.choice(self._stations), random
                )

    # --- processes

    def _kill_supervisor(self, station: Station, random: Random) -> None:
        if station.process is not None:
            station.process.ambush = Ambush(random.randint(1, 25), None)

    def _stall_supervisor(self, station: Station, random: Random) -> None:
        if station.process is not None:
            stall_s = random.choice((*_STALLS_S, 60.0))
            station.process.ambush = Ambush(random.randint(1, 25), stall_s)

    def _terminate(self, station: Station, random: Random) -> None:
        if station.process is not None:
            station.process.leave()

    def _replace_supervisor(self, station: Station, random: Random) -> None:
        station.replace_supervisor(random.choice((0.5, 2.0, 5.0, 10.0)))

    def _lose_use_case(self, station: Station, random: Random) -> None:
        for_s = random.choice((3.0, 20.0))
        self._simulation.note(station.name, "cannot read its use case for {:g} s", for_s)
        station.unmade_until_s = self._simulation.now_s + for_s
        self._kill_supervisor(station, random)

    def _kill_node(self, station: Station, random: Random) -> None:
        _drawn(station, random).kill(random.choice(_RESTARTS_S))

    def _stall_node(self, station: Station, random: Random) -> None:
        _drawn(station, random).stall(random.choice(_STALLS_S))

    # --- database and messages

    def _fail_database(self, station: Station, random: Random) -> None:
        for_s = random.choice((0.2, 1.0, 5.0, 15.0, 40.0))
        self._simulation.note("database", "does not answer for {:g} s", for_s)
        self._memory.outage_until_s = self._simulation.now_s + for_s

    def _lose_commits(self, station: Station, random: Random) -> None:
        self._memory.lost_answers = random.randint(1, 3)

    def _slow_down(self, station: Station, random: Random) -> None:
        simulation = self._simulation
        simulation.slow_until_s = simulation.now_s + random.uniform(1.0, 15.0)
        simulation.slow_s = random.choice((0.05, 0.3, 1.0))
        simulation.note("network", "slow: {:g} s", simulation.slow_s)

    def _repeat_requests(self, station: Station, random: Random) -> None:
        self._simulation.duplicates = random.choice((0.1, 0.5))

    # --- people

    def _pause(self, station: Station, random: Random) -> None:
        command = random.choice((Command.PAUSE, Command.PAUSE, Command.PROTECTIVE_STOP))
        self._people.pause(station, command, random.choice((0.5, 3.0, 10.0, 60.0)))

    def _stop(self, station: Station, random: Random) -> None:
        self._people.command(station, Command.STOP)

    def _skip(self, station: Station, random: Random) -> None:
        supervisor = station.supervisor
        if supervisor is not None:
            tasks = [supervisor.state.current, *supervisor.state.tasks]
            self._people.command(station, Command.SKIP, random.choice([t for t in tasks if t]))

    def _retry(self, station: Station, random: Random) -> None:
        supervisor = station.supervisor
        if supervisor is not None:
            name = random.choice(list(supervisor.state.tasks))
            self._people.command(station, Command.RETRY, name)

    def _repeat_goal(self, station: Station, random: Random) -> None:
        self._people.send_goal(station)

    # --- the cell

    def _cause_fault(self, station: Station, random: Random) -> None:
        table, names = _table()
        cure = random.choice(("", "", *(each.value for each in Cure)))
        given = {"nth": random.randint(1, 3)}
        try:
            fault = table.fault(random.choice(names), cure, **given)
        except ValueError:  # retry_with, of a fault that no parameter helps against
            return
        self._simulation.note("fault", "{}", fault)
        self._site.faults = (*self._site.faults, fault)


def _drawn(station: Station, random: Random) -> Node:
    """Return a process; often the engine, or a server that is at work."""
    busy = [node for node in station.servers.values() if node.is_busy]
    choices = [station.engine, *busy * 2, random.choice(station.nodes)]
    return random.choice(choices)


@cache
def _table() -> tuple[FaultTable, tuple[str, ...]]:
    from schedules.planner import plant

    unusable = {"plan_not_executable", "cell_contested"}
    return FaultTable(), tuple(n for n in plant().faults.names if n not in unusable)
