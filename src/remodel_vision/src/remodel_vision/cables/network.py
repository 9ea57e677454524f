"""From a mask to a network of strands: thinned, cut where strands meet, their ends paired."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from remodel_vision.cables.lines import arc_lengths, median, median_colour, parabola
from remodel_vision.colour import Pixels
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


MAX_ROUNDS = 40
# A mask goes on for so much beyond its border while it is thinned [px].
RIM = 8
# What lies around a part of a picture is not used.
BORDER = cv2.BORDER_CONSTANT | cv2.BORDER_ISOLATED
# The neighbours north, north-east, ... north-west as (row, column), and as bits of a code.
NEIGHBOURS = ((-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1))
BITS = np.array([[128, 1, 2], [64, 0, 4], [32, 16, 8]], np.float32)


def _removable(first: bool) -> Pixels:
    """Return for each code of neighbours whether a half step of the thinning removes the pixel."""
    table = np.zeros(256, np.uint8)
    for code in range(256):
        north, ne, east, se, south, sw, west, nw = (bool(code >> bit & 1) for bit in range(8))
        branches = (
            (not north and (ne or east))
            + (not east and (se or south))
            + (not south and (sw or west))
            + (not west and (nw or north))
        )
        pairs = min(
            (nw or north) + (ne or east) + (se or south) + (sw or west),
            (north or ne) + (east or se) + (south or sw) + (west or nw),
        )
        kept = (south or sw or not nw) and west if first else (north or ne or not se) and east
        table[code] = branches == 1 and 2 <= pairs <= 3 and not kept
    return table


HALF_STEPS = (_removable(True), _removable(False))


def thin(mask: Pixels) -> Pixels:
    """Return the skeleton of a mask of 0 and 1; lines that touch the border are kept up to it."""
    skeleton = cv2.copyMakeBorder(mask, RIM, RIM, RIM, RIM, cv2.BORDER_REPLICATE)
    x, y, width, height = cv2.boundingRect(skeleton)
    part = skeleton[y : y + height, x : x + width]
    left = cv2.countNonZero(skeleton)
    if not left:
        return mask
    for _ in range(MAX_ROUNDS):
        for removable in HALF_STEPS:
            codes = cv2.filter2D(part, -1, BITS, borderType=BORDER)
            cv2.subtract(part, cv2.LUT(codes, removable), dst=part)
        before, left = left, cv2.countNonZero(part)
        if left == before:
            break
    return np.ascontiguousarray(skeleton[RIM:-RIM, RIM:-RIM])


@dataclass(frozen=True, eq=False)
class Strand:
    """A piece of skeleton between two places where strands end or meet.

    Attributes:
        points: (n, 2) columns and rows [px].
        nodes: numbers of the pixels at its first and last point.
    """

    points: Array
    nodes: tuple[int, int]


def find_strands(skeleton: Pixels) -> list[Strand]:
    """Return the pieces of a skeleton, a picture of 0 and 1."""
    padded = cv2.copyMakeBorder(skeleton, 1, 1, 1, 1, cv2.BORDER_CONSTANT)
    stride = skeleton.shape[1] + 2
    places = np.flatnonzero(padded)
    if not len(places):
        return []
    flat = padded.ravel().astype(bool)
    steps = np.array([r * stride + c for r, c in NEIGHBOURS])
    linked = flat[places[:, None] + steps]
    # A diagonal link is dropped where a link through a shared neighbour exists.
    for bit in (1, 3, 5, 7):
        linked[:, bit] &= ~linked[:, bit - 1] & ~linked[:, (bit + 1) % 8]
    degree = linked.sum(axis=1)
    number = np.zeros(flat.size, np.intp)
    number[places] = np.arange(len(places))
    # The first and the last neighbour of each pixel; of most these are all.
    first = number[places + steps[np.argmax(linked, axis=1)]].tolist()
    last = number[places + steps[7 - np.argmax(linked[:, ::-1], axis=1)]].tolist()
    nodes = np.flatnonzero(degree != 2)
    links = [
        number[p + steps[n]].tolist() for p, n in zip(places[nodes], linked[nodes], strict=True)
    ]
    paths = _walk(first, last, dict(zip(nodes.tolist(), links, strict=True)))
    columns, lines = places % stride - 1, places // stride - 1
    points = np.column_stack([columns, lines]).astype(np.float64)
    return [Strand(points[path], (path[0], path[-1])) for path in paths]


def _walk(first: list[int], last: list[int], links: dict[int, list[int]]) -> list[list[int]]:
    """Return the paths between nodes, then the closed rings.

    Args:
        first: a neighbour of each pixel.
        last: another neighbour of each pixel that is no node.
        links: the neighbours of each node.
    """
    paths = []
    done = [False] * len(first)
    for node, neighbours in links.items():
        done[node] = True
        for after in neighbours:
            if done[after] and after not in links:
                continue
            path, before, here = [node], node, after
            while here not in links:
                done[here] = True
                path.append(here)
                before, here = here, last[here] if first[here] == before else first[here]
            path.append(here)
            # A link between two nodes is met from both.
            if len(path) > 2 or node < here:
                paths.append(path)
    for start in range(len(first)):
        if done[start]:
            continue
        path, before, here = [start], start, first[start]
        done[start] = True
        while here != start:
            done[here] = True
            path.append(here)
            before, here = here, last[here] if first[here] == before else first[here]
        paths.append([*path, start])
    return paths


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
