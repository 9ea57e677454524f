"""The wire's mechanics: a chain of rigid links with elastic joints that yield.

The flexible part is cut into cells of length l. A cell is one rigid link; its joints to its
neighbours stand for the half cells around them, so that two cells share a bending stiffness of EI/l
and a torsional stiffness of GJ/l. A ferrule, or a connector, is one rigid link with no flexible
half: its joint has 2 EI/l. PyBullet reports a limited number of joints per body; a longer wire is
made of several bodies, cut in the middle of a cell, whose two halves are bolted together. So the
cut changes nothing in the mechanics.

Beyond the yield curvature a joint takes a set: kinematic hardening, by return mapping (Simo and
Hughes, Computational Inelasticity, 1.5). Torsion stays elastic.

Explicit integration of such stiff joints needs more rotational inertia than the wire has: each link
gets at least J' = 4 K dt^2 (K its stiffer joint), which changes no statics, only fast vibration.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from remodel_work.geometry import Array, multiply_quaternions, turn_between
from remodel_work.panel import PanelWire, WireEnd

GRAVITY = 9.81
# PyBullet reports at most 31 spherical joints of one body; and each iteration of its solver visits
# all joints of a body for each of its contacts. With 16 links a step of a wire of 1.1 m in its duct
# takes 1.5 ms, with 32 it takes 2.1 ms, with 9 no less; but the shorter the bodies, the more of
# them rest while a hand holds the wire.
MAX_LINKS = 10
MIN_CELLS = 8
CELL_TARGET_M = 0.020
# Up to this length cells grow rather than that there are more than so many [m].
MAX_CELL_M = 0.026
MOST_CELLS = 30
# Joint damping c = K tau with tau = dt/4; more is unstable in an explicit step.
DAMPING_STEPS = 0.25
INERTIA_STEPS = 4.0
# A plug of 5.08 mm pitch with its metal weighs some 1.7 g a way [kg/m^3 of its body]; estimated.
CONNECTOR_DENSITY = 2300.0


@dataclass(frozen=True)
class Piece:
    """What becomes one rigid link.

    Attributes:
        length: [m].
        span: flexible length of the whole cell that it is, or is a half of [m]; 0: rigid.
        bolted: whether it is the second half of a cell.
    """

    length: float
    span: float
    bolted: bool = False


@dataclass(frozen=True, eq=False)
class CableModel:
    """A discretised wire of n links and n - 1 joints, from tip a to tip b.

    Attributes:
        radius: of every link's capsule [m].
        friction: lateral friction coefficient of its surface.
        lengths: (n,) distance between the nodes at a link's ends [m]; the capsules' caps go beyond
            by one radius.
        masses: (n,) [kg].
        inertias: (n, 3) about each link's centre, z along the wire [kg m^2], as integrated.
        spans: (n - 1,) flexible length that a joint stands for [m]; 0: the links are bolted.
        stiffness: (n - 1, 3) of each joint: bending, bending, torsion [N m/rad].
        yield_angles: (n - 1,) elastic limit of each joint's bend [rad].
        hardening: bending stiffness beyond the limit over that below it, in [0, 1).
        damping_s: ratio of joint damping to stiffness [s].
    """

    radius: float
    friction: float
    lengths: Array
    masses: Array
    inertias: Array
    spans: Array
    stiffness: Array
    yield_angles: Array
    hardening: float
    damping_s: float

    @property
    def bodies(self) -> tuple[tuple[int, int], ...]:
        """The first link of each body and the one after its last."""
        cuts = [0, *(np.flatnonzero(self.spans == 0.0) + 1).tolist(), len(self.lengths)]
        return tuple(pairwise(cuts))

    def part(self, first: int, last: int) -> CableModel:
        """Return the model of the links from `first` up to, not including, `last`."""
        links, joints = slice(first, last), slice(first, last - 1)
        return replace(
            self,
            lengths=self.lengths[links],
            masses=self.masses[links],
            inertias=self.inertias[links],
            spans=self.spans[joints],
            stiffness=self.stiffness[joints],
            yield_angles=self.yield_angles[joints],
        )

    def torques(self, bend: Array, rate: Array) -> Array:
        """Return the elastic torques of the joints.

        Args:
            bend: (n - 1, 3) rotation from the rest shape [rad], joint frame.
            rate: (n - 1, 3) [rad/s], joint frame.

        Returns:
            (n - 1, 3) [N m], joint frame.
        """
        return -self.stiffness * (bend + self.damping_s * rate)

    def yielded(self, bend: Array, plastic: Array) -> Array:
        """Return the set of the joints after they have been bent.

        Args:
            bend: (n - 1, 2) rotation from the shape at rest before any set [rad].
            plastic: (n - 1, 2) the set so far [rad].
        """
        # Hardening modulus over stiffness, such that the tangent stiffness is as declared.
        ratio = self.hardening / (1.0 - self.hardening)
        driving = bend - (1.0 + ratio) * plastic
        size = np.sqrt(np.einsum("ij,ij->i", driving, driving))
        excess = size - self.yield_angles
        if not np.any(excess > 0.0):
            return plastic
        flow = np.maximum(excess, 0.0) / ((1.0 + ratio) * np.maximum(size, 1e-12))
        return plastic + flow[:, None] * driving


def discretise(wire: PanelWire, time_step: float) -> CableModel:
    """Cut a wire into links for a time step [s]."""
    rigid = [wire.rigid_length(end) for end in (WireEnd.A, WireEnd.B)]
    cells = _cells(wire.length - sum(rigid))
    # A ferrule's cap is the rest of it; so far beyond its link's end a connector's pins reach.
    first, last = (Piece(length - wire.radius, 0.0) for length in rigid)
    model = chain(wire, [first, *cells, last], time_step)
    for connector in wire.connectors:
        body = connector.body_length * connector.body_width * wire.diameter
        model.masses[0 if connector.end is WireEnd.A else -1] = CONNECTOR_DENSITY * body
    return model


def _cells(flexible: float) -> list[Piece]:
    count = max(MIN_CELLS, round(flexible / CELL_TARGET_M))
    if count > MOST_CELLS and flexible <= MOST_CELLS * MAX_CELL_M:
        count = MOST_CELLS
    cell = Piece(flexible / count, flexible / count)
    pieces = [cell] * count
    bodies = math.ceil((count + 1) / (MAX_LINKS - 1))  # every cut makes one link more
    for k in range(bodies - 1, 0, -1):
        cut = k * count // bodies
        half = cell.length / 2
        pieces[cut : cut + 1] = [Piece(half, cell.span), Piece(half, cell.span, bolted=True)]
    return pieces


def chain(wire: PanelWire, pieces: Sequence[Piece], time_step: float) -> CableModel:
    """Make links of a wire's pieces, in order, for a time step [s]; its tips have round caps."""
    lengths = np.array([piece.length for piece in pieces])
    capped = lengths.copy()
    capped[[0, -1]] += wire.radius
    masses = wire.linear_density * capped
    spans = np.array([0.0 if b.bolted else (a.span + b.span) / 2 for a, b in pairwise(pieces)])
    joined = spans > 0.0
    per_length = np.divide(1.0, spans, out=np.zeros_like(spans), where=joined)
    bending = wire.bending_stiffness * per_length
    torsion = wire.torsional_stiffness * per_length
    stiffness = np.column_stack([bending, bending, torsion])
    inflated = INERTIA_STEPS * time_step**2 * _stiffer(np.maximum(bending, torsion))
    across = np.maximum(masses * (3 * wire.radius**2 + lengths**2) / 12, inflated)
    about = INERTIA_STEPS * time_step**2 * _stiffer(torsion)
    along = np.maximum(masses * wire.radius**2 / 2, about)
    return CableModel(
        radius=wire.radius,
        friction=wire.friction,
        lengths=lengths,
        masses=masses,
        inertias=np.column_stack([across, across, along]),
        spans=spans,
        stiffness=stiffness,
        yield_angles=wire.yield_curvature * spans,
        hardening=wire.hardening,
        damping_s=DAMPING_STEPS * time_step,
    )


