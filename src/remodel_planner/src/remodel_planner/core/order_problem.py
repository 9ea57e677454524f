"""An order as a planning problem: where its terminals are, and how its wires run between them.

What a design does not say of the cell - its arms, their speed, the durations of actions, what a
plan pays for - is the cell's of the planning benchmark (docs/planning.md). The problem has the
benchmark's form, so that it can be written to a file as it is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from remodel_planner.core.board.board import Board, board_of, way_length
from remodel_planner.core.board.formboard import Point
from remodel_planner.core.imports.assembly import unique_name
from remodel_planner.core.planning.instance import FORMAT, problem_from
from remodel_planner.core.planning.problem import Problem
from remodel_planner.core.production import Order, TerminalRef, Wire
from remodel_planner.errors import OrderError

Json = dict[str, Any]

_MM = 1000
_MM_PER_TICK = 25  # of an arm's travel
_ROUTED_MM_PER_TICK = 10
_BEND_TICKS = 5
_DURATIONS = {"pick": 20, "locate": 15, "fix": 30, "tool": 80, "extract": 40, "handover": 25}
_WEIGHTS = {"colour": 5, "zone": 3, "start": 10, "tool": 20, "heavy": 10}
_ARM_WEIGHT = 4  # of two arms
_HEAVY_MM2 = 2.5
_ZONES = 4
# The magazine and the stations of the tools lie below the board; arms rest below those.
_SLOT_BELOW_MM = 150
_HOME_BELOW_MM = 300
_REACH_BEYOND_MM = 1000
# Of two arms, each reaches this share of the board from its side.
_TWO_ARM_REACH = 0.6


@dataclass(frozen=True)
class _Gripping:
    """How wires up to a section are gripped, and how long an insertion takes."""

    most_mm2: float
    tool: str
    insert_ticks: int


_GRIPPING = (
    _Gripping(1.5, "G1", 40),
    _Gripping(5.9, "G2", 50),
    _Gripping(math.inf, "G3", 60),
)


def order_problem(order: Order, arms: int = 2) -> Problem:
    """Return the problem of placing all wires of an order that lie on its board.

    Args:
        order: of any size; one that is not laid out is laid out first.
        arms: 1 or 2.

    Raises:
        OrderError: if no wire of the order lies on its board.
    """
    return problem_from(order_instance(order, arms))


def order_instance(order: Order, arms: int = 2) -> Json:
    """Return that problem in the benchmark's form.

    Raises:
        OrderError: if no wire of the order lies on its board.
    """
    board = board_of(order)
    wires = [wire for wire in board.order.wires if wire.name in board.ways]
    if not wires:
        raise OrderError(
            f"order {order.name} has no wire with both ends on the plate: all "
            f"{len(order.wires)} lead away, and there is nothing to plan"
        )
    return _Instance(board, wires, arms).data()


class _Instance:
    """One pass over one board. Frame: x from the board's left end, y from its lower one [mm]."""

    def __init__(self, board: Board, wires: list[Wire], arms: int) -> None:
        self._board = board
        self._wires = wires
        points = [p for way in board.ways.values() for p in way]
        self._left = min(x for x, _ in points)
        self._low = min(y for _, y in points)
        self._width = max(1, self._mm((max(x for x, _ in points), self._low))[0])
        self._terminals = self._name_terminals()
        self._arms = _arms(self._width, arms)

    def data(self) -> Json:
        slots = self._slots()
        components = {ref.component for ref in self._terminals}
        return {
            "format": FORMAT,
            "name": self._board.order.name,
            "speed": _MM_PER_TICK,
            "durations": _DURATIONS,
            "weights": {**_WEIGHTS, "arm": _ARM_WEIGHT if len(self._arms) == 2 else 0},
            "tools": [gripping.tool for gripping in _GRIPPING],
            "arms": self._arms,
            "components": [
                {"id": device.component.name}
                for device in self._board.devices
                if device.component.name in components
            ],
            "terminals": [self._terminal(ref, name) for ref, name in self._terminals.items()],
            "wires": [self._wire(wire, slots[wire.name]) for wire in self._wires],
            "precedence": [],
            "soft_before": [],
            "init": {
                "t0": 0,
                "located": [],
                "history": [],
                "arms": {
                    arm["id"]: {"pos": arm["home"], "tool": _GRIPPING[0].tool, "holding": None}
                    for arm in self._arms
                },
                "wires": {},
            },
        }

    def _mm(self, point: Point) -> tuple[int, int]:
        return round((point[0] - self._left) * _MM), round((point[1] - self._low) * _MM)

    def _name_terminals(self) -> dict[TerminalRef, str]:
        names: dict[TerminalRef, str] = {}
        taken: set[str] = set()
        for wire in self._wires:
            for ref in (wire.a, wire.b):
                names[ref] = unique_name(str(ref), taken)
                taken.add(names[ref])
        return names

    def _terminal(self, ref: TerminalRef, name: str) -> Json:
        x, y = self._mm(self._board.mouths[ref])
        return {"id": name, "comp": ref.component, "x": x, "y": y}

    def _slots(self) -> dict[str, int]:
        """Return x of each wire's slot [mm]: the magazine holds wires by their middles."""
        middles = {
            wire.name: sum(self._mm(self._board.mouths[end])[0] for end in (wire.a, wire.b)) / 2
            for wire in self._wires
        }
        ranked = sorted(middles, key=lambda name: middles[name])
        pitch = self._width / len(ranked)
        return {name: round((rank + 0.5) * pitch) for rank, name in enumerate(ranked)}

    def _wire(self, wire: Wire, slot_x: int) -> Json:
        ends = [self._mm(self._board.mouths[end])[0] for end in (wire.a, wire.b)]
        reaching = [
            (low, high)
            for low, high in (arm["reach"] for arm in self._arms)
            if low <= min(ends) and max(ends) <= high
        ]
        # A wire that one arm alone cannot place is handed over; either one may pick it.
        low = min((reach[0] for reach in reaching), default=self._arms[-1]["reach"][0])
        high = max((reach[1] for reach in reaching), default=self._arms[0]["reach"][1])
        gripping = next(g for g in _GRIPPING if wire.section_mm2 <= g.most_mm2)
        way = self._board.ways[wire.name]
        row = {
            "id": wire.name,
            "a": self._terminals[wire.a],
            "b": self._terminals[wire.b],
            "colour": wire.colour or "none",
            "tool": gripping.tool,
            "heavy": wire.section_mm2 >= _HEAVY_MM2,
            "segments": sorted(set(wire.route)),
            "route": _route_ticks(way),
            "insert": gripping.insert_ticks,
            "zone": min(_ZONES - 1, _ZONES * min(ends) // self._width),
            "slot": [min(high, max(low, slot_x)), -_SLOT_BELOW_MM],
            "handover": None if reaching else self._handover(way),
        }
        if len(self._arms) == 2:
            row["prefer_arm"] = self._arms[sum(ends) >= self._width]["id"]
        return row

    def _handover(self, way: tuple[Point, ...]) -> Json:
        """Return the handover where a way first crosses the middle of the board."""
        middle = self._left + self._width / 2 / _MM
        for i, (p, q) in enumerate(pairwise(way)):
            if min(p[0], q[0]) <= middle <= max(p[0], q[0]):
                share = 0.0 if p[0] == q[0] else (middle - p[0]) / (q[0] - p[0])
                meeting = (middle, p[1] + share * (q[1] - p[1]))
                return {
                    "pos": list(self._mm(meeting)),
                    "route_a": _route_ticks((*way[: i + 1], meeting)),
                    "route_b": _route_ticks((meeting, *way[i + 1 :])),
                }
        raise AssertionError("a way between both outer parts of the board crosses its middle")


def _arms(width: int, count: int) -> list[Json]:
    def arm(name: str, home_x: int, station_x: int, reach: list[int]) -> Json:
        return {
            "id": name,
            "home": [home_x, -_HOME_BELOW_MM],
            "station": [station_x, -_SLOT_BELOW_MM],
            "reach": reach,
        }

    beyond = width + _REACH_BEYOND_MM
    if count == 1:
        return [arm("A", 0, -_SLOT_BELOW_MM, [-_REACH_BEYOND_MM, beyond])]
    left = round(width * (1 - _TWO_ARM_REACH))
    right = round(width * _TWO_ARM_REACH)
    return [
        arm("L", 0, -_SLOT_BELOW_MM, [-_REACH_BEYOND_MM, right]),
        arm("R", width, width + _SLOT_BELOW_MM, [left, beyond]),
    ]


def _route_ticks(way: tuple[Point, ...]) -> int:
    length = math.ceil(round(way_length(way) * _MM, 3))
    return -(-length // _ROUTED_MM_PER_TICK) + _BEND_TICKS * max(0, len(way) - 2)
