"""Parts of a wire that rest: each of its bodies becomes static until a force that changes comes.

A wire in its ducts rests while one end of it is inserted, and yet the solver would visit each of
its contacts in each step. A body whose links keep their places sleeps instead: it has no weight and
no contacts, and capsules that never move stand where its links are.

It wakes, as it lay, before anything else could move it: when what moves comes near it, when the
load at a bolt between it and a part that is awake changes, and when the cell says so, since it
changes what the wire lies in or is held by.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from remodel_sim.core.wire_mechanics import GRAVITY
from remodel_sim.physics.wires.cable_body import REMEMBERED, Bolt, CableBody
from remodel_sim.physics.world import World
from remodel_work.edge.bullet import MOVING_GROUP, PARKED_GROUP, STATIC_GROUP
from remodel_work.geometry import Array

# Links that stay within so much of their places for so long, under the same loads, rest [m, s].
STILL_M, STILL_S = 5e-5, 0.5
# How often that is checked, and whether a part is reached [s].
CHECK_S, WATCH_S = STILL_S / REMEMBERED, 1 / 120
# A part at rest bears a change of the load at its ends by these shares of what friction can hold
# and of its weight, and of its torque by as much on this lever [m], and not more [N, N m].
FRICTION_SHARE, WEIGHT_SHARE, LEVER_M = 0.5, 0.3, 0.02
MOST_BORNE = np.repeat([0.1, 5e-4], 3)
# A part wakes when what moves comes so near to it, and rests where all is farther away [m].
NEAR_M, CLEAR_M = 0.030, 0.040
# A part of the same wire that is slower than this does not move [m/s]. Along the wire, parts are
# near each other at their bolts, so far [m].
MOVES_M_S = 0.002
ALONG_M = 0.060
# Where the capsules of what is awake are kept [m].
AWAY_Z = -2.0

# Returns the lower and upper corners of boxes around all that moves, each (n, 3) [m].
Movers = Callable[[], tuple[Array, Array]]


class _Part:
    """One body of a wire, which can rest.

    Attributes:
        body: of the wire.
        rests: whether it is static.
        still_since: the step since which its links have kept their places.
        bears: (6,) changes of force and torque at its ends that move nothing of it [N, N m].
        centres: of its links (n, 3) [m], when they were read last.
        along: of its links (n,), along the wire [m].
    """

    def __init__(self, world: World, body: CableBody, along: Array) -> None:
        """Make the capsules that stand for the links while they rest."""
        self._bullet = world.bullet
        self.body, self.along = body, along
        self.rests = False
        self._capsules = [self._capsule(length) for length in body.model.lengths]
        self._links = range(-1, len(body.model.spans))
        self.centres = self._places = self._seen = body.centres()
        self.still_since = world.steps
        self.bears = np.zeros(6)

    def _capsule(self, length: float) -> int:
        bullet, model = self._bullet, self.body.model
        solid = bullet.createCollisionShape(bullet.GEOM_CAPSULE, radius=model.radius, height=length)
        # Bullet draws, in white, the solids of a link that has nothing to draw: it gets a speck.
        speck = bullet.createVisualShape(bullet.GEOM_SPHERE, radius=1e-6)
        capsule = bullet.createMultiBody(0.0, solid, speck, [0.0, 0.0, AWAY_Z])
        bullet.changeDynamics(capsule, -1, lateralFriction=model.friction, restitution=0)
        group = STATIC_GROUP
        bullet.setCollisionFilterGroupMask(capsule, -1, group, ~(STATIC_GROUP | PARKED_GROUP))
        return int(capsule)

    @property
    def first_and_last_capsule(self) -> tuple[int, int]:
        """The bodies that stand for the first and the last link."""
        return self._capsules[0], self._capsules[-1]

    def observe(self, step: int) -> None:
        """Read where the links are, and whether they keep their places."""
        self.centres = self.body.centres()
        if np.abs(self.centres - self._places).max() > STILL_M:
            self._places, self.still_since = self.centres, step

    def find_bearing(self) -> None:
        """Find what changes of load it bears."""
        bullet, model = self._bullet, self.body.model
        held = sum(
            bullet.getDynamicsInfo(contact[2], contact[4])[1] * model.friction * contact[9]
            for contact in bullet.getContactPoints(self.body.body)
        )
        force = FRICTION_SHARE * held + WEIGHT_SHARE * GRAVITY * model.masses.sum()
        self.bears = np.minimum(np.repeat([force, force * LEVER_M], 3), MOST_BORNE)

    def see(self) -> None:
        """Read where the links are."""
        self._seen = self.body.centres()

    def moving(self, least: float) -> tuple[Array, Array]:
        """Return centres of links (n, 3) and their places along the wire (n,) [m].

        They are those that moved by more than `least` [m] since they were observed last.
        """
        before = self._seen
        self.see()
        moved = np.abs(self._seen - before).max(axis=1) > least
        return self._seen[moved], self.along[moved]

    def rest(self) -> None:
        """Become static; Bullet lets it fall for one step, then comes `put_back`."""
        bullet, body = self._bullet, self.body.body
        centres, quaternions = self.body.link_poses()
        self.centres = centres
        self._turns = [state[0] for state in self.body.joint_states]
        self._first = (centres[0], quaternions[0])
        for link in self._links:
            bullet.setCollisionFilterGroupMask(body, link, 0, 0)
        for capsule, centre, quaternion in zip(
            self._capsules, centres.tolist(), quaternions.tolist(), strict=True
        ):
            bullet.resetBasePositionAndOrientation(capsule, centre, quaternion)
        sleep = bullet.ACTIVATION_STATE_ENABLE_SLEEPING | bullet.ACTIVATION_STATE_SLEEP
        bullet.changeDynamics(
            body, -1, activationState=sleep | bullet.ACTIVATION_STATE_DISABLE_WAKEUP
        )
        self.rests = True

    def put_back(self) -> None:
        """Put the links where they came to rest."""
        self.body.place(*self._first, np.array(self._turns))

    def wake(self, step: int) -> None:
        """Become live again, exactly as it came to rest."""
        bullet, body = self._bullet, self.body.body
        self.put_back()
        wake = bullet.ACTIVATION_STATE_WAKE_UP | bullet.ACTIVATION_STATE_DISABLE_SLEEPING
        bullet.changeDynamics(body, -1, activationState=wake)
        for link in self._links:
            bullet.setCollisionFilterGroupMask(body, link, MOVING_GROUP, -1)
        for capsule in self._capsules:
            bullet.resetBasePositionAndOrientation(capsule, [0.0, 0.0, AWAY_Z], [0, 0, 0, 1])
        self.rests, self.still_since = False, step

    def remove(self) -> None:
        """Take the capsules out of the world."""
        for capsule in self._capsules:
            self._bullet.removeBody(capsule)


class RestingParts:
    """Lets parts of a wire rest, and wakes them."""

    def __init__(
        self, world: World, bodies: Sequence[CableBody], bolts: Sequence[Bolt], movers: Movers
    ) -> None:
        """Take the bodies of a wire from its end a, and the bolts between them."""
        self._world, self._bolts, self._movers = world, bolts, movers
        lengths = np.concatenate([body.model.lengths for body in bodies])
        middles = np.cumsum(lengths) - lengths / 2
        cuts = np.cumsum([len(body.model.lengths) for body in bodies])[:-1]
        self._parts = [
            _Part(world, body, along)
            for body, along in zip(bodies, np.split(middles, cuts), strict=True)
        ]
        self._joined = list(zip(bolts, pairwise(self._parts), strict=True))
        for bolt, (before, after) in self._joined:
            bolt.ignore_contacts(before.first_and_last_capsule[1], after.first_and_last_capsule[0])
        self._half_m = float(lengths.max()) / 2
        self._check_steps = max(1, round(CHECK_S / world.time_step))
        self._watch_steps = max(1, round(WATCH_S / world.time_step))
        self._least_m = MOVES_M_S * self._watch_steps * world.time_step
        self._still_steps = round(STILL_S / world.time_step)
        self._resting: list[_Part] = []
        self._fallen: list[_Part] = []

    @property
    def resting(self) -> list[bool]:
        """Whether each body rests, from end a."""
        return [part.rests for part in self._parts]

    def step(self) -> None:
        """Let parts rest, or wake them, before a step."""
        for part in self._fallen:
            part.put_back()
        self._fallen.clear()
        if self._resting and self._world.steps % self._watch_steps == 0:
            self._wake_reached()
        if self._world.steps % self._check_steps == 0:
            self._let_rest()

    def wake(self) -> None:
        """Wake all parts."""
        self._change(self._resting)

    def remove(self) -> None:
        """Take what stands for the parts out of the world."""
        for part in self._parts:
            part.remove()

    def _change(self, parts: Sequence[_Part]) -> None:
        """Let parts rest that are awake, wake the others, and rebolt them."""
        if not parts:
            return
        step = self._world.steps
        woken = any(part.rests for part in parts)
        for part in parts:
            if part.rests:
                part.wake(step)
            else:
                part.rest()
                self._fallen.append(part)
        self._resting = [part for part in self._parts if part.rests]
        self._fallen = [part for part in self._fallen if part.rests]
        for bolt, (before, after) in self._joined:
            bolt.hold((before.rests, after.rests), step, woken=woken)
        for part in self._parts:
            part.see()

    def _let_rest(self) -> None:
        step = self._world.steps
        for bolt in self._bolts:
            bolt.observe()
        awake = [part for part in self._parts if not part.rests]
        for part in awake:
            part.observe(step)
        still = [part for part in awake if self._is_still(part, step)]
        if still:
            boxes = self._movers()
            self._change([part for part in still if _gaps(part.centres, *boxes).min() > CLEAR_M])

    def _is_still(self, part: _Part, step: int) -> bool:
        if part.body.has_connector or step - part.still_since < self._still_steps:
            return False
        part.find_bearing()
        index = self._parts.index(part)
        bolts = self._bolts[max(0, index - 1) : index + 1]
        return all(bolt.has_same_load(part.bears) for bolt in bolts)

    def _wake_reached(self) -> None:
        """Wake what something comes near to, and what is pulled, pushed or bent otherwise."""
        near = self._near_movers() | self._near_moving_links()
        starts = np.cumsum([0, *(len(part.along) for part in self._resting[:-1])])
        reached = np.logical_or.reduceat(near, starts)
        woken = [part for part, is_near in zip(self._resting, reached, strict=True) if is_near]
        for bolt, (before, after) in self._joined:
            if before.rests != after.rests:
                part = before if before.rests else after
                if bolt.is_loaded_otherwise(self._world.steps, part.bears):
                    woken.append(part)
        self._change(list(dict.fromkeys(woken)))

    def _near_movers(self) -> npt.NDArray[np.bool_]:
        """Return which links that rest (n,) a mover is near to."""
        centres = np.vstack([part.centres for part in self._resting])
        return _gaps(centres, *self._movers()) <= NEAR_M

    def _near_moving_links(self) -> npt.NDArray[np.bool_]:
        """Return which links that rest (n,) a moving link is near to, but not along the wire."""
        rest = np.vstack([part.centres for part in self._resting])
        rest_along = np.concatenate([part.along for part in self._resting])
        found = [part.moving(self._least_m) for part in self._parts if not part.rests]
        if not found:
            return np.zeros(len(rest), bool)
        moving, along = (np.concatenate(each) for each in zip(*found, strict=True))
        away = np.linalg.norm(rest[:, None] - moving[None], axis=2)
        apart = np.abs(rest_along[:, None] - along[None]) > ALONG_M
        return np.asarray(np.any(apart & (away < NEAR_M + self._half_m), axis=1))


def _gaps(points: Array, lower: Array, upper: Array) -> Array:
    """Return the least distance of each point (n, 3) from boxes (m, 3) [m]."""
    outside = np.maximum(lower[None] - points[:, None], points[:, None] - upper[None])
    squares = (np.maximum(outside, 0.0) ** 2).sum(axis=2)
    return np.sqrt(squares.min(axis=1, initial=np.inf))
