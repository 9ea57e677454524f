"""In which order wires are led into ducts, and from which end.

What a wire is longer than its route stands up as a loop where it leaves its last duct. A wire that
is led past that loop hangs on it, so it comes before. If all wires between two ducts begin in the
same one, their loops stand in the other one, and such an order exists.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from remodel_tasks.core.problem.problem import End, Point

# A loop takes so much of its duct to each side of its slot: there no other wire is taken [mm].
LOOP_MM = 20.0
# A point so near to a way is on it [mm].
BESIDE_MM = 2.0

# What a path has at least that passes a duct: two openings, where it enters, and where it leaves.
_DUCT_POINTS = 4

# Of a wire: opening a, where it enters and leaves ducts and turns, opening b.
Path = Sequence[Point]

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]


def first_ends(paths: Mapping[str, Path]) -> dict[str, End]:
    """Return the end at which each wire begins: on the side where the shortest leg is longer.

    A leg is the way from an opening's slot to the first corner; a wire lies down there before it is
    bent around the corner. All legs that end in one corner are a side. Of two alike, and of a wire
    that passes no duct, it is end a.
    """
    in_ducts = _in_ducts(paths)
    shortest: dict[Point, float] = {}
    for path in in_ducts.values():
        for slot, corner in (_leg(path, end) for end in End):
            shortest[corner] = min(shortest.get(corner, math.inf), math.dist(slot, corner))

    def begins_at(path: Path) -> End:
        return max(End, key=lambda end: shortest[_leg(path, end)[1]])

    return {name: begins_at(path) if name in in_ducts else End.A for name, path in paths.items()}


def laying_turns(paths: Mapping[str, Path], first: Mapping[str, End]) -> dict[str, int]:
    """Return the turn of each wire in ducts, from 0: wires of one turn are in no one's way.

    Args:
        paths: of wires, by name.
        first: the end at which each begins.
    """
    ways = {
        name: np.array(path[1:-1] if first[name] is End.A else path[-2:0:-1], float)
        for name, path in _in_ducts(paths).items()
    }
    if not ways:
        return {}
    loops = _Loops(np.array([way[-1] for way in ways.values()]).reshape(-1, 2))
    passed = [
        indices[indices != own]
        for own, indices in enumerate(_passed(way, loops) for way in ways.values())
    ]
    # By how many wires that have no turn yet the loop of each is passed.
    waiting = np.bincount(np.concatenate(passed), minlength=len(ways))
    turns = np.full(len(ways), -1)
    turn, left = 0, len(ways)
    while left:
        # Of wires that are in each other's way one with the fewest before it is next.
        ready = np.flatnonzero(waiting == 0) if not waiting.min() else [int(waiting.argmin())]
        turns[ready], waiting[ready] = turn, len(ways) ** 2
        for index in ready:
            waiting[passed[index]] -= 1
        turn, left = turn + 1, left - len(ready)
    return dict(zip(ways, turns.tolist(), strict=True))


def _in_ducts(paths: Mapping[str, Path]) -> dict[str, Path]:
    """Return the paths that enter and leave a duct between their openings."""
    return {name: path for name, path in paths.items() if len(path) >= _DUCT_POINTS}


def _leg(path: Path, end: End) -> tuple[Point, Point]:
    """Return where a wire enters the duct of an end, and its first corner from there."""
    slot, corner = path[1:3] if end is End.A else path[-2:-4:-1]
    return slot, corner


class _Loops:
    """Points [mm] where loops stand, sorted by x and by y: ducts lie along one or the other."""

    def __init__(self, points: Array) -> None:
        self.points = points
        self._order = np.argsort(points, axis=0)
        self._sorted = np.take_along_axis(points, self._order, axis=0)

    def between(self, low: Array, high: Array) -> Indices:
        """Return the indices of the loops of which x is between two points, or y: of the fewer."""
        spans = [np.searchsorted(self._sorted[:, axis], (low[axis], high[axis])) for axis in (0, 1)]
        (from_x, to_x), (from_y, to_y) = spans
        if to_x - from_x < to_y - from_y:
            return self._order[from_x:to_x, 0]
        return self._order[from_y:to_y, 1]


def _passed(way: Array, loops: _Loops) -> Indices:
    """Return the indices of the loops that a wire comes past before it ends, as it is led.

    Args:
        way: points (n, 2) [mm] from where it enters its first duct to where its own loop stands.
        loops: of all wires.
    """
    begins, ends = way[0], way[-1]
    near = loops.between(begins - LOOP_MM, begins + LOOP_MM)
    passed = [near[np.hypot(*(loops.points[near] - begins).T) < LOOP_MM]]
    for p, q in pairwise(way):
        near = loops.between(np.minimum(p, q) - BESIDE_MM, np.maximum(p, q) + BESIDE_MM)
        points = loops.points[near]
        is_end = np.hypot(*(points - ends).T) < BESIDE_MM
        passed.append(near[(_distances(points, p, q) < BESIDE_MM) & ~is_end])
    return np.unique(np.concatenate(passed))


def _distances(points: Array, p: Array, q: Array) -> Array:
    """Return how far points (n, 2) are from the line between two others."""
    line = q - p
    shares = (points - p) @ line / max(line @ line, 1e-12)
    beside = points - p - shares.clip(0.0, 1.0)[:, None] * line
    return np.hypot(*beside.T)