def _stiffer(joints: Array) -> Array:
    """Return for each of n links the stiffer of its joints, (n - 1,) in, (n,) out."""
    return np.maximum(np.r_[joints, 0.0], np.r_[0.0, joints])


def link_frames(nodes: Array, radius: float) -> tuple[Array, Array]:
    """Return the frames of the links of a wire that is bent without twist.

    Args:
        nodes: (n + 1, 3) from tip to tip [m]; the first and the last are the caps' apexes.
        radius: of the caps [m].

    Returns:
        The links' centres (n, 3) [m] and quaternions (n, 4): z along the wire, and the first link's
        x axis down when it lies level.
    """
    steps = np.diff(nodes, axis=0)
    axes = steps / np.linalg.norm(steps, axis=1, keepdims=True)
    ends = nodes.copy()
    ends[0] += radius * axes[0]
    ends[-1] -= radius * axes[-1]
    level = np.array([np.hypot(axes[0, 0], axes[0, 1]), 0.0, axes[0, 2]])
    pitched = turn_between(np.array([0.0, 0.0, 1.0]), level)
    yaw = float(np.arctan2(axes[0, 1], axes[0, 0])) / 2
    turns = [multiply_quaternions(np.array([0.0, 0.0, np.sin(yaw), np.cos(yaw)]), pitched)]
    for before, after in pairwise(axes):
        turns.append(multiply_quaternions(turn_between(before, after), turns[-1]))
    return (ends[:-1] + ends[1:]) / 2, np.array(turns)


