"""The wire that is being placed: how feeder and magazine present it, and what holds its ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from remodel_sim.core.wire_mechanics import GRAVITY, HeldEnd, discretise, hanging_loop
from remodel_sim.physics.fixtures.clamps import Holding, Latch, Socket, Springs
from remodel_sim.physics.fixtures.panel_scene import add_clip
from remodel_sim.physics.wires.cable import SimulatedWire
from remodel_sim.physics.world import MASS_SCALE, World
from remodel_work.cell.presenting import (
    Feeder,
    Laying,
    Magazine,
    Presentation,
    disturbed,
    fork_clips,
    held_length,
    plan_laying,
    plan_presentation,
    stop_box,
)
from remodel_work.component_shape import Box, connector_solids
from remodel_work.edge.bullet import add_static
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Channel, Connector, Panel, PanelWire, WireEnd
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


FORK_RGB = (0.16, 0.45, 0.30)
LAID_REST_S = 0.3
# Laid this far above the plate, the wire comes to rest without a push [m].
DROP_M = 2e-4


def lay(
    world: World,
    feeder: Feeder,
    panel: Panel,
    wire: PanelWire,
    channel: Channel,
    above: float,
    noise: np.random.Generator,
) -> tuple[SimulatedWire, Laying, int]:
    """Set the fork, lay a wire and let it come to rest; return it, where it lies, and the fork.

    It is let down from `above` the wires that lie in the channel [m], between posts that are as
    much higher.
    """
    model = discretise(wire, world.time_step)
    laying = plan_laying(feeder, panel, wire, channel, joints=len(model.lengths) - 1, noise=noise)
    fork = _make_fork(world, feeder, wire, laying, feeder.fork_height + above)
    connectors = {c.end: connector_solids(wire, c) for c in wire.connectors}
    cable = SimulatedWire(world, model, wire.colour, connectors)
    yaw = laying.direction * math.pi / 2
    cable.lay(np.array([*laying.tip_a, above + wire.radius + DROP_M]), yaw, laying.curvature)
    fall_s = math.sqrt(2 * above * MASS_SCALE / GRAVITY)
    _rest(world, fall_s + LAID_REST_S)
    return cable, laying, fork


def _make_fork(world: World, feeder: Feeder, wire: PanelWire, laying: Laying, height: float) -> int:
    inner, post = wire.radius + feeder.fork_clearance, feeder.fork_post
    size = (post, feeder.fork_length, height)
    posts = [Box((side * (inner + post / 2), 0, height / 2), size, FORK_RGB) for side in (-1, 1)]
    pose = Pose.level(float(laying.fork[0]), float(laying.fork[1]), 0.0)
    return add_static(world.bullet, posts, pose)


# The ends are held until the loop has come to rest in the clips, with this force.
SETTLING_S = 0.5
HOLDING_N = 20.0
# Then they come to rest themselves.
HUNG_REST_S = 0.5


def present(
    world: World, magazine: Magazine, panel: Panel, wire: PanelWire, noise: np.random.Generator
) -> tuple[SimulatedWire, Presentation, dict[WireEnd, tuple[int, ...]]]:
    """Put a wire into the magazine's clips.

    Returns:
        The wire, where its ends should be, and the clips that hold each end.
    """
    presentation = plan_presentation(magazine, panel, wire)
    tips = disturbed(presentation.tips, noise, is_short=magazine.is_short(wire.length))
    clips: dict[WireEnd, tuple[int, ...]] = {}
    for end, tip in tips.items():
        clips[end] = tuple(add_clip(world, clip, pose) for clip, pose in fork_clips(wire, tip))
        add_static(world.bullet, [stop_box(wire)], tip)
    a, b = (HeldEnd(tips[end].position, tips[end].rotation[:, 0], held_length()) for end in WireEnd)
    cable = hanging_cable(world, wire, a, b)
    holders = [_hold(world, cable, end) for end in WireEnd]
    _rest(world, SETTLING_S)
    for holder in holders:
        world.bullet.removeConstraint(holder)
    _rest(world, HUNG_REST_S)
    return cable, presentation, clips


def _hold(world: World, cable: SimulatedWire, end: WireEnd) -> int:
    """Hold an end where it is; return the constraint."""
    link = cable.ferrule(end)
    position, quaternion = cable.link_pose(link)
    constraint = world.bullet.createConstraint(
        *link,
        childBodyUniqueId=-1,
        childLinkIndex=-1,
        jointType=world.bullet.JOINT_FIXED,
        jointAxis=[0, 0, 0],
        parentFramePosition=[0, 0, 0],
        childFramePosition=position.tolist(),
        parentFrameOrientation=[0, 0, 0, 1],
        childFrameOrientation=quaternion.tolist(),
    )
    world.bullet.changeConstraint(constraint, maxForce=HOLDING_N)
    return int(constraint)


def _rest(world: World, seconds: float) -> None:
    for _ in range(round(seconds / world.time_step)):
        world.step()
