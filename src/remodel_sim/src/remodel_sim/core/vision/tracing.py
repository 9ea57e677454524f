"""Follow a wire through a picture from one of its ends.

The tracer steps along the wire: it looks a step ahead over a fan of directions, takes the best one,
and centres itself across the wire. Where another wire crosses it goes straight on, since the fan is
narrow and favours the direction it has; over a gap it coasts for a few widths before it gives up.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
import numpy.typing as npt

from remodel_sim.core.geometry import Array

FAN_RAD = np.radians(np.linspace(-40, 40, 17))
# Price of turning, in likelihood per radian of turn.
TURN_PRICE = 0.25
# Along a wire of the plate's colour every other piece is as likely as the plate: half a wire.
MIN_LIKELIHOOD = 0.45
# Noise is smoothed by this standard deviation [px].
SMOOTH_PX = 1.2
COAST_WIDTHS = 4.0
MAX_STEPS = 2000


def trace(
    likelihood: npt.NDArray[np.float32], start: Array, direction: Array, width: float
) -> Array:
    """Return the centreline (n, 2) [px] from `start` on.

    Args:
        likelihood: (height, width) of the wire's colour, 0 to 1.
        start: (2,) where the wire begins [px].
        direction: (2,) into the wire.
        width: of the wire [px].
    """
    likelihood = cv2.GaussianBlur(likelihood, (0, 0), SMOOTH_PX).astype(np.float32)
    step = max(1.5, 0.6 * width)
    heading = math.atan2(direction[1], direction[0])
    point = np.asarray(start, np.float64)
    points = [point]
    coasted = 0.0
    for _ in range(MAX_STEPS):
        heading, seen = _best_heading(likelihood, point, heading, step)
        point = point + step * np.array([math.cos(heading), math.sin(heading)])
        if not _inside(likelihood, point):
            break
        if seen >= MIN_LIKELIHOOD:
            point = _centred(likelihood, point, heading, width)
            coasted = 0.0
        else:
            coasted += step
            if coasted > COAST_WIDTHS * width:
                break
        points.append(point)
    kept = len(points) - round(coasted / step)
    return np.array(points[: max(kept, 1)])


def _best_heading(
    likelihood: npt.NDArray[np.float32], point: Array, heading: float, step: float
) -> tuple[float, float]:
    headings = heading + FAN_RAD
    rays = np.column_stack([np.cos(headings), np.sin(headings)])
    values = np.mean([_sample(likelihood, point + k * step * rays) for k in (1.0, 2.0)], axis=0)
    best = int(np.argmax(values - TURN_PRICE * np.abs(FAN_RAD)))
    if values[best] < MIN_LIKELIHOOD:
        return heading, float(values[best])
    return float(headings[best]), float(values[best])


def _centred(
    likelihood: npt.NDArray[np.float32], point: Array, heading: float, width: float
) -> Array:
    """Move across the wire to the centroid of its likelihood."""
    across = np.array([-math.sin(heading), math.cos(heading)])
    offsets = np.linspace(-0.8 * width, 0.8 * width, 13)
    weights = _sample(likelihood, point + offsets[:, None] * across)
    total = float(weights.sum())
    return point + across * (float(weights @ offsets) / total if total > 0.5 else 0.0)


def _sample(likelihood: npt.NDArray[np.float32], points: Array) -> Array:
    maps = points.astype(np.float32)
    return cv2.remap(likelihood, maps[None, :, 0], maps[None, :, 1], cv2.INTER_LINEAR)[0]


def _inside(likelihood: npt.NDArray[np.float32], point: Array) -> bool:
    height, width = likelihood.shape
    return 1 <= point[0] <= width - 2 and 1 <= point[1] <= height - 2


def at_distance(points: Array, distance: float) -> tuple[Array, Array]:
    """Return the point (k,) and the unit tangent (k,) at an arc length along a polyline (n, k).

    Beyond its end the polyline goes on straight.
    """
    pieces = np.linalg.norm(np.diff(points, axis=0), axis=1)
    i = int(np.clip(np.searchsorted(np.cumsum(pieces), distance), 0, len(pieces) - 1))
    tangent = (points[i + 1] - points[i]) / pieces[i]
    return points[i] + tangent * (distance - float(pieces[:i].sum())), tangent