def as_nodes(line: Array, model: CableModel) -> Array:
    """Return the nodes (n + 1, 3) [m] of a wire along a line (m, 3) from tip to tip.

    A line that has as many points as the wire has nodes is returned as it is: they are its nodes.
    Others come from wires that were cut into other links, as by an earlier version.
    """
    if len(line) == len(model.lengths) + 1:
        return line
    steps = model.lengths.copy()
    steps[[0, -1]] += model.radius
    share = np.r_[0.0, np.cumsum(steps)] / steps.sum()
    along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
    return np.column_stack([np.interp(share * along[-1], along, axis) for axis in line.T])


def rotation_vectors(quaternions: Array) -> Array:
    """Return the rotation vectors (n, 3) [rad] of unit quaternions (n, 4)."""
    vectors, scalars = quaternions[:, :3], quaternions[:, 3]
    sine = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    angle = 2.0 * np.arctan2(sine, np.abs(scalars))
    factor = np.divide(angle, sine, out=np.full_like(sine, 2.0), where=sine > 1e-9)
    return vectors * (factor * np.where(scalars < 0.0, -1.0, 1.0))[:, None]


# The elastic joints of a wire in motion: their shape at rest, the set they took, their torques


# How fast a joint's shape at rest is changed for good [rad/s].
TURN_RAD_S = 0.5


class ElasticJoints:
    """All joints of a wire but the bolted ones, in their order."""

    def __init__(self, model: CableModel, time_step: float) -> None:
        """Take the joints of a wire, straight at rest; `time_step` in [s]."""
        self._elastic = model.spans > 0.0
        self._model = replace(
            model,
            spans=model.spans[self._elastic],
            stiffness=model.stiffness[self._elastic],
            yield_angles=model.yield_angles[self._elastic],
        )
        self._turn_per_step = TURN_RAD_S * time_step
        self.rest_at(np.zeros(len(model.spans)))

    def rest_at(self, rest: Array) -> None:
        """Set the angle at rest of each joint about its x axis [rad], and forget any set.

        Args:
            rest: (n - 1,), of the bolted joints as well.
        """
        angles = rest[self._elastic]
        self._rest = np.zeros((len(angles), 3))
        self._rest[:, 0] = angles
        self._plastic = np.zeros((len(angles), 2))
        self._to_turn = np.zeros(len(angles))

    def bend_rest(self, joint: int, angle: float) -> None:
        """Turn a joint's shape at rest about its x axis [rad], over the next steps.

        So slowly that the joint follows instead of taking a set the other way.
        """
        self._to_turn[joint] += angle

    def torques(self, turns: Array, rates: Array) -> Array:
        """Let the joints yield; return their elastic torques for the next step.

        Args:
            turns: (joints, 4) quaternion of each link in the frame of the one before.
            rates: (joints, 3) [rad/s], joint frame.

        Returns:
            (joints, 3) [N m], joint frame.
        """
        if self._to_turn.any():
            turn = np.clip(self._to_turn, -self._turn_per_step, self._turn_per_step)
            self._rest[:, 0] += turn
            self._to_turn -= turn
        bend = rotation_vectors(turns) - self._rest
        self._plastic = self._model.yielded(bend[:, :2], self._plastic)
        bend[:, :2] -= self._plastic
        return self._model.torques(bend, rates)


