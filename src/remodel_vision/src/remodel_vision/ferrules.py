"""Find the wires' ends.

Blobs of the ferrules' colour, each with the direction in which its wire leaves.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from remodel_vision.colour import ferrule_mask
from remodel_work.geometry import Array

# A uniform bar of length l has the variance l^2 / 12 along its axis.
BAR = np.sqrt(12.0)
# How far behind the ferrule the wire is searched for, in ferrule widths.
BEHIND_WIDTHS = (0.8, 2.0)


@dataclass(frozen=True, eq=False)
class Ferrule:
    """A ferrule in a picture.

    Attributes:
        centre: (2,) [px].
        out: (2,) unit vector out of the wire, towards the tip.
        length: along the axis [px].
        width: across it [px].
        wire_likelihood: of the colour asked for, 0 to 1, just behind the ferrule.
        truncated: whether it touches the border of the picture.
    """

    centre: Array
    out: Array
    length: float
    width: float
    wire_likelihood: float
    truncated: bool


def find_ferrules(
    rgb: npt.NDArray[np.uint8], likelihood: npt.NDArray[np.float32], min_length_px: float
) -> list[Ferrule]:
    """Return the ferrules in a picture, best match of the wire's colour first.

    Args:
        rgb: (height, width, 3).
        likelihood: (height, width) of the wire's colour.
        min_length_px: shorter blobs are no whole ferrule: most of it hides in an opening.
    """
    mask = ferrule_mask(rgb)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    found = []
    for i in range(1, count):
        x, y, w, h, area = stats[i]
        if area < 4:
            continue
        rows, columns = np.nonzero(labels[y : y + h, x : x + w] == i)
        ferrule = _fit(np.column_stack([columns + x, rows + y]).astype(np.float64), likelihood)
        if ferrule.length >= min_length_px:
            found.append(ferrule)
    return sorted(found, key=lambda f: -f.wire_likelihood)


def _fit(pixels: Array, likelihood: npt.NDArray[np.float32]) -> Ferrule:
    centre = pixels.mean(axis=0)
    # A pixel is itself a square of variance 1/12.
    values, vectors = np.linalg.eigh(np.cov(pixels.T, bias=True) + np.eye(2) / 12)
    width, length = BAR * np.sqrt(values)
    axis = vectors[:, 1]
    behind = {
        sign: _strip(centre, -sign * axis, length, width, likelihood=likelihood) for sign in (-1, 1)
    }
    sign = max(behind, key=lambda s: behind[s])
    height, columns = likelihood.shape
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    truncated = bool(low.min() <= 1 or high[0] >= columns - 2 or high[1] >= height - 2)
    return Ferrule(
        centre=centre,
        out=sign * axis,
        length=float(length),
        width=float(width),
        wire_likelihood=behind[sign],
        truncated=truncated,
    )


def _strip(
    centre: Array,
    direction: Array,
    length: float,
    width: float,
    likelihood: npt.NDArray[np.float32],
) -> float:
    """Return the mean likelihood on the axis just beyond one end of the ferrule."""
    reach = length / 2 + np.linspace(*BEHIND_WIDTHS, 12) * max(width, 2.0)
    points = (centre + reach[:, None] * direction).astype(np.float32)
    values = cv2.remap(likelihood, points[None, :, 0], points[None, :, 1], cv2.INTER_LINEAR)
    return float(values.mean())
