"""Strands and the places where they meet, cleaned of what thinning makes of thick lines.

Spurs go. A crossing is thinned to two places where three strands meet, with a short strand between
them: these become one place. So do two such places with a longer strand between them: a shallow
crossing, whose middle belongs to both cables.
"""

from __future__ import annotations

import cv2
import numpy as np

from remodel_vision.cables.curves.polyline import arc_lengths
from remodel_vision.cables.curves.robust_statistics import median, median_colour
from remodel_vision.cables.strands.pairing import EndId, StrandEnd, heading_at
from remodel_vision.cables.strands.skeleton import Strand
from remodel_vision.pixels import Pixels

# A spur is shorter than this many times the foreground's reach at its root, and so much [px].
SPUR = (1.3, 2.5)
# Strands shorter than this between two places where three meet are shared [cable widths].
SHARED_WIDTHS = 12.0
# A strand this thick, in widths, is two side by side, and may be twice as long.
SHARED_THICKNESS = 1.3
# A ring at a meeting place shorter than this is a hole in the mask [cable widths].
RING_WIDTHS = 3.0
# An end's direction is fitted over this length [cable widths], [px].
HEADING_WIDTHS, HEADING_PX = 3.0, 8
# Weight of the lightness in the distance of colours: cables are lit from one side.
LIGHTNESS = 0.2


class Network:
    """Strands, the places where they meet, and which of them are part of a place.

    Attributes:
        strands: as given.
        width: of the cables, roughly [px].
        lengths: of the strands [px].
    """

    def __init__(self, strands: list[Strand], reach: Pixels, width: float) -> None:
        """Take strands; `reach` (height, width) is each pixel's distance to the background [px]."""
        self.strands = strands
        self.width = width
        self._places = [s.points.astype(np.intp) for s in strands]
        self._reach = [reach[p[:, 1], p[:, 0]] for p in self._places]
        self.lengths = [float(arc_lengths(s.points)[-1]) for s in strands]
        self._parent = {node: node for s in strands for node in s.nodes}
        self._absorbed: set[int] = set()

    def place(self, end: EndId) -> int:
        """Return the meeting place of an end."""
        node = self.strands[end[0]].nodes[end[1]]
        while self._parent[node] != node:
            node = self._parent[node]
        return node

    def undisturbed(self, end: EndId, widths: float) -> int:
        """Return how many points of a strand to leave out at an end, where strands melt."""
        strand = end[0]
        reach = float(self._reach[strand][0 if end[1] == 0 else -1])
        return min(round(reach + widths * self.width), len(self._places[strand]) // 3)

    def free_strands(self) -> list[int]:
        """Return the strands that are no part of a place."""
        return [i for i in range(len(self.strands)) if i not in self._absorbed]

    def meetings(self) -> dict[int, list[EndId]]:
        """Return the ends at each place."""
        found: dict[int, list[EndId]] = {}
        for i in self.free_strands():
            for e in (0, 1):
                found.setdefault(self.place((i, e)), []).append((i, e))
        return found

    def clean(self) -> None:
        """Drop spurs, and make one place of those that belong together."""
        self._prune()
        self._contract_short()
        self._prune()
        self._contract_shared()

    def _prune(self) -> None:
        meetings = self.meetings()
        for i in self.free_strands():
            counts = [len(meetings[self.place((i, e))]) for e in (0, 1)]
            if min(counts) == 1 and max(counts) > 2:
                root = self._reach[i][0 if counts[0] > 1 else -1]
                if self.lengths[i] < SPUR[0] * root + SPUR[1]:
                    self._absorbed.add(i)

    def _contract_short(self) -> None:
        """Make one place of those whose foreground overlaps."""
        meetings = self.meetings()
        for i in self.free_strands():
            a, b = self.place((i, 0)), self.place((i, 1))
            if min(len(meetings[a]), len(meetings[b])) < 3:
                continue
            if a == b:
                if self.lengths[i] < RING_WIDTHS * self.width:
                    self._absorbed.add(i)
                    meetings = self.meetings()
            elif self.lengths[i] <= self._reach[i][0] + self._reach[i][-1] + 1:
                self._contract(i)
                meetings = self.meetings()

    def _contract_shared(self) -> None:
        """Make one place of two where three strands meet, with a strand between them."""
        meetings = self.meetings()
        for i in sorted(self.free_strands(), key=lambda i: self.lengths[i]):
            a, b = self.place((i, 0)), self.place((i, 1))
            if a != b and len(meetings[a]) == len(meetings[b]) == 3:
                thick = 2 * median(self._reach[i]) > SHARED_THICKNESS * self.width
                if self.lengths[i] <= (2 if thick else 1) * SHARED_WIDTHS * self.width:
                    self._contract(i)
                    meetings = self.meetings()

    def _contract(self, strand: int) -> None:
        self._parent[self.place((strand, 0))] = self.place((strand, 1))
        self._absorbed.add(strand)

    def strand_ends(self, rgb: Pixels) -> dict[EndId, StrandEnd]:
        """Return the ends of the free strands, coloured from a picture (height, width, 3)."""
        strand_ends = {}
        span = max(HEADING_PX, round(HEADING_WIDTHS * self.width))
        for i in self.free_strands():
            at = self._places[i]
            lab = cv2.cvtColor(rgb[None, at[:, 1], at[:, 0]], cv2.COLOR_RGB2LAB)[0]
            colour = median_colour(lab) * [LIGHTNESS, 1.0, 1.0]
            width = max(1.0, 2 * median(self._reach[i]) - 1)
            points = self.strands[i].points
            for e in (0, 1):
                inward = points if e == 0 else points[::-1]
                skip = self.undisturbed((i, e), 0.5)
                place, heading = heading_at(inward[skip : skip + span])
                strand_ends[i, e] = StrandEnd(
                    end=(i, e), place=place, heading=heading, colour=colour, width=width
                )
        return strand_ends
