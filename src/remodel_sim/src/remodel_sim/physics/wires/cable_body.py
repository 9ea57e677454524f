"""One multibody of a wire: rigid links with spherical joints, driven by torques."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from remodel_sim.core.wires.wire_mechanics import CableModel
from remodel_sim.physics.world import MASS_SCALE, World
from remodel_states.core.wires import Rgb
from remodel_work.component_shape import BODY_FRICTION, Solid
from remodel_work.geometry import Array

# Light drag instead of the internal friction of strands [1/s].
DRAG = 3.0
# Bullet draws a capsule by its collision hull, which is thicker by this margin.
HULL_MARGIN_M = 0.001
IDENTITY = [0.0, 0.0, 0.0, 1.0]


class CableBody:
    """A run of links that fits into one body of PyBullet.

    Attributes:
        model: of these links alone.
        body: PyBullet's number of it; its base is the first link.
    """

    def __init__(
        self,
        world: World,
        model: CableModel,
        colours: list[Rgb],
        connectors: Mapping[int, Sequence[Solid]],
    ) -> None:
        """Make the links, straight; see `place`. Some of them, by index, are connectors."""
        self._bullet = world.bullet
        self.model = model
        self._connectors = connectors
        joints = len(model.spans)
        self._joints = list(range(joints))
        self.body = self._create(colours)
        self._set_dynamics()
        # Bound once: these two are called in every step.
        self._read_joints = self._bullet.getJointStatesMultiDof
        self._apply_torques = self._bullet.setJointMotorControlMultiDofArray

    def _create(self, colours: list[Rgb]) -> int:
        model, bullet = self.model, self._bullet
        masses = list(model.masses * MASS_SCALE)
        shapes = [self._shapes(i, colour) for i, colour in enumerate(colours)]
        half = [[0, 0, length / 2] for length in model.lengths]
        count = len(self._joints)
        return bullet.createMultiBody(
            masses[0],
            shapes[0][0],
            shapes[0][1],
            [0, 0, 0],
            IDENTITY,
            linkMasses=masses[1:],
            linkCollisionShapeIndices=[s[0] for s in shapes[1:]],
            linkVisualShapeIndices=[s[1] for s in shapes[1:]],
            linkPositions=[half[0], *([0, 0, length] for length in model.lengths[1:-1])][:count],
            linkOrientations=[IDENTITY] * count,
            linkInertialFramePositions=half[1:],
            linkInertialFrameOrientations=[IDENTITY] * count,
            linkParentIndices=self._joints,
            linkJointTypes=[bullet.JOINT_SPHERICAL] * count,
            linkJointAxis=[[0, 0, 1]] * count,
            flags=bullet.URDF_USE_SELF_COLLISION | bullet.URDF_USE_SELF_COLLISION_EXCLUDE_PARENT,
        )

    def _shapes(self, i: int, colour: Rgb) -> tuple[int, int]:
        # Shapes sit in the link's own frame, which is at its first joint; the base's frame is its
        # centre.
        length, radius = self.model.lengths[i], self.model.radius
        offset = [0, 0, 0] if i == 0 else [0, 0, length / 2]
        if i in self._connectors:
            return connector_shapes(self._bullet, self._connectors[i], offset[2])
        capsule = self._bullet.GEOM_CAPSULE
        return (
            self._bullet.createCollisionShape(
                capsule, radius=radius, height=length, collisionFramePosition=offset
            ),
            self._bullet.createVisualShape(
                capsule,
                radius=radius - HULL_MARGIN_M,
                length=length,
                rgbaColor=[*colour, 1],
                visualFramePosition=offset,
            ),
        )

    def _set_dynamics(self) -> None:
        for i, inertia in enumerate(self.model.inertias):
            self._bullet.changeDynamics(
                self.body,
                i - 1,
                linearDamping=DRAG,
                angularDamping=DRAG,
                jointDamping=0,
                localInertiaDiagonal=list(inertia),
                lateralFriction=BODY_FRICTION if i in self._connectors else self.model.friction,
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

    @property
    def has_connector(self) -> bool:
        """Whether one of the links is a connector."""
        return bool(self._connectors)

    @property
    def joint_states(self) -> list[tuple]:
        """The joints' states: first a link's turn, a quaternion, then its rate (3,) [rad/s]."""
        return list(self._read_joints(self.body, self._joints))

    def apply(self, torques: list[list[float]]) -> None:
        """Turn the joints by torques for the next step, (n - 1, 3) [N m], joint frame."""
        self._apply_torques(self.body, self._joints, self._bullet.TORQUE_CONTROL, forces=torques)

    def place(self, position: Array, quaternion: Array, turns: Array) -> None:
        """Put the links at rest into a shape.

        Args:
            position: (3,) centre of the first link [m], world frame.
            quaternion: (4,) of the first link, world frame.
            turns: (n - 1, 4) quaternion of each link in the frame of the one before.
        """
        self._bullet.resetBasePositionAndOrientation(
            self.body, position.tolist(), quaternion.tolist()
        )
        self._bullet.resetBaseVelocity(self.body, [0, 0, 0], [0, 0, 0])
        for joint, turned in zip(self._joints, turns.tolist(), strict=True):
            self._bullet.resetJointStateMultiDof(self.body, joint, turned, [0, 0, 0])

    def centres(self) -> Array:
        """Return the links' centres (n, 3) [m], world frame."""
        base = self._bullet.getBasePositionAndOrientation(self.body)
        states = self._bullet.getLinkStates(self.body, self._joints)
        return np.array([base[0], *[s[0] for s in states]])

    def link_poses(self) -> tuple[Array, Array]:
        """Return the links' centres (n, 3) [m] and quaternions (n, 4), world frame."""
        base = self._bullet.getBasePositionAndOrientation(self.body)
        states = self._bullet.getLinkStates(self.body, self._joints)
        return (
            np.array([base[0], *[s[0] for s in states]]),
            np.array([base[1], *[s[1] for s in states]]),
        )


def connector_shapes(bullet, solids: Sequence[Solid], along: float) -> tuple[int, int]:  # noqa: ANN001
    """Return the shapes that collide and are seen of a connector, `along` z from a frame [m]."""
    touched, seen = (
        {
            "shapeTypes": [bullet.GEOM_CAPSULE if s.capsule else bullet.GEOM_BOX for s in parts],
            "halfExtents": [[size / 2 for size in s.size] for s in parts],
            "radii": [s.size[0] / 2 for s in parts],
            "lengths": [s.size[2] - s.size[0] for s in parts],
        }
        for parts in ([s for s in solids if s.solid], solids)
    )
    collision = bullet.createCollisionShapeArray(
        **touched,
        collisionFramePositions=[[*s.centre[:2], s.centre[2] + along] for s in solids if s.solid],
        collisionFrameOrientations=[IDENTITY] * len(touched["radii"]),
    )
    visual = bullet.createVisualShapeArray(
        **seen,
        rgbaColors=[[*s.rgb, 1] for s in solids],
        visualFramePositions=[[*s.centre[:2], s.centre[2] + along] for s in solids],
        visualFrameOrientations=[IDENTITY] * len(solids),
    )
    return collision, visual
