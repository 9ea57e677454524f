"""A component as cameras see it, and how far that can be relied on."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from remodel_work.geometry import Array, Pose

# Keeps normal equations solvable when pictures do not determine all motions.
DAMPING = 1e-9


@dataclass(frozen=True)
class Deviations:
    """How far a pose can be relied on.

    Attributes:
        shift: standard deviation of the component's corners [m], leaving out part after part.
        turn: the same of its direction [rad].
        apart: how far single pictures would move the component along the plate [m].
    """

    shift: float
    turn: float
    apart: float

    def within(self, limits: Deviations) -> bool:
        """Return whether the pose follows from all parts and pictures alike."""
        certain = self.shift <= limits.shift and self.turn <= limits.turn
        return certain and self.apart <= limits.apart


@dataclass(frozen=True, eq=False)
class ComponentObservation:
    """A component as seen.

    Attributes:
        world_from_component: upright on the plate, unless two views or more show otherwise.
        upright: whether it is.
        residual: RMS distance of the edges seen from those of the pose [m].
        shown: share of what should be seen that is, 0 to 1.
        corners: (4, 2) of its label, or of its top, in the last picture [px].
        deviations: of the pose.
        clear: whether it is seen well enough for more pictures to be added.
        reliable: whether it is, and the pose follows from all its parts and pictures.
    """

    world_from_component: Pose
    upright: bool
    residual: float
    shown: float
    corners: Array
    deviations: Deviations
    clear: bool
    reliable: bool


def solved(normal: Array, pull: Array) -> Array:
    """Return the least motion (k,) that normal equations (k, k), (k,) ask for."""
    damping = DAMPING * np.trace(normal) * np.eye(len(pull))
    return np.asarray(np.linalg.lstsq(normal + damping, pull, rcond=None)[0])


def deviations_of(
    parts: Array, pictures: Array, along: list[int], motions: Array, arms: Array
) -> Deviations:
    """Return how far parts and pictures are apart at a pose, each in one step of Gauss and Newton.

    The covariance is that of the jackknife, which needs no model of the noise: what covers a
    component is none. Reference: B. Efron and C. Stein, The jackknife estimate of variance, 1981.

    Args:
        parts: (p, k, k + 1) normal equations of each part, and what they pull with.
        pictures: (q, k, k + 1) the same of each picture.
        along: which of the k motions lead along the plate, or turn on it: x, y, yaw.
        motions: (k, 6) shift [m] and turn [rad], world frame, of a step of each motion.
        arms: (n, 3) from the turn's centre to points whose shifts count [m], world frame.
    """
    whole = parts.sum(axis=0)
    steps = [solved(left[:, :-1], left[:, -1]) @ motions for left in whole - parts]
    moved = np.array(steps) * math.sqrt((len(parts) - 1) / len(parts))
    shifts = moved[:, None, :3] + np.cross(moved[:, None, 3:], arms)
    apart = [solved(own[np.ix_(along, along)], own[along, -1]) @ motions[along] for own in pictures]
    return Deviations(
        shift=float(np.sqrt(np.sum(np.square(shifts), axis=(0, 2))).max()),
        turn=float(np.linalg.norm(moved[:, 3:])),
        apart=max(float(np.linalg.norm(step[:2])) for step in apart),
    )
