"""One multibody of a wire: rigid links with spherical joints, driven by torques; and its bolts.

A bolt makes one rigid link of two halves of a cell: the last of a body, the first of the next.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence

import numpy as np

from remodel_sim.core.wire_mechanics import CableModel
from remodel_sim.physics.world import MASS_SCALE, World
from remodel_states.core.wires import Rgb
from remodel_work.component_shape import BODY_FRICTION, Solid
from remodel_work.geometry import Array, rotation_matrix

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


# What holds the halves of a cell together [N]; more than any force in the cell.
BOLT_FORCE_N = 1e4
# When a part comes to rest or wakes, bolts carry their loads again after this time [s]. Where
# friction and walls hold a wire, it is the solver that shares the load among bolts and contacts: a
# bolt to the world takes more or less than one to a body. When a part comes to rest, nothing else
# has changed for a while; when one wakes, something has: then this much is borne [N, N m].
SETTLES_S = 0.02
SHARED = np.repeat([0.5, 1e-2], 3)
# So many loads in turn are remembered.
REMEMBERED = 10


class Bolt:
    """A bolt between two bodies of a wire, of which either may rest: then it holds in the world."""

    def __init__(self, world: World, before: CableBody, after: CableBody) -> None:
        """Bolt two bodies that are awake."""
        self._bullet = world.bullet
        self._before, self._after = before, after
        self._last = len(before.model.spans) - 1
        self._settle_steps = round(SETTLES_S / world.time_step)
        self._bullet.setCollisionFilterPair(before.body, after.body, self._last, -1, 0)
        self._rests = (False, False)
        self._constraint: int | None = self._between()
        # Loads on the body before it, (6,) each: force [N] and torque [N m].
        self._loads: deque[Array] = deque(maxlen=REMEMBERED)
        self._load = np.zeros(6)
        self._changed, self._is_settled = world.steps, True
        self._bears_otherwise = SHARED

    def ignore_contacts(self, before: int, after: int) -> None:
        """Let the links touch nothing that stands for the other one while that rests."""
        pair = self._bullet.setCollisionFilterPair
        pair(before, self._after.body, -1, -1, 0)
        pair(self._before.body, after, self._last, -1, 0)

    def hold(self, rests: tuple[bool, bool], step: int, *, woken: bool) -> None:
        """Hold the bodies, of which one, both or none `rests` now.

        `woken` is whether a part of the wire was woken; else others came to rest.
        """
        if woken:
            self._bears_otherwise = SHARED
        elif self._is_settled:
            self._bears_otherwise = np.full(6, np.inf)
        self._changed, self._is_settled = step, False
        if self._rests == rests:
            return
        self.remove()
        if self._loads:
            self._load = np.mean(self._loads, axis=0)
        self._loads.clear()
        self._rests = before_rests, after_rests = rests
        if not (before_rests or after_rests):
            self._constraint = self._between()
        elif not before_rests:
            half = self._before.model.lengths[-1] / 2
            self._constraint = self._in_world(self._before.body, self._last, half)
        elif not after_rests:
            self._constraint = self._in_world(
                self._after.body, -1, -self._after.model.lengths[0] / 2
            )

    def observe(self) -> None:
        """Remember the load, unless both bodies rest."""
        if self._constraint is not None:
            self._loads.append(self._measured())

    def has_same_load(self, bears: Array) -> bool:
        """Return whether all remembered loads differ by less than what a part `bears` (6,)."""
        if self._constraint is None:
            return True
        is_known = len(self._loads) == REMEMBERED
        return is_known and bool(np.all(np.ptp(self._loads, axis=0) < bears))

    def is_loaded_otherwise(self, step: int, bears: Array) -> bool:
        """Return whether the load differs from that at rest by more than the part `bears` (6,)."""
        if step - self._changed < self._settle_steps:
            return False
        load = self._measured()
        change = np.abs(load - self._load)
        if self._is_settled:
            return bool(np.any(change > bears))
        self._load, self._is_settled = load, True
        return bool(np.any(change > self._bears_otherwise))

    def remove(self) -> None:
        """Take the bolt out of the world."""
        if self._constraint is not None:
            self._bullet.removeConstraint(self._constraint)
            self._constraint = None

    def _measured(self) -> Array:
        """Return force and torque on the body before it, (6,) [N, N m]."""
        load = np.array(self._bullet.getConstraintState(self._constraint))
        return -load if self._rests[0] else load

    def _between(self) -> int:
        return self._fix(
            parentBodyUniqueId=self._before.body,
            parentLinkIndex=self._last,
            childBodyUniqueId=self._after.body,
            childLinkIndex=-1,
            parentFramePosition=[0, 0, self._before.model.lengths[-1] / 2],
            childFramePosition=[0, 0, -self._after.model.lengths[0] / 2],
            childFrameOrientation=IDENTITY,
        )

    def _in_world(self, body: int, link: int, along: float) -> int:
        """Bolt a link to the world where it is, so far along z from its middle [m]."""
        bullet = self._bullet
        if link < 0:
            position, quaternion = bullet.getBasePositionAndOrientation(body)
        else:
            position, quaternion = bullet.getLinkState(body, link)[:2]
        place = np.array(position) + along * rotation_matrix(np.array(quaternion))[:, 2]
        return self._fix(
            parentBodyUniqueId=body,
            parentLinkIndex=link,
            childBodyUniqueId=-1,
            childLinkIndex=-1,
            parentFramePosition=[0, 0, along],
            childFramePosition=place.tolist(),
            childFrameOrientation=quaternion,
        )

    def _fix(self, **frames: object) -> int:
        bullet = self._bullet
        bolt = bullet.createConstraint(
            **frames,
            jointType=bullet.JOINT_FIXED,
            jointAxis=[0, 0, 0],
            parentFrameOrientation=IDENTITY,
        )
        bullet.changeConstraint(bolt, maxForce=BOLT_FORCE_N)
        return int(bolt)
