"""From a mask to strands: thin it, and cut the skeleton where strands meet.

Thinning is Guo and Hall's (Comm. ACM 32, 1989), each half step a table lookup of the eight
neighbours' code. (Zhang and Suen's eats up diagonal lines of two pixels from their ends.)
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from remodel_vision.pixels import Pixels
from remodel_work.geometry import Array

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
