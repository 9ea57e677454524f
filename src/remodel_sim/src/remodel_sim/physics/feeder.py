"""The feeder: lays a wire into a channel and sets the fork."""

from __future__ import annotations

import math

import numpy as np

from remodel_sim.core.wires.wire_mechanics import GRAVITY, discretise
from remodel_sim.physics.wires.cable import SimulatedWire
from remodel_sim.physics.world import MASS_SCALE, World
from remodel_work.cell.feeding import Feeder, Laying, plan_laying
from remodel_work.component_shape import Box
from remodel_work.connector_shape import connector_solids
from remodel_work.edge.bullet import add_static
from remodel_work.geometry import Pose
from remodel_work.panel import Channel, Panel, PanelWire

FORK_RGB = (0.16, 0.45, 0.30)
REST_S = 0.3
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
    for _ in range(round((fall_s + REST_S) / world.time_step)):
        world.step()
    return cable, laying, fork


def _make_fork(world: World, feeder: Feeder, wire: PanelWire, laying: Laying, height: float) -> int:
    inner, post = wire.radius + feeder.fork_clearance, feeder.fork_post
    size = (post, feeder.fork_length, height)
    posts = [Box((side * (inner + post / 2), 0, height / 2), size, FORK_RGB) for side in (-1, 1)]
    pose = Pose.level(float(laying.fork[0]), float(laying.fork[1]), 0.0)
    return add_static(world.bullet, posts, pose)
