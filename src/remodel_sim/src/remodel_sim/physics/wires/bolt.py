"""What makes one rigid link of two halves of a cell: the last of a body, the first of the next."""

from __future__ import annotations

from collections import deque

import numpy as np

from remodel_sim.physics.wires.cable_body import IDENTITY, CableBody
from remodel_sim.physics.world import World
from remodel_work.geometry import Array, rotation_matrix

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
