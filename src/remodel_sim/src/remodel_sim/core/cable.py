"""The wire's mechanics: a chain of rigid links with elastic joints.

The insulated part is cut into equal links of length l; a joint between two of them carries bending
stiffness EI/l and torsional stiffness GJ/l. A ferrule is one rigid link; its joint has only half a
cell of flexible wire, hence 2 EI/l. Explicit integration of such stiff joints needs more rotational
inertia than the wire has: each link gets at least J' = 4 K dt^2 (K its stiffer joint), which
changes no statics, only fast vibration.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remodel_sim.core.geometry import Array
from remodel_sim.core.panel import Wire

# PyBullet reports at most 31 spherical joints of one body.
MAX_LINKS = 32
MIN_LINKS = 10
LINK_TARGET_M = 0.020
# GJ / EI of a round bar with a Poisson ratio of 0.25.
TORSION_RATIO = 0.8
# Joint damping c = K tau with tau = dt/4; more is unstable in an explicit step.
DAMPING_STEPS = 0.25
INERTIA_STEPS = 4.0


@dataclass(frozen=True, eq=False)
class CableModel:
    """A discretised wire of n links and n - 1 joints, from tip a to tip b.

    Attributes:
        radius: of every link's capsule [m].
        lengths: (n,) distance between the nodes at a link's ends [m]; the capsules' caps go beyond
            by one radius.
        masses: (n,) [kg].
        inertias: (n, 3) about each link's centre, z along the wire [kg m^2], as integrated.
        stiffness: (n - 1, 3) of each joint: bending, bending, torsion [N m/rad].
        damping_s: ratio of joint damping to stiffness [s].
    """

    radius: float
    lengths: Array
    masses: Array
    inertias: Array
    stiffness: Array
    damping_s: float

    def torques(self, bend: Array, rate: Array) -> Array:
        """Return the elastic torques of the joints.

        Args:
            bend: (n - 1, 3) rotation from the rest shape [rad], joint frame.
            rate: (n - 1, 3) [rad/s], joint frame.

        Returns:
            (n - 1, 3) [N m], joint frame.
        """
        return -self.stiffness * (bend + self.damping_s * rate)


def discretise(wire: Wire, time_step: float) -> CableModel:
    """Cut a wire into links for a time step [s]."""
    flexible = wire.length - 2 * wire.ferrule_length
    inner = int(np.clip(round(flexible / LINK_TARGET_M), MIN_LINKS - 2, MAX_LINKS - 2))
    cell = flexible / inner
    end = wire.ferrule_length - wire.radius  # the cap of the tip is the rest of the ferrule
    lengths = np.array([end, *[cell] * inner, end])
    masses = wire.linear_density * np.array(
        [wire.ferrule_length, *[cell] * inner, wire.ferrule_length]
    )
    bending = wire.bending_stiffness / cell * np.array([2.0, *[1.0] * (inner - 1), 2.0])
    stiffness = np.column_stack([bending, bending, TORSION_RATIO * bending])
    stiffer = np.maximum(np.r_[bending, 0.0], np.r_[0.0, bending])
    inflated = INERTIA_STEPS * stiffer * time_step**2
    across = masses * (3 * wire.radius**2 + lengths**2) / 12
    along = masses * wire.radius**2 / 2
    inertias = np.column_stack(
        [
            np.maximum(across, inflated),
            np.maximum(across, inflated),
            np.maximum(along, TORSION_RATIO * inflated),
        ]
    )
    return CableModel(wire.radius, lengths, masses, inertias, stiffness, DAMPING_STEPS * time_step)


def rotation_vectors(quaternions: Array) -> Array:
    """Return the rotation vectors (n, 3) [rad] of unit quaternions (n, 4)."""
    q = np.where(quaternions[:, 3:] < 0, -quaternions, quaternions)
    sine = np.linalg.norm(q[:, :3], axis=1, keepdims=True)
    angle = 2 * np.arctan2(sine, q[:, 3:])
    return np.where(sine > 1e-9, q[:, :3] * angle / np.maximum(sine, 1e-9), 2 * q[:, :3])