# The shape at rest of a wire whose ends are held and whose rest hangs between them
#
# The links' energy is that of their joints and their weight. With t the links' unit vectors, a
# joint of secant stiffness k between two links has k |t' - t|^2 / 2, which is quadratic in the
# nodes; only the links' lengths are nonlinear. Newton's method on the nodes and the links' tensions
# (Lagrange's multipliers of the lengths) solves that; the secant stiffnesses follow from the
# angles, so that a joint bent beyond its limit has taken its set. Twist is not modelled: the ends
# may turn about themselves.


DOWN = np.array([0.0, 0.0, -1.0])
# The halves of a cell that is cut are bolted: so many times as stiff as the stiffest joint.
BOLTED = 1e3
# So far a node moves in one iteration at most, and at the end [m].
STEP_M = 0.05
CONVERGED_M = 1e-4
ITERATIONS = 300
# The line that the search starts from leaves a holder by about so much [m].
LEAVING_M = 0.08


@dataclass(frozen=True, eq=False)
class HeldEnd:
    """An end of a wire in a holder.

    Attributes:
        tip: (3,) apex of the end [m].
        out: (3,) unit vector out of the wire.
        straight: from the tip, so much of the wire is held straight [m]; its ferrule always is.
    """

    tip: Array
    out: Array
    straight: float


def hanging_loop(model: CableModel, a: HeldEnd, b: HeldEnd) -> Array:
    """Return the nodes (n + 1, 3) [m] of a wire that hangs at rest between its held ends.

    The frame's z axis points up; `SimulatedWire.lay_along` takes the nodes. Raises ValueError when
    the wire is too short to reach from one holder to the other.
    """
    steps = model.lengths.copy()
    steps[[0, -1]] += model.radius
    nodes, held = _held_nodes(steps, a, b)
    free = ~held
    first, last = int(np.flatnonzero(free)[0]) - 1, int(np.flatnonzero(free)[-1]) + 1
    hanging = steps[first:last]
    chord = float(np.linalg.norm(nodes[last] - nodes[first]))
    if chord > hanging.sum():
        raise ValueError(
            f"{hanging.sum():.3f} m of wire hang between holders {chord:.3f} m apart; "
            "move them together, or hold less of the wire"
        )
    nodes[first : last + 1] = _starting_line(nodes[first], nodes[last], -a.out, -b.out, hanging)
    return _settle(model, steps, nodes, free)


def _held_nodes(steps: Array, a: HeldEnd, b: HeldEnd) -> tuple[Array, Array]:
    """Return all nodes (n + 1, 3), with the held ones in place, and which are (n + 1,)."""
    from_a = np.r_[0.0, np.cumsum(steps)]
    from_b = from_a[-1] - from_a
    at_a = from_a <= max(a.straight, steps[0])
    at_b = from_b <= max(b.straight, steps[-1])
    if np.all(np.logical_or(at_a, at_b)):
        raise ValueError(f"nothing of {from_a[-1]:.3f} m of wire hangs: hold less of it")
    nodes = np.zeros((len(from_a), 3))
    nodes[at_a] = a.tip - from_a[at_a, None] * a.out
    nodes[at_b] = b.tip - from_b[at_b, None] * b.out
    return nodes, np.logical_or(at_a, at_b)


