"""The shape at rest of a wire whose ends are held and whose rest hangs between them.

The links' energy is that of their joints and their weight. With t the links' unit vectors, a joint
of secant stiffness k between two links has k |t' - t|^2 / 2, which is quadratic in the nodes; only
the links' lengths are nonlinear. Newton's method on the nodes and the links' tensions (Lagrange's
multipliers of the lengths) solves that; the secant stiffnesses follow from the angles, so that a
joint bent beyond its limit has taken its set. Twist is not modelled: the ends may turn about
themselves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remodel_sim.core.wires.wire_mechanics import GRAVITY, CableModel
from remodel_work.geometry import Array

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
