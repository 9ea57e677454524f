"""The simulated services of a cell: panel and feeder."""

from __future__ import annotations

from collections.abc import Callable

from remodel_msgs.msg import ErrorCode

from remodel_states.core.ability_error import AbilityError
from remodel_states.serving import admitted
from remodel_states.testing.world import World
from schedules.node import Node
from schedules.simulation import Simulation
from schedules.site import Motion, Site

# [s] that building a panel, and presenting a piece, takes.
_TAKES_S = (0.2, 1.5)

Reply = Callable[[AbilityError | None], None]


class CellServices(Node):
    """The process that loads panels and feeds wires."""

    def __init__(self, simulation: Simulation, site: Site, station: str, cell: str) -> None:
        super().__init__(simulation, f"{station}/cell")
        self._site = site
        self._station = station
        self._cell = cell
        self._motion: Motion | None = None

    @property
    def world(self) -> World:
        return self._site.world

    def on_load(self, serial: str, owner: int, keep: bool, reply: Reply) -> None:
        try:
            self._site.admit(self._cell, owner)
        except AbilityError as error:
            reply(error)
            return
        self._site.load(self._cell, serial, keep=keep)
        self.deliver(self.simulation.random.uniform(*_TAKES_S), reply, None)

    def on_feed(self, wire: str, owner: int, reply: Reply) -> None:
        site = self._site
        if not self._admit(owner, reply):
            return
        self._motion = motion = Motion(
            self._station,
            self._cell,
            owner,
            f"feed {wire}",
            wire=wire,
            begun_s=self.simulation.now_s,
        )
        site.locks[self._cell] = motion
        site.begin(motion)
        takes_s = self.simulation.random.uniform(*_TAKES_S)
        effect_s = self.simulation.random.uniform(0.0, takes_s)

        def take_effect() -> None:
            try:
                admitted(site.owners, self._cell, owner)
                site.feed(self._cell, wire)
            except AbilityError as error:
                self._release()
                reply(error)
                return
            self.deliver(takes_s - effect_s, end)

        def end() -> None:
            self._release()
            reply(None)

        self.deliver(effect_s, take_effect)

    def on_take_over(self, owner: int, reply: Reply) -> None:
        if self._admit(owner, reply):
            reply(None)

    def _admit(self, owner: int, reply: Reply) -> bool:
        """Return whether a supervisor may have something done; reply if not."""
        try:
            self._site.admit(self._cell, owner)
        except AbilityError as error:
            reply(error)
            return False
        if self._site.locks.get(self._cell) is None:
            return True
        reply(AbilityError(ErrorCode.BUSY, "the robot is doing a goal"))
        return False

    def _release(self) -> None:
        if self._motion is not None:
            self._site.locks[self._cell] = None
            self._site.end(self._motion)
            self._motion = None

    def died(self) -> None:
        """Stop, and free the robot."""
        self._release()
