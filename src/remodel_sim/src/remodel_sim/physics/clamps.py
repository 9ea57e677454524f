"""The terminals' clamps: jaws that press on what lies in the bore, and hold it up to a force."""

from __future__ import annotations

import numpy as np

from remodel_sim.core.component_shape import BLACK, Box
from remodel_sim.core.geometry import Pose
from remodel_sim.core.panel import Terminal
from remodel_sim.physics.cable import Cable, Link
from remodel_sim.physics.static_body import add_static
from remodel_sim.physics.world import World

# The jaw comes down on the last millimetres of the bore.
JAW_BEFORE_BOTTOM_M = 0.0035
JAW_LENGTH_M = 0.003
JAW_HEIGHT_M = 0.002
JAW_STEP_M = 0.0001
TOUCH_M = 5e-5
# The constraint follows a slipping end at this distance, where it holds with its full force.
SLIP_LAG_M = 5e-4
# A tip this far from the axis is in another bore.
BESIDE_M = 0.005


class Clamp:
    """A clamp closed on a link of the wire: a constraint that slips above the retention force.

    It stands for the jaw and for the floor under the link: while it is closed, the link does not
    touch the housing otherwise. Else two stiff things would fight over where the link is, and the
    solver would let it creep out.
    """

    def __init__(
        self, world: World, cable: Cable, link: Link, housing: int, zone: Pose, force: float
    ) -> None:
        """Hold a link where it is; `zone` is the jaw's place in the bore, world frame."""
        self._world = world
        self._bullet = world.bullet
        self._cable = cable
        self._link = link
        self._housing = housing
        self._zone = zone
        self._force = force
        position, quaternion = cable.link_pose(link)
        self._anchor = position
        self._constraint: int | None = self._bullet.createConstraint(
            *link,
            -1,
            -1,
            self._bullet.JOINT_FIXED,
            [0, 0, 0],
            [0, 0, 0],
            position.tolist(),
            [0, 0, 0, 1],
            quaternion.tolist(),
        )
        self._bullet.changeConstraint(self._constraint, maxForce=force)
        self._touch_housing(False)
        world.add_before_step(self._follow)
        self.holds = True

    def _follow(self) -> None:
        position, quaternion = self._cable.link_pose(self._link)
        away = position - self._anchor
        distance = float(np.linalg.norm(away))
        if distance <= 2 * SLIP_LAG_M:
            return
        if not self._under_jaw():
            self.open()
            return
        self._anchor = position - away / distance * SLIP_LAG_M
        self._bullet.changeConstraint(
            self._constraint, self._anchor.tolist(), quaternion.tolist(), maxForce=self._force
        )

    def _touch_housing(self, touch: bool) -> None:
        body, index = self._link
        self._bullet.setCollisionFilterPair(self._housing, body, -1, index, int(touch))

    def _under_jaw(self) -> bool:
        tips = self._zone.inverse().apply(self._cable.nodes()[[0, -1]])
        return bool(np.any((tips[:, 0] > 0) & (np.abs(tips[:, 1]) < BESIDE_M)))

    def open(self) -> None:
        """Let go."""
        self.holds = False
        self.release_constraint()

    def release_constraint(self) -> None:
        """Take the constraint away, as when the wire becomes a picture.

        The clamp stays as it is.
        """
        if self._constraint is not None:
            self._bullet.removeConstraint(self._constraint)
            self._touch_housing(True)
            self._world.remove_before_step(self._follow)
            self._constraint = None


def close_clamp(
    world: World, cable: Cable, terminal: Terminal, housing: int, world_from_socket: Pose
) -> Clamp | None:
    """Bring a terminal's jaw down; return the clamp, or None when it met nothing.

    `housing` is the body of the terminal's component.

    The jaw moves from the top of the bore to its bottom and stops at the first touch, as a screw
    does.
    """
    bullet = world.bullet
    depth = terminal.depth - JAW_BEFORE_BOTTOM_M
    size = (JAW_LENGTH_M, 0.8 * terminal.bore, JAW_HEIGHT_M)
    jaw = add_static(bullet, [Box((0, 0, 0), size, BLACK)], Pose.level(0, 0, -1.0))
    bullet.setCollisionFilterGroupMask(jaw, -1, 0, 0)
    link = None
    for travel in np.arange(0.0, terminal.bore, JAW_STEP_M):
        height = terminal.bore / 2 + JAW_HEIGHT_M / 2 - travel
        pose = world_from_socket @ Pose.level(depth, 0.0, height)
        bullet.resetBasePositionAndOrientation(
            jaw, pose.position.tolist(), pose.quaternion.tolist()
        )
        near = [p for body in cable.bodies for p in bullet.getClosestPoints(jaw, body, TOUCH_M)]
        if near:
            nearest = min(near, key=lambda point: point[8])
            link = (nearest[2], nearest[4])
            break
    bullet.removeBody(jaw)
    if link is None:
        return None
    zone = world_from_socket @ Pose.level(depth - JAW_LENGTH_M / 2, 0.0, 0.0)
    return Clamp(world, cable, link, housing, zone, terminal.retention_force)
