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
