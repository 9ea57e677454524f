"""Draw panels to be wired, in the form `planbench-1` (docs/planning.md).

A panel has rows of components, horizontal ducts between the rows and a vertical duct at either
side. Only integers and one seeded generator are used: the same size, seed and arms give the same
document forever, and one and two arms get the same wires. The order constraints are drawn from a
hidden order, so that every panel can be wired.
"""

from __future__ import annotations

import itertools
import random
from dataclasses import dataclass
from typing import Any

Json = dict[str, Any]
Point = tuple[int, int]

_COLOURS = {
    **{"black": 0.34, "blue": 0.22, "red": 0.16},
    **{"green-yellow": 0.12, "brown": 0.09, "white": 0.07},
}


@dataclass(frozen=True)
class _Gauge:
    share: float
    tool: str
    insert_ticks: int
    heavy: bool


_GAUGES = {
    "0.75": _Gauge(0.45, "G1", 40, False),
    "1.5": _Gauge(0.30, "G1", 40, False),
    "2.5": _Gauge(0.17, "G2", 50, True),
    "6.0": _Gauge(0.08, "G3", 60, True),
}
_ROW_MM = 300
_SEGMENT_MM = 200
_ROUTE_MM_PER_TICK = 10
_BEND_TICKS = 5
_SLOT_Y_MM = -150


@dataclass(frozen=True)
class _Place:
    """A terminal, and the number of the horizontal duct that it opens to."""

    name: str
    component: str
    x: int
    y: int
    duct: int


@dataclass(frozen=True)
class _Layout:
    width: int
    components: tuple[Json, ...]
    places: tuple[_Place, ...]


def random_panel(wires: int, seed: int, arms: int) -> Json:
    """Return a panel with that many wires (at least 2) for one or two arms."""
    rng = random.Random(1000003 * wires + 7919 * seed)
    layout = _lay_out(wires, rng)
    place = {p.name: p for p in layout.places}
    rows = _draw_wires(wires, arms, layout, rng)
    precedence = _draw_precedence(rows, place, rng)
    soft = _draw_soft_constraints(wires, rng)
    used = {row[end] for row in rows for end in "ab"}
    components = {place[name].component for name in used}
    arm_rows = _arms(layout.width, arms)
    return {
        "format": "planbench-1",
        "name": f"sw{arms}-{wires}-{seed}",
        "seed": seed,
        "n": wires,
        "width": layout.width,
        "speed": 25,
        "durations": {
            **{"pick": 20, "locate": 15, "fix": 30, "tool": 80, "extract": 40, "handover": 25}
        },
        "weights": {
            **{"colour": 5, "zone": 3, "start": 10, "tool": 20, "heavy": 10},
            "arm": 4 if arms == 2 else 0,
        },
        "tools": ["G1", "G2", "G3"],
        "arms": arm_rows,
        "components": [c for c in layout.components if c["id"] in components],
        "terminals": [
            {"id": p.name, "comp": p.component, "x": p.x, "y": p.y}
            for p in layout.places
            if p.name in used
        ],
        "wires": rows,
        "precedence": precedence,
        "soft_before": soft,
        "init": {
            "t0": 0,
            "located": [],
            "history": [],
            "arms": {
                a["id"]: {"pos": a["home"], "tool": a["tool"], "holding": None} for a in arm_rows
            },
            "wires": {},
        },
    }


