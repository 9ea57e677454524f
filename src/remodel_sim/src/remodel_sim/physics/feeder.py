"""The feeder: lays a wire into a channel and sets the fork."""

from __future__ import annotations

import math

import numpy as np

from remodel_sim.core.cable import discretise
from remodel_sim.core.component_shape import Box
from remodel_sim.core.feeding import (
    FORK_CLEARANCE_M,
    FORK_HEIGHT_M,
    FORK_LENGTH_M,
    FORK_POST_M,
    Laying,
    plan_laying,
)
from remodel_sim.core.geometry import Pose
from remodel_sim.core.panel import Channel, Panel, Wire
from remodel_sim.physics.cable import Cable
from remodel_sim.physics.panel_scene import add_static
from remodel_sim.physics.world import World

FORK_RGB = (0.16, 0.45, 0.30)
SETTLE_S = 0.3
# Laid this far above the plate, the wire settles without a push [m].
DROP_M = 2e-4


def lay(
    world: World, panel: Panel, wire: Wire, channel: Channel, noise: np.random.Generator
) -> tuple[Cable, Laying, int]:
    """Set the fork, lay a wire and let it settle.

    Return the wire, where it lies, and the fork's body.
    """
    model = discretise(wire, world.time_step)
    laying = plan_laying(panel, wire, channel, len(model.lengths) - 1, noise)
    fork = _make_fork(world, wire, laying)
    cable = Cable(world, model, wire.colour)
    tip = np.array([*laying.tip_a, wire.radius + DROP_M])
    cable.lay(tip, laying.direction * math.pi / 2, laying.curvature)
    for _ in range(round(SETTLE_S / world.time_step)):
        world.step()
    return cable, laying, fork


def _make_fork(world: World, wire: Wire, laying: Laying) -> int:
    inner = wire.radius + FORK_CLEARANCE_M
    size = (FORK_POST_M, FORK_LENGTH_M, FORK_HEIGHT_M)
    posts = [
        Box((side * (inner + FORK_POST_M / 2), 0, FORK_HEIGHT_M / 2), size, FORK_RGB)
        for side in (-1, 1)
    ]
    pose = Pose.level(float(laying.fork[0]), float(laying.fork[1]), 0.0)
    return add_static(world.bullet, posts, pose)
