"""A wire in the world: one floating multibody with spherical joints, driven by elastic torques."""

from __future__ import annotations

import math

import numpy as np

from remodel_sim.core.cable import CableModel, rotation_vectors
from remodel_sim.core.geometry import Array, rotation_matrix
from remodel_sim.core.panel import End
from remodel_sim.core.wire_colours import FERRULE_RGB, GREEN_AND_YELLOW, WIRE_RGB
from remodel_sim.physics.world import MASS_SCALE, World

# Light drag instead of the internal friction of strands [1/s].
DRAG = 3.0
FRICTION = 0.5
# Bullet draws a capsule by its collision hull, which is thicker by this margin.
HULL_MARGIN_M = 0.001
IDENTITY = [0.0, 0.0, 0.0, 1.0]


class Cable:
    """The live wire. Link -1 is the ferrule of end a, the last link that of end b."""

    def __init__(self, world: World, model: CableModel, colour: str) -> None:
        """Make the wire, straight along x, its tip a at the origin; see `lay`."""
        self._world = world
        self._bullet = world.bullet
        self.model = model
        n = len(model.lengths)
        self._joints = list(range(n - 1))
        self.colours = link_colours(colour, n)
        masses = list(model.masses * MASS_SCALE)
        shapes = [self._shapes(i) for i in range(n)]
        half = [[0, 0, length / 2] for length in model.lengths]
        steps = [half[0]] + [[0, 0, length] for length in model.lengths[1:-1]]
        self.body = self._bullet.createMultiBody(
            masses[0],
            shapes[0][0],
            shapes[0][1],
            [0, 0, 0],
            IDENTITY,
            linkMasses=masses[1:],
            linkCollisionShapeIndices=[s[0] for s in shapes[1:]],
            linkVisualShapeIndices=[s[1] for s in shapes[1:]],
            linkPositions=steps,
            linkOrientations=[IDENTITY] * (n - 1),
            linkInertialFramePositions=half[1:],
            linkInertialFrameOrientations=[IDENTITY] * (n - 1),
            linkParentIndices=self._joints,
            linkJointTypes=[self._bullet.JOINT_SPHERICAL] * (n - 1),
            linkJointAxis=[[0, 0, 1]] * (n - 1),
            flags=self._bullet.URDF_USE_SELF_COLLISION
            | self._bullet.URDF_USE_SELF_COLLISION_EXCLUDE_PARENT,
        )
        self._set_dynamics()
        self._rest = np.zeros((n - 1, 3))
        world.add_before_step(self._bend)

    def _shapes(self, i: int) -> tuple[int, int]:
        # Shapes sit in the link's own frame, which is at its first joint; the base's frame is its
        # centre.
        length, radius = self.model.lengths[i], self.model.radius
        offset = [0, 0, 0] if i == 0 else [0, 0, length / 2]
        capsule = self._bullet.GEOM_CAPSULE
        return (
            self._bullet.createCollisionShape(
                capsule, radius=radius, height=length, collisionFramePosition=offset
            ),
            self._bullet.createVisualShape(
                capsule,
                radius=radius - HULL_MARGIN_M,
                length=length,
                rgbaColor=[*self.colours[i], 1],
                visualFramePosition=offset,
            ),
        )

    def _set_dynamics(self) -> None:
        for i in range(len(self.model.lengths)):
            self._bullet.changeDynamics(
                self.body,
                i - 1,
                linearDamping=DRAG,
                angularDamping=DRAG,
                jointDamping=0,
                localInertiaDiagonal=list(self.model.inertias[i]),
                lateralFriction=FRICTION,
                rollingFriction=0,
                spinningFriction=0,
                restitution=0,
            )
        for joint in self._joints:  # the default motors would hold the joints still
            self._bullet.setJointMotorControlMultiDof(
                self.body,
                joint,
                self._bullet.POSITION_CONTROL,
                targetPosition=IDENTITY,
                positionGain=0,
                velocityGain=0,
                force=[0, 0, 0],
            )

    def _bend(self) -> None:
        states = self._bullet.getJointStatesMultiDof(self.body, self._joints)
        bend = rotation_vectors(np.array([s[0] for s in states])) - self._rest
        rate = np.array([s[1] for s in states])
        self._bullet.setJointMotorControlMultiDofArray(
            self.body,
            self._joints,
            self._bullet.TORQUE_CONTROL,
            forces=self.model.torques(bend, rate).tolist(),
        )

    def lay(self, tip_a: Array, yaw: float, curvature: Array) -> None:
        """Put the wire at rest on the plate.

        Args:
            tip_a: (3,) apex of end a [m], world frame.
            yaw: direction from tip a into the wire [rad].
            curvature: (n - 1,) rest curvature in the plane at each joint [1/m].
        """
        turn = curvature * (self.model.lengths[1:] + self.model.lengths[:-1]) / 2
        self._rest[:, 0] = -turn  # the links' x axis points down when the wire lies level
        orientation = self._bullet.getQuaternionFromEuler([0, math.pi / 2, yaw])
        along = np.array([math.cos(yaw), math.sin(yaw), 0.0])
        centre = tip_a + along * (self.model.radius + self.model.lengths[0] / 2)
        self._bullet.resetBasePositionAndOrientation(self.body, centre.tolist(), orientation)
        self._bullet.resetBaseVelocity(self.body, [0, 0, 0], [0, 0, 0])
        for joint, angle in zip(self._joints, self._rest[:, 0], strict=True):
            self._bullet.resetJointStateMultiDof(
                self.body,
                joint,
                self._bullet.getQuaternionFromAxisAngle([1, 0, 0], float(angle)),
                [0, 0, 0],
            )

    def link_poses(self) -> tuple[Array, Array]:
        """Return the links' centres (n, 3) [m] and quaternions (n, 4), world frame."""
        base = self._bullet.getBasePositionAndOrientation(self.body)
        states = self._bullet.getLinkStates(self.body, self._joints)
        return (
            np.array([base[0], *[s[0] for s in states]]),
            np.array([base[1], *[s[1] for s in states]]),
        )

    def nodes(self) -> Array:
        """Return the nodes from tip a's apex to tip b's, (n + 1, 3) [m], world frame."""
        centres, quaternions = self.link_poses()
        axes = np.array([rotation_matrix(q)[:, 2] for q in quaternions])
        half = self.model.lengths[:, None] / 2 * axes
        nodes = np.vstack([centres[:1] - half[:1], centres + half])
        nodes[0] -= axes[0] * self.model.radius
        nodes[-1] += axes[-1] * self.model.radius
        return nodes

    def ferrule(self, end: End) -> int:
        """Return the link index of an end's ferrule."""
        return -1 if end is End.A else len(self._joints) - 1

    def tip(self, end: End) -> tuple[Array, Array]:
        """Return an end's apex (3,) [m] and the unit vector out of it (3,), world frame."""
        nodes = self.nodes()
        apex, inner = (nodes[0], nodes[1]) if end is End.A else (nodes[-1], nodes[-2])
        out = (apex - inner) / np.linalg.norm(apex - inner)
        return apex, out

    def remove(self) -> None:
        """Take the wire out of the world."""
        self._world.remove_before_step(self._bend)
        self._bullet.removeBody(self.body)


def link_colours(colour: str, links: int) -> list[tuple[float, float, float]]:
    """Return each link's colour: ferrules at both ends, stripes for green-and-yellow."""
    if colour == "GNYE":
        inner = [GREEN_AND_YELLOW[i % 2] for i in range(links - 2)]
    else:
        inner = [WIRE_RGB[colour]] * (links - 2)
    return [FERRULE_RGB, *inner, FERRULE_RGB]