def _starting_line(start: Array, end: Array, leaving: Array, coming: Array, steps: Array) -> Array:
    """Return a smooth sagging line's points (n + 1, 3), about the links' lengths apart."""
    t = np.linspace(0.0, 1.0, 400)[:, None]
    reach = min(LEAVING_M, 0.2 * float(steps.sum()))

    def line(depth: float) -> tuple[Array, Array]:
        below = depth * DOWN
        inner = (start + reach * leaving + below, end + reach * coming + below)
        points = (
            (1 - t) ** 3 * start
            + 3 * (1 - t) ** 2 * t * inner[0]
            + 3 * (1 - t) * t**2 * inner[1]
            + t**3 * end
        )
        return points, np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]

    low, high = 0.0, 2.0 * float(steps.sum())
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (low, middle) if line(middle)[1][-1] > steps.sum() else (middle, high)
    points, along = line(low)
    wanted = np.r_[0.0, np.cumsum(steps)] * along[-1] / steps.sum()
    return np.column_stack([np.interp(wanted, along, axis) for axis in points.T])


def _settle(model: CableModel, steps: Array, nodes: Array, free: Array) -> Array:
    """Return the nodes (n + 1, 3) in equilibrium; those that are not `free` (n + 1,) stay."""
    links = len(steps)
    towards = np.diff(np.eye(links + 1), axis=0) / steps[:, None]  # from nodes to unit vectors
    turning = np.diff(towards, axis=0)  # from nodes to the joints' changes of them
    loose = np.logical_or(free[:-1], free[1:])
    half = GRAVITY * model.masses / 2
    weight = (np.r_[half, 0.0] + np.r_[0.0, half])[:, None] * DOWN
    tension = np.full(links, half.sum())
    for _ in range(ITERATIONS):
        unit = towards @ nodes
        elastic = turning.T @ (_secant_stiffness(model, unit)[:, None] * turning)
        # Compressed links are left out: the joints keep them straight.
        pulled = np.maximum(tension, 0.0) * steps
        hessian = elastic + towards.T @ (pulled[:, None] * towards)
        moved, tension[loose] = _newton_step(
            hessian[np.ix_(free, free)],
            (weight - elastic @ nodes)[free],
            steps[loose, None, None] * unit[loose, None, :] * towards[loose][:, free, None],
            ((1.0 - np.sum(unit**2, axis=1)) * steps / 2)[loose],
        )
        largest = float(np.abs(moved).max())
        nodes[free] += moved * min(1.0, STEP_M / largest)
        if largest < CONVERGED_M:
            return nodes
    raise ValueError(f"no shape at rest found: nodes still move by {largest:.2g} m")


def _newton_step(
    hessian: Array, force: Array, gradients: Array, shortness: Array
) -> tuple[Array, Array]:
    """Return the moves (m, 3) of the free nodes, and the tensions (k,) of the links between them.

    Args:
        hessian: (m, m) of the energy, for each axis.
        force: (m, 3) on the nodes, without the tensions.
        gradients: (k, m, 3) of the links' constraints.
        shortness: (k,) by how much each constraint is missed.
    """
    nodes, links = len(hessian), len(shortness)
    constraints = gradients.reshape(links, 3 * nodes)
    system = np.zeros((3 * nodes + links, 3 * nodes + links))
    system[: 3 * nodes, : 3 * nodes] = np.kron(hessian, np.eye(3))
    system[: 3 * nodes, 3 * nodes :] = constraints.T
    system[3 * nodes :, : 3 * nodes] = constraints
    solution = np.linalg.solve(system, np.r_[force.ravel(), shortness])
    return solution[: 3 * nodes].reshape(nodes, 3), solution[3 * nodes :]


def _secant_stiffness(model: CableModel, unit: Array) -> Array:
    """Return the joints' moments over the changes of the unit vector (n - 1,) [N m]."""
    sine = np.linalg.norm(np.cross(unit[:-1], unit[1:]), axis=1)
    angle = np.arctan2(sine, np.sum(unit[:-1] * unit[1:], axis=1))
    beyond = np.maximum(angle - model.yield_angles, 0.0)
    elastic = angle - (1.0 - model.hardening) * beyond
    secant = model.stiffness[:, 0] * np.divide(
        elastic, np.sin(angle), out=np.ones_like(angle), where=angle > 1e-6
    )
    return np.where(model.spans > 0.0, secant, BOLTED * model.stiffness[:, 0].max())
