"""Which ends of strands belong together, where several meet.

Of all ways to pair the ends at a place the cheapest is taken. A pair costs the bending energy of
the curve between the two, and how much their colours and widths differ; an end may also stay alone,
at a price.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from remodel_vision.cables.curves.polyline import parabola
from remodel_work.geometry import Array

# An end is (number of its strand, 0 for its first or 1 for its last point).
EndId = tuple[int, int]

# Prices: an end without a partner; one squared unit of colour (CIE Lab) and of relative width, and
# the most that they cost.
ALONE = 0.6
COLOUR_UNIT, COLOUR_MOST = 22.0, 2.0
WIDTH_UNIT, WIDTH_MOST = 0.6, 0.5
# Ends of one strand are paired only when nothing else can be.
OWN_END = 1.5
# More ends at one place are paired greedily: there are 764 ways to pair 8 ends, 2620 for 9.
MAX_OPTIMAL = 8
# Times vectors (n, 2): complex numbers.
PLANE = np.array([1.0, 1.0j])


@dataclass(frozen=True, eq=False)
class StrandEnd:
    """An end of a strand.

    Attributes:
        end: which.
        place: (2,) a little before the end, where the strand is undisturbed [px].
        heading: (2,) unit vector towards the end and beyond it.
        colour: (3,) of the strand, CIE Lab with little weight on the lightness.
        width: of the strand [px].
    """

    end: EndId
    place: Array
    heading: Array
    colour: Array
    width: float


def join_prices(strand_ends: list[StrandEnd]) -> Array:
    """Return the prices (n, n) of taking two of n ends for one cable.

    The bending energy of the cubic between them is 4 (s^2 + s t + t^2) / l with the headings s, t
    against the chord of length l. Vectors in the plane are complex numbers here.
    """
    place = np.array([strand_end.place for strand_end in strand_ends]) @ PLANE
    heading = np.array([strand_end.heading for strand_end in strand_ends]) @ PLANE
    chord = place[None] - place[:, None]
    chord = np.where(np.abs(chord) > 1e-6, chord, heading[:, None]).conj()
    s, t = np.angle(heading[:, None] * chord), np.angle(-heading[None] * chord)
    colour = np.array([strand_end.colour for strand_end in strand_ends])
    apart = colour[None] - colour[:, None]
    hue = np.einsum("ijk,ijk->ij", apart, apart) / COLOUR_UNIT**2
    width = np.array([strand_end.width for strand_end in strand_ends])
    thicker = (width[None] - width[:, None]) / (width[None] + width[:, None])
    size = np.square(thicker * (2 / WIDTH_UNIT))
    strand = np.array([strand_end.end[0] for strand_end in strand_ends])
    own = OWN_END * (strand[None] == strand[:, None])
    bend = s * s + s * t + t * t
    return np.asarray(bend + np.minimum(hue, COLOUR_MOST) + np.minimum(size, WIDTH_MOST) + own)


def best_pairs(strand_ends: list[StrandEnd]) -> tuple[list[tuple[EndId, EndId]], float]:
    """Return the cheapest pairing of the ends at one place, and how much dearer the next is."""
    count = len(strand_ends)
    price = join_prices(strand_ends).tolist()
    if count > MAX_OPTIMAL:
        return _greedy_pairs(strand_ends, price), 0.0
    ranked = sorted(
        (sum(price[i][j] for i, j in pairs) + ALONE * (count - 2 * len(pairs)), pairs)
        for pairs in _pairings(tuple(range(count)))
    )
    margin = ranked[1][0] - ranked[0][0] if len(ranked) > 1 else math.inf
    return [(strand_ends[i].end, strand_ends[j].end) for i, j in ranked[0][1]], margin


def _pairings(items: tuple[int, ...]) -> Iterator[tuple[tuple[int, int], ...]]:
    """Yield every way to pair some of the items and leave the others alone."""
    if len(items) < 2:
        yield ()
        return
    first, rest = items[0], items[1:]
    yield from _pairings(rest)
    for k, other in enumerate(rest):
        for more in _pairings(rest[:k] + rest[k + 1 :]):
            yield ((first, other), *more)


def _greedy_pairs(
    strand_ends: list[StrandEnd], price: list[list[float]]
) -> list[tuple[EndId, EndId]]:
    pairs, taken = [], set[int]()
    options = [(price[i][j], i, j) for i, j in itertools.combinations(range(len(strand_ends)), 2)]
    for cost, i, j in sorted(options):
        if cost < 2 * ALONE and not {i, j} & taken:
            taken |= {i, j}
            pairs.append((strand_ends[i].end, strand_ends[j].end))
    return pairs


def heading_at(points: Array) -> tuple[Array, Array]:
    """Return the first of some points (n, 2), smoothed, and the unit vector that leads to it."""
    if len(points) < 3:
        return points[0], np.zeros(2)
    fit = parabola(len(points), 2 if len(points) >= 8 else 1) @ points
    return fit[0], -fit[1] / max(math.hypot(*fit[1].tolist()), 1e-9)
