"""Which components of a board would stand in each other; import and cell both ask here."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import islice
from typing import NamedTuple

# Rounding of places [m].
_TOLERANCE_M = 1e-6


class Footprint(NamedTuple):
    """The rectangle along the panel's axes that a component takes [m]."""

    low: tuple[float, float]
    high: tuple[float, float]


def footprint(middle: tuple[float, float], size: tuple[float, float], yaw: float) -> Footprint:
    """Return what a component takes.

    Args:
        middle: of it, in the panel's frame [m].
        size: along its own x and y [m].
        yaw: by which it is turned [rad].
    """
    cos, sin = abs(math.cos(yaw)), abs(math.sin(yaw))
    half_x, half_y = (cos * size[0] + sin * size[1]) / 2, (sin * size[0] + cos * size[1]) / 2
    (x, y) = middle
    return Footprint((x - half_x, y - half_y), (x + half_x, y + half_y))


def overlaps(footprints: Mapping[str, Footprint]) -> Iterator[str]:
    """Yield a sentence for each two components that overlap."""
    ranked = sorted(footprints.items(), key=lambda item: item[1])
    for index, (name, one) in enumerate(ranked, start=1):
        for other_name, other in islice(ranked, index, None):
            if other.low[0] >= one.high[0] - _TOLERANCE_M:
                break
            by = min(
                min(one.high[axis], other.high[axis]) - max(one.low[axis], other.low[axis])
                for axis in (0, 1)
            )
            if by > _TOLERANCE_M:
                first, second = sorted((name, other_name))
                yield (
                    f"components {first!r} and {second!r} overlap by {by * 1e3:.1f} mm: places "
                    "farther apart"
                )
