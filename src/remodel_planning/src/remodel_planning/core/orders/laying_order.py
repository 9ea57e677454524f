"""In which order wires are led into ducts, and from which end.

What a wire is longer than its route stands up as a loop where it leaves its last duct. A wire that
is led past that loop hangs on it, so it comes before. If all wires between two ducts begin in the
same one, their loops stand in the other one, and such an order exists.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

from remodel_planning.core.problem.problem import End, Point

# A loop takes so much of its duct to each side of its slot: there no other wire is taken [mm].
LOOP_MM = 20.0
# A point so near to a way is on it [mm].
BESIDE_MM = 2.0

# What a path has at least that passes a duct: two openings, where it enters, and where it leaves.
_DUCT_POINTS = 4

# Of a wire: opening a, where it enters and leaves ducts and turns, opening b.
Path = Sequence[Point]


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
    led = {
        name: list(path[1:-1]) if first[name] is End.A else list(path[-2:0:-1])
        for name, path in _in_ducts(paths).items()
    }
    # For each wire those that pass its loop.
    before = {
        name: {other for other in led if other != name and _passes(led[other], loop=way[-1])}
        for name, way in led.items()
    }
    turns: dict[str, int] = {}
    while len(turns) < len(led):
        waiting = {name: len(before[name] - turns.keys()) for name in led if name not in turns}
        # Of wires that are in each other's way one with the fewest before it is next.
        fewest = min(waiting.values())
        ready = [name for name, count in waiting.items() if count == fewest]
        turn = max(turns.values(), default=-1) + 1
        turns.update(dict.fromkeys(ready if fewest == 0 else ready[:1], turn))
    return turns


def _in_ducts(paths: Mapping[str, Path]) -> dict[str, Path]:
    """Return the paths that enter and leave a duct between their openings."""
    return {name: path for name, path in paths.items() if len(path) >= _DUCT_POINTS}


def _leg(path: Path, end: End) -> tuple[Point, Point]:
    """Return where a wire enters the duct of an end, and its first corner from there."""
    slot, corner = path[1:3] if end is End.A else path[-2:-4:-1]
    return slot, corner


def _passes(way: Sequence[Point], loop: Point) -> bool:
    """Return whether a wire that is led along a way comes past a loop before it ends."""
    if math.dist(way[0], loop) < LOOP_MM:
        return True
    on_way = any(_distance(loop, p, q) < BESIDE_MM for p, q in pairwise(way))
    return on_way and math.dist(way[-1], loop) >= BESIDE_MM


def _distance(point: Point, p: Point, q: Point) -> float:
    """Return how far a point is from the line between two others."""
    (x, y), (px, py), (qx, qy) = point, p, q
    length = math.dist(p, q)
    share = ((x - px) * (qx - px) + (y - py) * (qy - py)) / length**2 if length else 0.0
    share = min(1.0, max(0.0, share))
    return math.hypot(x - px - share * (qx - px), y - py - share * (qy - py))
