"""The wire that is being placed, with the clamps, springs and latches that hold it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from remodel_sim.core.wires.hanging_loop import HeldEnd, hanging_loop
from remodel_sim.core.wires.wire_mechanics import discretise
from remodel_sim.physics.fixtures.clamps import Holding, Latch, Socket, Springs
from remodel_sim.physics.wires.cable import SimulatedWire
from remodel_sim.physics.world import World
from remodel_work.component_shape import connector_solids
from remodel_work.geometry import Array
from remodel_work.panel import Connector, PanelWire, WireEnd
from remodel_work.routes import ParkedWire


@dataclass(eq=False)
class LiveWire:
    """The wire that is being placed."""

    wire: PanelWire
    cable: SimulatedWire
    clamps: dict[WireEnd, Holding] = field(default_factory=dict)
    latches: tuple[Latch, ...] = ()
    springs: Springs | None = None

    @property
    def fixed(self) -> frozenset[WireEnd]:
        """The ends that closed clamps hold."""
        return frozenset(end for end, clamp in self.clamps.items() if clamp.holds)

    @property
    def shape(self) -> ParkedWire:
        """The wire as it would be parked now."""
        return ParkedWire(self.cable.nodes(), self.fixed)

    def watch(
        self,
        world: World,
        headers_of: Callable[[Connector], Sequence[Socket]],
        springs: Sequence[Socket],
    ) -> None:
        """Monitor what holds an end as it enters: headers that its connectors fit into, springs."""
        self.latches = tuple(
            Latch(world, self.cable, connector, headers_of(connector), clamps=self.clamps)
            for connector in self.wire.connectors
        )
        ends = [end for end in WireEnd if self.wire.connector_at(end) is None]
        if springs and ends:
            self.springs = Springs(world, self.cable, ends, springs, self.clamps)

    def remove(self) -> None:
        """Take the wire out of the world."""
        for latch in self.latches:
            latch.remove()
        if self.springs is not None:
            self.springs.remove()
        for clamp in self.clamps.values():
            clamp.release_constraint()
        self.cable.remove()


def bent_cable(world: World, wire: PanelWire, nodes: Array) -> SimulatedWire:
    """Make a wire that was straight and has been bent into a shape, nodes (n, 3) [m]."""
    cable = _cable(world, wire)
    cable.lay_along(nodes)
    return cable


def hanging_cable(world: World, wire: PanelWire, a: HeldEnd, b: HeldEnd) -> SimulatedWire:
    """Make a wire that hangs at rest between its ends, world frame, which the caller has to hold.

    Raises ValueError when the wire is too short to reach from one end to the other.
    """
    cable = _cable(world, wire)
    cable.lay_along(hanging_loop(cable.model, a, b))
    return cable


def _cable(world: World, wire: PanelWire) -> SimulatedWire:
    connectors = {c.end: connector_solids(wire, c) for c in wire.connectors}
    return SimulatedWire(world, discretise(wire, world.time_step), wire.colour, connectors)
