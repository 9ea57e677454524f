"""A live wire in the world: one multibody, or several bolted together when it is long."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from remodel_sim.core.wire_mechanics import (
    GRAVITY,
    CableModel,
    ElasticJoints,
    as_nodes,
    link_frames,
)
from remodel_sim.physics.wires.cable_body import REMEMBERED, Bolt, CableBody
from remodel_sim.physics.world import World
from remodel_states.core.wires import Rgb, rgbs_of
from remodel_work.component_shape import FERRULE_RGB, Solid
from remodel_work.edge.bullet import MOVING_GROUP, PARKED_GROUP, STATIC_GROUP
from remodel_work.geometry import Array, multiply_quaternions, rotation_matrix
from remodel_work.panel import WireEnd

# A body, and the index of one of its links: -1 for its base.
Link = tuple[int, int]


class SimulatedWire:
    """A wire of links from end a to end b."""

    def __init__(
        self,
        world: World,
        model: CableModel,
        colour: str,
        connectors: Mapping[WireEnd, Sequence[Solid]] = MappingProxyType({}),
    ) -> None:
        """Make the wire, straight along x, its tip a at the origin; see `lay`.

        Ends that are not among the `connectors` have ferrules.
        """
        self._world = world
        self.model = model
        colours = link_colours(colour, len(model.lengths))
        at = {WireEnd.A: 0, WireEnd.B: len(model.lengths) - 1}
        self._parts = [
            CableBody(
                world,
                model.part(first, last),
                colours[first:last],
                {
                    at[end] - first: solids
                    for end, solids in connectors.items()
                    if first <= at[end] < last
                },
            )
            for first, last in model.bodies
        ]
        self._joints = ElasticJoints(model, world.time_step)
        # Of all joints but those that are bolts, by body.
        cuts = np.cumsum([0, *(len(part.model.spans) for part in self._parts)]).tolist()
        self._joints_of_parts = [slice(*cut) for cut in pairwise(cuts)]
        self._turns, self._rates = np.zeros((cuts[-1], 4)), np.zeros((cuts[-1], 3))
        self._resting: RestingParts | None = None
        self.lay(np.zeros(3), 0.0, np.zeros(len(model.spans)))
        self._bolts = [Bolt(world, before, after) for before, after in pairwise(self._parts)]
        world.add_before_step(self._bend)

    def let_rest(self, movers: Movers) -> None:
        """Let parts that rest become static from now on, until one of the `movers` comes near.

        A caller that changes what the wire lies in, or applies a force to it, has to `wake` it.
        """
        self._resting = RestingParts(self._world, self._parts, self._bolts, movers)

    @property
    def resting(self) -> list[bool]:
        """Whether each body rests, from end a."""
        return [False] * len(self._parts) if self._resting is None else self._resting.resting

    def wake(self) -> None:
        """Wake all parts that rest."""
        if self._resting is not None:
            self._resting.wake()

    def _bend(self) -> None:
        """Apply the elastic torques, of all bodies at once: it is done in every step."""
        if self._resting is not None:
            self._resting.step()
        awake = [
            (part, joints)
            for part, joints, rests in zip(
                self._parts, self._joints_of_parts, self.resting, strict=True
            )
            if not rests
        ]
        for part, joints in awake:
            states = part.joint_states
            self._turns[joints] = [state[0] for state in states]
            self._rates[joints] = [state[1] for state in states]
        if awake:
            torques = self._joints.torques(self._turns, self._rates).tolist()
            for part, joints in awake:
                part.apply(torques[joints])

    @property
    def bodies(self) -> tuple[int, ...]:
        """PyBullet's numbers of the wire's bodies."""
        return tuple(part.body for part in self._parts)

    def lay(self, tip_a: Array, yaw: float, curvature: Array) -> None:
        """Put the wire at rest on the plate.

        Args:
            tip_a: (3,) apex of end a [m], world frame.
            yaw: direction from tip a into the wire [rad].
            curvature: (n - 1,) rest curvature in the plane at each joint [1/m].
        """
        self.wake()
        turn = curvature * self.model.spans
        yaws = yaw + np.r_[0.0, np.cumsum(turn)]
        axes = np.column_stack([np.cos(yaws), np.sin(yaws), np.zeros_like(yaws)])
        steps = self.model.lengths[:, None] * axes
        centres = tip_a + self.model.radius * axes[0] + np.cumsum(steps, axis=0) - steps / 2
        # The links' x axis points down when the wire lies level.
        rest = -turn
        turns = np.zeros((len(rest), 4))
        turns[:, 0], turns[:, 3] = np.sin(rest / 2), np.cos(rest / 2)
        self._joints.rest_at(rest)
        for part, (first, last) in zip(self._parts, self.model.bodies, strict=True):
            orientation = self._world.bullet.getQuaternionFromEuler([0, math.pi / 2, yaws[first]])
            part.place(centres[first], np.array(orientation), turns[first : last - 1])

    def lay_along(self, line: Array) -> None:
        """Put the wire at rest into a shape that it has been bent into.

        Args:
            line: (m, 3) from tip to tip [m], world frame, as `nodes` returns it.
        """
        self.wake()
        centres, quaternions = link_frames(as_nodes(line, self.model), self.model.radius)
        flipped = quaternions * np.array([-1.0, -1.0, -1.0, 1.0])
        turns = np.array(list(map(multiply_quaternions, flipped[:-1], quaternions[1:])))
        self._joints.rest_at(np.zeros(len(self.model.spans)))
        for part, (first, last) in zip(self._parts, self.model.bodies, strict=True):
            part.place(centres[first], quaternions[first], turns[first : last - 1])

    def boxes(self) -> tuple[Array, Array]:
        """Return the lower and upper corners of boxes around its links, each (n, 3) [m]."""
        centres = np.vstack([part.centres() for part in self._parts])
        reach = self.model.lengths[:, None] / 2 + self.model.radius
        return centres - reach, centres + reach

    def link_poses(self) -> tuple[Array, Array]:
        """Return the links' centres (n, 3) [m] and quaternions (n, 4), world frame."""
        centres, quaternions = zip(*(part.link_poses() for part in self._parts), strict=True)
        return np.vstack(centres), np.vstack(quaternions)

    def link_pose(self, link: Link) -> tuple[Array, Array]:
        """Return one link's centre (3,) [m] and quaternion (4,), world frame."""
        body, index = link
        bullet = self._world.bullet
        if index < 0:
            position, quaternion = bullet.getBasePositionAndOrientation(body)
        else:
            position, quaternion = bullet.getLinkState(body, index)[:2]
        return np.array(position), np.array(quaternion)

    def nodes(self) -> Array:
        """Return the nodes from tip a's apex to tip b's, (n + 1, 3) [m], world frame."""
        centres, quaternions = self.link_poses()
        axes = np.array([rotation_matrix(q)[:, 2] for q in quaternions])
        half = self.model.lengths[:, None] / 2 * axes
        nodes = np.vstack([centres[:1] - half[:1], centres + half])
        nodes[0] -= axes[0] * self.model.radius
        nodes[-1] += axes[-1] * self.model.radius
        return nodes

    def ferrule(self, end: WireEnd) -> Link:
        """Return the link that is an end's ferrule or connector."""
        if end is WireEnd.A:
            return self._parts[0].body, -1
        last = self._parts[-1]
        return last.body, len(last.model.spans) - 1

    def bend_ferrule(self, end: WireEnd, angle: float) -> None:
        """Give the joint behind an end's ferrule another angle at rest, by so much [rad]."""
        self.wake()
        self._joints.bend_rest(0 if end is WireEnd.A else -1, angle)

    def apex(self, end: WireEnd) -> Array:
        """Return an end's apex (3,) [m], world frame; it costs less than `tip`."""
        centre, quaternion = self.link_pose(self.ferrule(end))
        reach = self.model.lengths[0 if end is WireEnd.A else -1] / 2 + self.model.radius
        return centre + (-reach if end is WireEnd.A else reach) * rotation_matrix(quaternion)[:, 2]

    def tip(self, end: WireEnd) -> tuple[Array, Array]:
        """Return an end's apex (3,) [m] and the unit vector out of it (3,), world frame."""
        nodes = self.nodes()
        apex, inner = (nodes[0], nodes[1]) if end is WireEnd.A else (nodes[-1], nodes[-2])
        out = (apex - inner) / np.linalg.norm(apex - inner)
        return apex, out

    def remove(self) -> None:
        """Take the wire out of the world."""
        self._world.remove_before_step(self._bend)
        for bolt in self._bolts:
            bolt.remove()
        if self._resting is not None:
            self._resting.remove()
        for body in self.bodies:
            self._world.bullet.removeBody(body)


def link_colours(colour: str, links: int) -> list[Rgb]:
    """Return each link's colour: ferrules at both ends, stripes for a wire of several colours."""
    stripes = rgbs_of(colour)
    inner = [stripes[i % len(stripes)] for i in range(links - 2)]
    return [FERRULE_RGB, *inner, FERRULE_RGB]


# Parts of a wire that rest: each of its bodies becomes static until a force that changes comes.
#
# A wire in its ducts rests while one end of it is inserted, and yet the solver would visit each of
# its contacts in each step. A body whose links keep their places sleeps instead: it has no weight
# and no contacts, and capsules that never move stand where its links are.
#
# It wakes, as it lay, before anything else could move it: when what moves comes near it, when the
# load at a bolt between it and a part that is awake changes, and when the cell says so, since it
# changes what the wire lies in or is held by.


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
