"""A laid-out design as an order of a use case, which says what its tasks are: wires, or branches.

Lengths are in mm in the board's frame. Of what the design says, a task states what the use case has
a characteristic for: `section_mm2`, `colour`, `cable`, `core`, `seal`, `twisted`, `length_mm`,
`left_end_mm` (the least x of its ends) and `laying_turn` of a wire, `role` and `part_number` of a
component. Cores of a cable, and the wires of a twisted group, have one slot of the magazine and one
preferred arm, and where no arm reaches all their ends, each of them may be handed over.

The laying turn says in which order wires are led into ducts, and from which end. What a wire is
longer than its route stands up as a loop where it leaves its last duct. A wire that is led past
that loop hangs on it, so it comes before. If all wires between two ducts begin in the same one,
their loops stand in the other one, and such an order exists.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from remodel_production.core.board.board import Board
from remodel_production.core.imports.assembly import unique_name
from remodel_production.core.production import Component, Order, Role, Terminal, TerminalRef, Wire
from remodel_production.errors import OrderError
from remodel_run.findings import ByHand
from remodel_tasks.core.condition import Value
from remodel_tasks.core.orders.branch_order import (
    Surroundings,
    branch_order,
    in_mm,
    route_on,
    said_of,
)
from remodel_tasks.core.orders.order_requirements import NOTHING_REQUIRED, OrderRequirements
from remodel_tasks.core.orders.work_order import (
    Access,
    Refusal,
    Task,
    WorkOrder,
    take_name,
)
from remodel_tasks.core.problem.problem import End, PlannedTerminal, Point
from remodel_tasks.core.use_case.model import LONGER_LEG, DesignKind, DesignTasks, UseCase, declared

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


LAYING_TURN = "laying_turn"


def kind_of(board: Board) -> DesignKind:
    """Return what a board is for: a harness has segments of its own, or connectors alone."""
    has_devices = any(device.component.role is Role.DEVICE for device in board.devices)
    return DesignKind.CABINET if board.is_cabinet and has_devices else DesignKind.HARNESS


def leaving_plate(order: Order) -> tuple[ByHand, ...]:
    """Return the wires of an order that leave the plate, and are by hand."""
    return tuple(
        ByHand(wire, (wire,), f"it leaves the plate, {end}")
        for wire, end in order.leaving().items()
    )


def board_order(
    board: Board,
    use_case: UseCase,
    arms: int,
    required: OrderRequirements = NOTHING_REQUIRED,
) -> WorkOrder:
    """Return the order that does all tasks of a use case that lie on a board.

    Args:
        board: of any size.
        use_case: by which the tasks are done.
        arms: 1 or 2.
        required: of single tasks.

    Raises:
        OrderError: if the use case takes no designs, or not this one, or if something is required
            of a task that there is not.
    """
    name, designs = board.order.name, use_case.designs
    if designs is None:
        raise OrderError(
            f"use case {use_case.name} takes no imported designs: it says nothing under `designs` "
            "(docs/use-cases.md); choose another one by --use-case"
        )
    outside = leaving_plate(board.order)
    if not board.routes:
        placed = Surroundings([(0, 0)], designs, arms).arms
        return WorkOrder(name, use_case.name, placed, {}, terminals=(), tasks=(), outside=outside)
    if designs.tasks is DesignTasks.BRANCHES:
        branches = branch_order(board, use_case, designs, arms)
        required.require_known((), name)
        return branches
    points = (in_mm(point) for route in board.routes.values() for point in route)
    wiring = _Wiring(board, use_case, Surroundings(points, designs, arms), required).order()
    return replace(wiring, outside=outside)


class _Wiring:
    """Makes the order of the wires of one board."""

    def __init__(
        self,
        board: Board,
        use_case: UseCase,
        surroundings: Surroundings,
        required: OrderRequirements,
    ) -> None:
        self._board = board
        self._use_case = use_case
        self._around = surroundings
        self._required = required
        self._wires = [wire for wire in board.order.wires if wire.name in board.routes]
        taken: set[str] = set()
        self._task_names = {wire.name: take_name(wire.name, taken) for wire in self._wires}
        required.require_known(self._task_names.values(), board.order.name)
        self._paths = {w.name: tuple(map(in_mm, board.routes[w.name])) for w in self._wires}
        self._first = self._first_ends()
        self._turns = self._laying_turns()
        self._cores: dict[str, list[Wire]] = {}
        for wire in self._wires:
            if wire.cable:
                self._cores.setdefault(wire.cable, []).append(wire)
        self._names = self._terminal_names()
        self._sealed = {
            TerminalRef(component.name, terminal.name): terminal.is_sealed
            for component in board.order.components
            for terminal in component.terminals
        }
        self._twisted = {c.name for c in board.order.cables if "twisted" in c.kind.lower()}

    def order(self) -> WorkOrder:
        slots = self._slots()
        used = {ref.component for ref in self._names}
        components = [d.component for d in self._board.devices if d.component.name in used]
        return WorkOrder(
            name=self._board.order.name,
            use_case=self._use_case.name,
            arms=self._around.arms,
            components={
                component.name: declared(
                    said_of(component), self._use_case.component_characteristics
                )
                for component in components
            },
            terminals=tuple(
                PlannedTerminal(name, ref.component, in_mm(self._board.openings[ref]))
                for ref, name in self._names.items()
            ),
            tasks=tuple(self._task(wire, slots[wire.name]) for wire in self._wires),
            access={
                self._names[ref]: _access(component, terminal)
                for component in components
                for terminal in component.terminals
                if (ref := TerminalRef(component.name, terminal.name)) in self._names
            },
        )

    def _first_ends(self) -> dict[str, End]:
        """Return the end of each wire that is inserted first, unless the planner chooses."""
        first = None if self._use_case.designs is None else self._use_case.designs.first
        chosen: dict[str, End] = {}
        if first == LONGER_LEG:
            chosen = first_ends(self._paths)
        elif first is not None:
            chosen = dict.fromkeys(self._paths, End[first.upper()])
        names, required = self._task_names, dict(self._required.first)
        return chosen | {w: required[names[w]] for w in self._paths if names[w] in required}

    def _laying_turns(self) -> dict[str, int]:
        """Return the turns in which wires are led into ducts, if the use case asks for them."""
        if (
            self._first.keys() < self._paths.keys()
            or LAYING_TURN not in self._use_case.task_characteristics
        ):
            return {}
        return laying_turns(self._paths, self._first)

    def _terminal_names(self) -> dict[TerminalRef, str]:
        """Return a name for each terminal; those that read the same stay apart."""
        names: dict[TerminalRef, str] = {}
        taken: set[str] = set()
        for wire in self._wires:
            for ref in (wire.a, wire.b):
                names[ref] = unique_name(str(ref), taken)
                taken.add(names[ref])
        return names

    def _slots(self) -> dict[str, int]:
        """Return x of each wire's slot [mm]; wires and cables are sorted by their middles."""
        ranked = sorted(self._wires, key=lambda wire: (sum(self._middle(wire)), wire.cable))
        in_slot = {wire.name: (wire.cable, "" if wire.cable else wire.name) for wire in ranked}
        place = {thing: i for i, thing in enumerate(dict.fromkeys(in_slot.values()))}
        left, pitch = self._around.left, (self._around.right - self._around.left) / len(place)
        return {name: round(left + (place[it] + 0.5) * pitch) for name, it in in_slot.items()}

    def _middle(self, wire: Wire) -> tuple[int, ...]:
        """Return the mean x of the ends [mm] of a wire, or of all cores of its cable."""
        ends = [self._ends_x(core) for core in self._cores_with(wire)]
        return tuple(round(sum(xs) / len(ends)) for xs in zip(*ends, strict=True))

    def _cores_with(self, wire: Wire) -> Sequence[Wire]:
        """Return all cores of a wire's cable; the wire alone if it is no core."""
        return self._cores.get(wire.cable, (wire,))

    def _ends_x(self, wire: Wire) -> tuple[int, int]:
        a, b = (in_mm(self._board.openings[ref])[0] for ref in (wire.a, wire.b))
        return a, b

    def _task(self, wire: Wire, slot_x: int) -> Task:
        order, arms = self._board.order, self._around.arms
        of_cable = [x for core in self._cores_with(wire) for x in self._ends_x(core)]
        able = [arm.reach_mm for arm in self._around.able(*of_cable)]
        # A wire that no arm can place alone, or whose cable none can, is handed over; either arm
        # may pick it.
        low = min((reach[0] for reach in able), default=arms[-1].reach_mm[0])
        high = max((reach[1] for reach in able), default=arms[0].reach_mm[1])
        path = self._paths[wire.name]
        clips = order.clips_of(wire) if wire.route else ()
        nearer = self._around.nearer(*self._middle(wire))
        return Task(
            name=self._task_names[wire.name],
            terminals=(self._names[wire.a], self._names[wire.b]),
            slot_mm=(min(high, max(low, slot_x)), self._around.slot_y),
            characteristics=self._stated(wire),
            routes=(route_on(self._board, path, clips, wire.route),),
            first=self._first.get(wire.name),
            meeting_mm=None if able else self._around.meeting(path),
            preferred_arm=nearer.name if nearer else None,
            by_hand=self._by_hand(wire),
        )

    def _by_hand(self, wire: Wire) -> Refusal | None:
        """Return why no robot places a wire, before anything else about it is known."""
        if requirement := dict(self._required.by_hand).get(self._task_names[wire.name]):
            return Refusal("by the order's preferences", f"required: {requirement}")
        full = self._board.full.get(wire.name)
        return Refusal("at terminals that are full", full) if full else None

    def _stated(self, wire: Wire) -> dict[str, Value]:
        said: dict[str, Value] = {
            "section_mm2": wire.section_mm2,
            "colour": wire.colour,
            "cable": wire.cable,
            "core": wire.core,
            "seal": any(self._sealed[ref] for ref in (wire.a, wire.b)),
            "twisted": wire.cable in self._twisted,
            "length_mm": round(1e3 * self._board.length_of(wire)),
            "left_end_mm": min(self._ends_x(wire)),
            LAYING_TURN: self._turns.get(wire.name, 0),
        }
        return declared(said, self._use_case.task_characteristics)


def _access(component: Component, terminal: Terminal) -> Access:
    return Access(
        terminal.insertion_force_limit_n,
        terminal.clearance_m,
        terminal.approach,
        component.type_of(terminal),
    )
