"""The feeder: lays a wire into a channel and sets the fork."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from remodel_sim.core.cell.feeding import Feeder, Laying, plan_laying
from remodel_sim.core.geometry import Array, Pose
from remodel_sim.core.workpiece.component_shape import Box
from remodel_sim.core.workpiece.connector_shape import connector_solids
from remodel_sim.core.workpiece.panel import Channel, Panel, PanelWire
from remodel_sim.core.workpiece.wire_mechanics import discretise
from remodel_sim.physics.static_body import add_static
from remodel_sim.physics.wires.cable import SimulatedWire
from remodel_sim.physics.world import World

FORK_RGB = (0.16, 0.45, 0.30)
REST_S = 0.3
# A wire is at rest when no node moves faster than this [m/s]; it is waited for so long [s].
REST_M_S = 0.002
CHECK_S = 0.1
WAIT_LIMIT_S = 3.0
# Laid this far above what lies in the channel, the wire comes to rest without a push [m].
DROP_M = 2e-4
# What is parked so near to the line counts; and the thickest wire's radius, for the wires below.
BESIDE_M = 0.010
MAX_RADIUS_M = 0.0031
POINTS_PER_LINK = 10


def lay(
    world: World,
    feeder: Feeder,
    panel: Panel,
    wire: PanelWire,
    channel: Channel,
    parked: Iterable[Array],
    noise: np.random.Generator,
) -> tuple[SimulatedWire, Laying, int]:
    """Set the fork, lay a wire onto what is parked, nodes (n, 3) [m], and let it come to rest.

    Return the wire, where it lies, and the fork's body.
    """
    model = discretise(wire, world.time_step)
    laying = plan_laying(feeder, panel, wire, channel, joints=len(model.lengths) - 1, noise=noise)
    fork = _make_fork(world, feeder, wire, laying)
    connectors = {c.end: connector_solids(wire, c) for c in wire.connectors}
    cable = SimulatedWire(world, model, wire.colour, connectors)
    yaw = laying.direction * math.pi / 2
    cable.lay(np.array([*laying.tip_a, 0.0]), yaw, laying.curvature)
    height = _free_height(cable.nodes(), wire, parked)
    cable.lay(np.array([*laying.tip_a, height + DROP_M]), yaw, laying.curvature)
    for _ in range(round(REST_S / world.time_step)):
        world.step()
    if height > wire.radius:
        _come_to_rest(world, cable)
    return cable, laying, fork


def _free_height(line: Array, wire: PanelWire, parked: Iterable[Array]) -> float:
    """Return the height at which a level wire along a line touches nothing, (n, 3) [m]."""
    height = wire.radius
    for nodes in parked:
        points = _dense(nodes)
        away = np.linalg.norm(points[:, None, :2] - _dense(line)[None, :, :2], axis=2).min(axis=1)
        near = points[away < BESIDE_M]
        if len(near):
            height = max(height, float(near[:, 2].max()) + 2 * wire.radius + MAX_RADIUS_M)
    return height


def _dense(nodes: Array) -> Array:
    """Return points between nodes (n, 3), less than a wire's thickness apart."""
    shares = np.linspace(0.0, 1.0, POINTS_PER_LINK, endpoint=False)[None, :, None]
    return (nodes[:-1, None] + shares * np.diff(nodes, axis=0)[:, None]).reshape(-1, 3)


def _come_to_rest(world: World, cable: SimulatedWire) -> None:
    """Step until a wire that fell from a height is at rest."""
    before = cable.nodes()
    for _ in range(math.ceil(WAIT_LIMIT_S / CHECK_S)):
        for _ in range(round(CHECK_S / world.time_step)):
            world.step()
        now = cable.nodes()
        if float(np.abs(now - before).max()) < REST_M_S * CHECK_S:
            return
        before = now


def _make_fork(world: World, feeder: Feeder, wire: PanelWire, laying: Laying) -> int:
    inner = wire.radius + feeder.fork_clearance
    post, height = feeder.fork_post, feeder.fork_height
    size = (post, feeder.fork_length, height)
    posts = [Box((side * (inner + post / 2), 0, height / 2), size, FORK_RGB) for side in (-1, 1)]
    pose = Pose.level(float(laying.fork[0]), float(laying.fork[1]), 0.0)
    return add_static(world.bullet, posts, pose)
