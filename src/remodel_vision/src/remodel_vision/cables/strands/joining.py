"""Strands joined to cables: hypotheses, pairs at crossings, and the best of them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from remodel_vision.cables.lines import across_gap, arc_lengths, parabola, smooth
from remodel_vision.cables.strands.foreground import (
    DEVIATIONS,
    SPARSE,
    Foreground,
    above,
    distance_from,
    foreign_objects_in,
    majority,
    median_nearby,
    reach_in,
    typical_half_width,
    unlike_any_shade,
    whitening,
)
from remodel_vision.cables.strands.network import Network, Prior, find_strands, thin
from remodel_vision.colour import Pixels
from remodel_work.geometry import Array

# Half widths of the cables that are searched for by their difference from what lies around [px].
HALF_WIDTHS = (1.5, 3.5)
# A cable's colours vary by this much at least [grey levels], and along its shades by this share.
COLOUR_FLOOR, SHADE_SHARE = 6.0, 0.12
# A pixel is of a colour up to so many standard deviations from it.
OF_COLOUR = 3.0


def local_foreground(rgb: Pixels, half_width: float, first: Foreground, prior: Prior) -> Foreground:
    """Return what differs from the median over a few widths around it.

    Args:
        rgb: (height, width, 3), some 320 columns.
        half_width: of the cables, roughly [px].
        first: the foreground by the table's colour.
        prior: what is known.
    """
    pixels = rgb.astype(np.float32)
    near = median_nearby(rgb, half_width)
    whiten, spread = whitening(pixels[1::SPARSE, 1::SPARSE] - near[1::SPARSE, 1::SPARSE])
    distance = distance_from(pixels, near, whiten)
    mask = majority(unlike_any_shade(pixels, near, whiten, distance))
    return _thin_parts(mask, spread, distance, _allowed(rgb, first, prior), first)


def colour_foreground(rgb: Pixels, samples: Array, first: Foreground, prior: Prior) -> Foreground:
    """Return what has the colour of samples (n, 3) [grey levels] of a piece of cable."""
    mean = samples.mean(axis=0)
    apart = samples - mean
    shade = SHADE_SHARE * mean
    spread = apart.T @ apart / len(samples) + COLOUR_FLOOR**2 * np.eye(3) + np.outer(shade, shade)
    values, vectors = np.linalg.eigh(spread)
    whiten = ((vectors / np.sqrt(values)).T).astype(np.float32)
    pixels = rgb.astype(np.float32)
    away = distance_from(pixels, np.broadcast_to(mean.astype(np.float32), pixels.shape), whiten)
    mask = majority((away < OF_COLOUR).astype(np.uint8))
    covered = np.where((mask | first.mask) > 0, 2 * DEVIATIONS, 0.0).astype(np.float32)
    return _thin_parts(mask, first.spread, covered, _allowed(rgb, first, prior), first)


def _allowed(rgb: Pixels, first: Foreground, prior: Prior) -> Pixels | None:
    """Return 1 where a cable may be seen; with a known background, where that is covered."""
    allowed = prior.allowed(rgb)
    if prior.background is None:
        return allowed
    covered = above(first.covered)
    return covered if allowed is None else allowed & covered


def _thin_parts(
    mask: Pixels, spread: float, covered: Pixels, allowed: Pixels | None, first: Foreground
) -> Foreground:
    """Return the parts of a mask that are thin enough for a cable."""
    if allowed is not None:
        mask = mask & allowed
    reach = reach_in(mask)
    half_width = typical_half_width(reach)
    thick = foreign_objects_in(reach, half_width)
    if thick.any():
        mask = np.where(thick > 0, 0, mask).astype(np.uint8)
        reach = reach_in(mask)
    return Foreground(
        mask=mask,
        reach=reach,
        foreign_objects=first.foreign_objects,
        half_width=half_width,
        spread=spread,
        covered=covered,
        distance=np.where(mask > 0, 2 * DEVIATIONS, 0.0).astype(np.float32),
    )


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


# More pieces of skeleton are noise or clutter: pairing them takes too long and means nothing.
MAX_STRANDS = 400
# Rough cables shorter than this are none [cable widths].
MIN_LENGTH_WIDTHS = 5.0
# Their skeletons are this long at least [the same].
MIN_SKELETON_WIDTHS = 3.0
# Gaps up to this are bridged, if no more than so much of them is bare table [cable widths].
GAP_WIDTHS, BARE_WIDTHS = 16.0, 1.2
# The price of the longest gap.
GAP_PRICE = 0.33
# A skeleton's steps are smoothed over so much [cable widths].
SMOOTHING_WIDTHS = 0.4
# A free end is prolonged over what hides the table, at least and at most so far [cable widths].
PROLONG_WIDTHS = (1.5, 8.0)


@dataclass(frozen=True, eq=False)
class RoughCable:
    """A cable as a chain of strands.

    Attributes:
        line: (n, 2) in the mask's pixels.
        width: [px].
        margin: how much dearer the next best way to join its strands was; infinite without choice.
    """

    line: Array
    width: float
    margin: float


def rough_cables(rgb: Pixels, foreground: Foreground) -> list[RoughCable] | None:
    """Return the cables in a picture (height, width, 3) whose foreground is known.

    None where it is in too many pieces.
    """
    strands = find_strands(thin(foreground.mask))
    if len(strands) > MAX_STRANDS:
        return None
    network = Network(strands, foreground.reach, 2 * foreground.half_width)
    network.clean()
    joints = _Joints(network, rgb)
    joints.bridge(foreground.covered)
    found = []
    for chain in joints.chains():
        if sum(network.lengths[i] for i, _ in chain) < MIN_SKELETON_WIDTHS * network.width:
            continue
        rough = joints.rough(chain, foreground.distance)
        if arc_lengths(rough.line)[-1] >= MIN_LENGTH_WIDTHS * rough.width:
            found.append(rough)
    return found


class _Joints:
    """Which end of which strand is joined to which."""

    def __init__(self, network: Network, rgb: Pixels) -> None:
        """Join the strands at every place where some meet."""
        self._network = network
        self._strand_ends: dict[EndId, StrandEnd] = network.strand_ends(rgb)
        self._partner: dict[EndId, EndId] = {}
        self._margin: dict[EndId, float] = {}
        self._free: set[EndId] = set()
        for ends in network.meetings().values():
            if len(ends) == 1:
                self._free.add(ends[0])
                continue
            pairs, margin = best_pairs([self._strand_ends[end] for end in ends])
            self._margin |= dict.fromkeys(ends, margin)
            for a, b in pairs:
                self._join(a, b)

    def _join(self, a: EndId, b: EndId) -> None:
        self._partner[a], self._partner[b] = b, a

    def bridge(self, covered: Pixels) -> None:
        """Join free ends that face each other across something that hides the table."""
        width = self._network.width
        strand_ends = [
            strand_end for end, strand_end in self._strand_ends.items() if end not in self._partner
        ]
        if len(strand_ends) < 2:
            return
        places = np.array([strand_end.place for strand_end in strand_ends])
        gaps = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)) / width
        costs = join_prices(strand_ends) + (GAP_PRICE / GAP_WIDTHS) * gaps
        rows, columns = np.nonzero(np.triu((costs < ALONE) & (gaps <= GAP_WIDTHS), 1))
        order = np.argsort(costs[rows, columns], kind="stable")
        for i, j in zip(rows[order].tolist(), columns[order].tolist(), strict=True):
            a, b = strand_ends[i], strand_ends[j]
            if {a.end, b.end} & self._partner.keys():
                continue
            length = max(3, round(float(gaps[i, j]) * width))
            line = np.linspace(a.place, b.place, length)
            if np.count_nonzero(_values(covered, line) < DEVIATIONS) <= BARE_WIDTHS * width:
                self._join(a.end, b.end)

    def chains(self) -> list[list[EndId]]:
        """Return the cables: the first end of each strand, in order."""
        found = []
        used: set[int] = set()
        starts = [end for end in self._strand_ends if end not in self._partner]
        for start in [*starts, *self._strand_ends]:
            if start[0] in used:
                continue
            chain = [start]
            used.add(start[0])
            while (after := self._partner.get((chain[-1][0], 1 - chain[-1][1]))) is not None:
                if after[0] in used:
                    break
                chain.append(after)
                used.add(after[0])
            found.append(chain)
        return found

    def rough(self, chain: list[EndId], distance: Pixels) -> RoughCable:
        """Return a chain of strands as one line, with cubics where strands melt."""
        parts: list[Array] = []
        for k, (i, e) in enumerate(chain):
            points = self._network.strands[i].points[:: 1 if e == 0 else -1]
            low = self._network.undisturbed((i, e), 0.3) if k else 0
            high = self._network.undisturbed((i, 1 - e), 0.3) if k < len(chain) - 1 else 0
            points = points[low : len(points) - high]
            if k:
                before, after = (
                    self._strand_ends[chain[k - 1][0], 1 - chain[k - 1][1]],
                    self._strand_ends[i, e],
                )
                start, end = parts[-1][-1], points[0]
                parts.append(across_gap(start, before.heading, end, -after.heading, step=1.0))
            parts.append(points)
        first, last = chain[0], (chain[-1][0], 1 - chain[-1][1])
        widths = [self._strand_ends[end].width for end in chain]
        weights = [len(self._network.strands[i].points) for i, _ in chain]
        width = max(1.5, float(np.average(widths, weights=weights)))
        line = smooth(np.vstack(parts), SMOOTHING_WIDTHS * width)
        if first in self._free:
            line = _prolonged(line, distance, width)
        if last in self._free:
            line = _prolonged(line[::-1], distance, width)[::-1]
        ends = [end for i, _ in chain for end in ((i, 0), (i, 1))]
        return RoughCable(line, width, min(self._margin.get(end, math.inf) for end in ends))


def _prolonged(line: Array, distance: Pixels, width: float) -> Array:
    """Continue a line before its first point, along its bend, while the table is hidden.

    What thinning takes off an end is not a lost piece: that little is not added.
    """
    span = line[: max(6, round(4 * width))]
    if len(span) < 6:
        return line
    fit = parabola(len(span), 2) @ span
    beyond = -np.arange(1.0, PROLONG_WIDTHS[1] * width)[:, None] / (len(span) - 1)
    more = fit[0] + beyond * (fit[1] + beyond * fit[2])
    bare = np.flatnonzero(_values(distance, more) < DEVIATIONS)
    hidden = int(bare[0]) if len(bare) else len(more)
    if hidden < PROLONG_WIDTHS[0] * width:
        return line
    return np.vstack([more[: hidden - round(0.5 * width)][::-1], line])


def _values(picture: Pixels, points: Array) -> Pixels:
    """Return a picture's values at points (n, 2)."""
    maps = points.astype(np.float32)
    return cv2.remap(picture, maps[None, :, 0], maps[None, :, 1], cv2.INTER_LINEAR)[0]
