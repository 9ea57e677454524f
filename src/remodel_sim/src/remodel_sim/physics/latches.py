"""The latches of headers: one snaps when a connector is pressed home, and then holds it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from remodel_sim.core.geometry import Array, Pose, rotation_matrix
from remodel_sim.core.panel import Connector, End, Terminal
from remodel_sim.physics.cable import Cable
from remodel_sim.physics.clamps import Clamp
from remodel_sim.physics.world import World

# Pins that are in up to so little have their connector's body at the header's face [m].
HOME_M = 0.0005
# A connector that has come out so far is no longer held [m].
HOOK_M = 0.0015


@dataclass(frozen=True, eq=False)
class Header:
    """A header in the world.

    Attributes:
        terminal: as drawn.
        housing: the body of its component.
        world_from_socket: tells where its face is now.
    """

    terminal: Terminal
    housing: int
    world_from_socket: Callable[[], Pose]


class Latch:
    """What a connector of the live wire meets in the headers that it fits into."""

    def __init__(
        self,
        world: World,
        cable: Cable,
        connector: Connector,
        headers: Sequence[Header],
        clamps: dict[End, Clamp],
    ) -> None:
        """Watch for the connector; a latch that snaps is added to the `clamps`."""
        self._world = world
        self._cable = cable
        self._connector = connector
        self._headers = headers
        self._clamps = clamps
        self._is_ready = True
        world.add_before_step(self._snap)

    def hold(self) -> None:
        """Close on a connector that is home already, without a push: it latched before."""
        for header in self._headers:
            socket = header.world_from_socket()
            if self._is_home(header, socket, self._tip()):
                self._close(header, socket)
        self._is_ready = False

    def remove(self) -> None:
        """Watch no more; what has latched stays so."""
        self._world.remove_before_step(self._snap)

    def _snap(self) -> None:
        held = self._clamps.get(self._connector.end)
        if held is not None and held.holds:
            self._is_ready = False
            return
        tip = self._tip()
        at = [(header, header.world_from_socket()) for header in self._headers]
        home = [(header, socket) for header, socket in at if self._is_home(header, socket, tip)]
        # A latch that is held open lets the connector out before it can snap again.
        self._is_ready |= not home
        for header, socket in home:
            if self._is_ready and self._is_pressed(header, socket):
                self._close(header, socket)

    def _close(self, header: Header, socket: Pose) -> None:
        self._clamps[self._connector.end] = Clamp(
            self._world,
            self._cable,
            self._cable.ferrule(self._connector.end),
            header.housing,
            socket @ Pose.level(self._connector.pin_length - HOOK_M, 0.0, 0.0),
            header.terminal.retention_force,
        )

    def _tip(self) -> Array:
        end, model = self._connector.end, self._cable.model
        centre, quaternion = self._cable.link_pose(self._cable.ferrule(end))
        reach = model.lengths[0 if end is End.A else -1] / 2 + model.radius
        return centre + (-reach if end is End.A else reach) * rotation_matrix(quaternion)[:, 2]

    def _is_home(self, header: Header, socket: Pose, tip: Array) -> bool:
        depth, *aside = socket.inverse().apply(tip)
        within = bool(np.abs(aside).max() < header.terminal.bore / 2)
        return within and depth > self._connector.pin_length - HOME_M

    def _is_pressed(self, header: Header, socket: Pose) -> bool:
        """Return whether the connector presses on the housing with its mating force."""
        body, link = self._cable.ferrule(self._connector.end)
        contacts = self._world.bullet.getContactPoints(header.housing, body, -1, link)
        into = socket.rotation[:, 0]
        # A contact has the normal from the connector to the housing, and the force along it.
        pressed = sum(contact[9] * float(np.dot(contact[7], into)) for contact in contacts)
        return pressed >= self._connector.mating_force
