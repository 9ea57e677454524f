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


class Feeder:
    """Lays one wire at a time."""

    def __init__(self, world: World) -> None:
        """Start without a fork."""
        self._world = world
        self._fork: int | None = None

    def lay(
        self, panel: Panel, wire: Wire, channel: Channel, noise: np.random.Generator
    ) -> tuple[Cable, Laying]:
        """Lay a wire and let it settle."""
        model = discretise(wire, self._world.time_step)
        laying = plan_laying(panel, wire, channel, len(model.lengths) - 1, noise)
        self._set_fork(wire, laying)
        cable = Cable(self._world, model, wire.colour)
        tip = np.array([*laying.tip_a, wire.radius + DROP_M])
        cable.lay(tip, laying.direction * math.pi / 2, laying.curvature)
        for _ in range(round(SETTLE_S / self._world.time_step)):
            self._world.step()
        return cable, laying

    def _set_fork(self, wire: Wire, laying: Laying) -> None:
        self.withdraw()
        inner = wire.radius + FORK_CLEARANCE_M
        size = (FORK_POST_M, FORK_LENGTH_M, FORK_HEIGHT_M)
        posts = [
            Box((side * (inner + FORK_POST_M / 2), 0, FORK_HEIGHT_M / 2), size, FORK_RGB)
            for side in (-1, 1)
        ]
        pose = Pose.level(float(laying.fork[0]), float(laying.fork[1]), 0.0)
        self._fork = add_static(self._world.bullet, posts, pose)

    def withdraw(self) -> None:
        """Take the fork away."""
        if self._fork is not None:
            self._world.bullet.removeBody(self._fork)
            self._fork = None
