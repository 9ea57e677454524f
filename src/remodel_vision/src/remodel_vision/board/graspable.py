"""Where a wire that was not there before can be grasped, by depth pictures from above."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from remodel_vision.board.new_points import new_points, without_noise
from remodel_work.camera import Picture
from remodel_work.geometry import Array, Pose

# Around a place, so much of a wire to each side shows how it runs there [m].
AROUND_M = 0.020
# It is graspable where it is seen from above along so much of that, and is straight: it lies no
# farther aside than so much of its length.
LEAST_SEEN = 0.75
MOST_ASIDE = 0.2
# Places are so far apart [m].
APART_M = 0.030
# Its crest is that of so much of it to each side [m]; so much of what is seen of it lies below the
# crest, but for the depth camera's noise [%].
CREST_M = 0.004
TOP_PERCENT = 95.0


def graspable_places(picture: Picture, before: Picture, radius: float) -> Iterator[Pose]:
    """Yield where a new wire runs straight and nearly level, the highest place first.

    Args:
        picture: with depth, from above, the wire in it.
        before: the same, without the wire.
        radius: of the wire [m].

    Yields:
        A place on its axis, x along it, world frame.
    """
    points, is_own = new_points(picture, before, radius)
    seen = points[without_noise(picture, is_own)]
    left = seen
    while len(left):
        top = left[left[:, 2].argmax()]
        left = left[np.linalg.norm(left[:, :2] - top[:2], axis=1) > APART_M]
        place = _place_at(seen[np.linalg.norm(seen - top, axis=1) < AROUND_M], radius)
        if place is not None:
            yield place


def _place_at(points: Array, radius: float) -> Pose | None:
    """Return how a wire runs through points on it (n, 3); None where it is not graspable."""
    middle = points.mean(axis=0)
    away = points[:, :2] - middle[:2]
    lengths, ways = np.linalg.eigh(away.T @ away)
    along, aside = away @ ways[:, 1], lengths[0]
    if np.ptp(along) < LEAST_SEEN * 2 * AROUND_M or aside > MOST_ASIDE**2 * lengths[1]:
        return None
    crest = points[np.abs(along) < CREST_M, 2]
    if not len(crest):
        return None
    x, y = (float(v) for v in middle[:2])
    z = float(np.percentile(crest, TOP_PERCENT)) - radius
    return Pose.level(x, y, z, math.atan2(ways[1, 1], ways[0, 1]))
