"""A live wire in the world: one multibody, or several bolted together when it is long."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from remodel_sim.core.wire_mechanics import CableModel, ElasticJoints, as_nodes, link_frames
from remodel_sim.physics.wires.cable_body import Bolt, CableBody
from remodel_sim.physics.wires.resting import Movers, RestingParts
from remodel_sim.physics.world import World
from remodel_states.core.wires import Rgb, rgbs_of
from remodel_work.component_shape import FERRULE_RGB, Solid
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
