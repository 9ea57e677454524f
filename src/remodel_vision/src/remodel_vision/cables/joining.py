"""From a mask to rough cables: strands joined where they meet, and across gaps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from remodel_vision.cables.foreground import DEVIATIONS, Foreground
from remodel_vision.cables.lines import across_gap, arc_lengths, parabola, smooth
from remodel_vision.cables.network import (
    ALONE,
    EndId,
    Network,
    StrandEnd,
    best_pairs,
    find_strands,
    join_prices,
    thin,
)
from remodel_vision.colour import Pixels
from remodel_work.geometry import Array

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