def _lay_out(wires: int, rng: random.Random) -> _Layout:
    count = max(4, wires // 3)
    rows = max(2, min(8, round((count / 4) ** 0.5) + 1))
    columns = -(-count // rows)
    components: list[Json] = []
    places: list[_Place] = []
    for i in range(count):
        row, column = divmod(i, columns)
        x, y = 60 + column * 120 + rng.randrange(0, 30), 150 + row * _ROW_MM
        components.append({"id": f"c{i}", "x": x + 40, "y": y})
        for j in range(4):
            places.append(_Place(f"c{i}t{j}", f"c{i}", x + j * 25, y + 60, duct=row + 1))
            places.append(_Place(f"c{i}b{j}", f"c{i}", x + j * 25, y - 60, duct=row))
    return _Layout(max(600, columns * 120 + 120), tuple(components), tuple(places))


def _arms(width: int, arms: int) -> list[Json]:
    def arm(name: str, home_x: int, station_x: int, reach: list[int]) -> Json:
        station = [station_x, _SLOT_Y_MM]
        return {
            "id": name,
            "home": [home_x, -300],
            "station": station,
            "tool": "G1",
            "reach": reach,
        }

    if arms == 1:
        return [arm("A", 0, -150, [-1000, width + 1000])]
    left, right = _shared_zone(width)
    return [
        arm("L", 0, -150, [-1000, right]),
        arm("R", width, width + 150, [left, width + 1000]),
    ]


def _shared_zone(width: int) -> tuple[int, int]:
    """Return the range of x that both of two arms reach."""
    return width * 4 // 10, width * 6 // 10


def _draw_wires(count: int, arms: int, layout: _Layout, rng: random.Random) -> list[Json]:
    place = {p.name: p for p in layout.places}
    free = [p.name for p in layout.places]
    rng.shuffle(free)
    rows = []
    for i in range(count):
        a = place[free.pop()]
        b = place[rng.choice(_partners(a, free, place, layout.width, rng=rng))]
        free.remove(b.name)
        rows.append(_wire(f"w{i}", a, b, layout.width, arms=arms, rng=rng))
    return rows


def _partners(
    a: _Place, free: list[str], place: dict[str, _Place], width: int, rng: random.Random
) -> list[str]:
    """Return the terminals among which the other end is drawn: for 60 % of the wires, near ones."""
    anywhere = free[-60:]
    if rng.random() < 0.6:
        near = [name for name in free[-400:] if abs(place[name].x - a.x) <= width // 4]
        return near or anywhere
    return anywhere


def _wire(name: str, a: _Place, b: _Place, width: int, arms: int, rng: random.Random) -> Json:
    gauge = rng.choices(list(_GAUGES), [g.share for g in _GAUGES.values()])[0]
    kind = _GAUGES[gauge]
    path, segments = _path(a, b, width)
    slot_share = rng.random()
    left, right = _shared_zone(width)
    low, high = min(a.x, b.x), max(a.x, b.x)
    by_left, by_right = high <= right, low >= left
    slot_x = left + int(slot_share * (right - left))
    if by_left and not by_right:
        slot_x = int(slot_share * right)
    elif by_right and not by_left:
        slot_x = left + int(slot_share * (width - left))
    row = {
        "id": name,
        "a": a.name,
        "b": b.name,
        "colour": rng.choices(list(_COLOURS), list(_COLOURS.values()))[0],
        "gauge": gauge,
        "tool": kind.tool,
        "heavy": kind.heavy,
        "path": [list(point) for point in path],
        "segments": segments,
        "length": _length(path),
        "route": _route_ticks(path),
        "insert": kind.insert_ticks,
        "zone": min(3, 4 * low // width),
        "slot": [slot_x, _SLOT_Y_MM],
        "handover": None if by_left or by_right else _handover(path, width // 2),
    }
    if arms == 2:
        row["prefer_arm"] = "L" if a.x + b.x < width else "R"
    return row


def _path(a: _Place, b: _Place, width: int) -> tuple[list[Point], list[str]]:
    """Return the way of a wire through the ducts, and the duct segments on it."""
    y_a, y_b = a.duct * _ROW_MM, b.duct * _ROW_MM
    points = [(a.x, a.y), (a.x, y_a)]
    if a.duct == b.duct:
        segments = _horizontal(a.duct, a.x, b.x)
    else:
        by_left = a.x + b.x <= 2 * width - a.x - b.x
        side_x, side = (0, "L") if by_left else (width, "R")
        points += [(side_x, y_a), (side_x, y_b)]
        between = range(min(a.duct, b.duct), max(a.duct, b.duct))
        segments = _horizontal(a.duct, a.x, side_x) + _horizontal(b.duct, side_x, b.x)
        segments += [f"v{side}:{i}" for i in between]
    points += [(b.x, y_b), (b.x, b.y)]
    path = [p for i, p in enumerate(points) if i == 0 or p != points[i - 1]]
    return path, sorted(set(segments))


def _horizontal(duct: int, x1: int, x2: int) -> list[str]:
    first, last = min(x1, x2) // _SEGMENT_MM, max(x1, x2) // _SEGMENT_MM
    return [f"h{duct}:{i}" for i in range(first, last + 1)]


def _length(path: list[Point]) -> int:
    return sum(abs(p[0] - q[0]) + abs(p[1] - q[1]) for p, q in itertools.pairwise(path))


def _route_ticks(path: list[Point]) -> int:
    return -(-_length(path) // _ROUTE_MM_PER_TICK) + _BEND_TICKS * max(0, len(path) - 2)


def _handover(path: list[Point], x: int) -> Json:
    """Return the handover where a path first crosses a vertical line within a horizontal duct."""
    for i, (p, q) in enumerate(itertools.pairwise(path)):
        if p[1] == q[1] and min(p[0], q[0]) <= x <= max(p[0], q[0]):
            meeting = (x, p[1])
            return {
                "pos": list(meeting),
                "route_a": _route_ticks([*path[: i + 1], meeting]),
                "route_b": _route_ticks([meeting, *path[i + 1 :]]),
            }
    raise AssertionError("a wire from the left zone to the right one crosses the middle in a duct")


def _draw_precedence(rows: list[Json], place: dict[str, _Place], rng: random.Random) -> list[Json]:
    hidden = list(range(len(rows)))
    rng.shuffle(hidden)
    rank = {wire: i for i, wire in enumerate(hidden)}
    return _draw_unders(rows, rank, rng) + _draw_pins(rows, rank, place, rng)


def _draw_unders(rows: list[Json], rank: dict[int, int], rng: random.Random) -> list[Json]:
    in_segment: dict[str, list[int]] = {}
    for i, row in enumerate(rows):
        for segment in row["segments"]:
            in_segment.setdefault(segment, []).append(i)
    unders = []
    for j, row in enumerate(rows):
        count = rng.choices([0, 1, 2, 3], [0.35, 0.35, 0.2, 0.1])[0]
        sharing = {i for segment in row["segments"] for i in in_segment[segment]}
        earlier = sorted(i for i in sharing if rank[i] < rank[j])
        for i in rng.sample(earlier, min(count, len(earlier))):
            unders.append({"type": "under", "before": rows[i]["id"], "after": row["id"]})
    return unders


def _draw_pins(
    rows: list[Json], rank: dict[int, int], place: dict[str, _Place], rng: random.Random
) -> list[Json]:
    at_component: dict[str, list[tuple[str, int, str]]] = {}
    for i, row in enumerate(rows):
        for end in "ab":
            at_component.setdefault(place[row[end]].component, []).append((row[end], i, end))
    pins = []
    for component in sorted(at_component):
        ends = sorted(at_component[component])
        for (_, i, end_i), (_, j, end_j) in itertools.pairwise(ends):
            if i == j or rng.random() > 0.35:
                continue
            first, second = ((i, end_i), (j, end_j))
            if rank[i] > rank[j]:
                first, second = second, first
            pins.append(
                {
                    **{"type": "pin", "before": rows[first[0]]["id"], "before_end": first[1]},
                    **{"after": rows[second[0]]["id"], "after_end": second[1]},
                }
            )
    return pins


def _draw_soft_constraints(wires: int, rng: random.Random) -> list[Json]:
    soft = []
    for j in rng.sample(range(wires), max(1, wires // 5)):
        i = rng.randrange(wires)
        if i != j:
            weight = rng.choice([10, 15, 20])
            soft.append({"before": f"w{i}", "after": f"w{j}", "weight": weight})
    return soft
