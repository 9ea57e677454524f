"""A laid-out design as an order of a use case: its wires as tasks, and the arms that do them.

Lengths are in mm in the board's frame. Of what the design says, a task states what the use case has
a characteristic for: `section_mm2`, `colour`, `cable`, `core`, `length_mm` and `left_end_mm` (the
least x of its ends) of a wire, `role` and `part_number` of a component.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from remodel_planner.core.board.board import Board
from remodel_planner.core.board.formboard import Point as PointM
from remodel_planner.core.condition import Value
from remodel_planner.core.imports.assembly import unique_name
from remodel_planner.core.planning.problem import Arm, Point, Terminal
from remodel_planner.core.production import Component, Role, TerminalRef, Wire
from remodel_planner.core.production import Terminal as DesignTerminal
from remodel_planner.core.use_case.designs import DesignKind, Designs
from remodel_planner.core.use_case.model import Characteristic, UseCase
from remodel_planner.core.use_case.work_order import Access, Clip, Task, Way, WorkOrder
from remodel_planner.errors import OrderError


def kind_of(board: Board) -> DesignKind:
    """Tell what a board is for: a harness has segments of its own, or connectors alone."""
    has_devices = any(device.component.role is Role.DEVICE for device in board.devices)
    return DesignKind.CABINET if board.is_cabinet and has_devices else DesignKind.HARNESS


def board_order(board: Board, use_case: UseCase, arms: int) -> WorkOrder:
    """Return the order that places all wires that lie on a board.

    Args:
        board: of any size.
        use_case: by which the wires are placed.
        arms: 1 or 2.

    Raises:
        OrderError: if the use case takes no designs, or no wire lies on the board.
    """
    name = board.order.name
    if use_case.designs is None:
        raise OrderError(
            f"use case {use_case.name} takes no imported designs: it says nothing under `designs` "
            "(docs/use-cases.md); choose another one by --use-case"
        )
    if not board.ways:
        raise OrderError(
            f"order {name} has no wire with both ends on the plate: all {len(board.order.wires)} "
            "lead away, and there is nothing to plan"
        )
    return _Ordering(board, use_case, use_case.designs, arms).order()


class _Ordering:
    """One pass over one board."""

    def __init__(self, board: Board, use_case: UseCase, designs: Designs, arms: int) -> None:
        self._board = board
        self._use_case = use_case
        self._wires = [wire for wire in board.order.wires if wire.name in board.ways]
        points = [_mm(point) for way in board.ways.values() for point in way]
        self._left, self._right = min(x for x, _ in points), max(x for x, _ in points)
        low = min(y for _, y in points)
        self._slot_y = low - round(1e3 * designs.magazine_below_m)
        self._home_y = low - round(1e3 * designs.home_below_m)
        self._arms = self._placed_arms(designs, arms)
        self._names = self._terminal_names()
        self._task_names = _task_names(self._wires)

    def order(self) -> WorkOrder:
        slots = self._slots()
        used = {ref.component for ref in self._names}
        components = [d.component for d in self._board.devices if d.component.name in used]
        return WorkOrder(
            name=self._board.order.name,
            use_case=self._use_case.name,
            arms=self._arms,
            components={component.name: self._said(component) for component in components},
            terminals=tuple(
                Terminal(name, ref.component, _mm(self._board.mouths[ref]))
                for ref, name in self._names.items()
            ),
            tasks=tuple(self._task(wire, slots[wire.name]) for wire in self._wires),
            access={
                self._names[ref]: _access(terminal)
                for component in components
                for terminal in component.terminals
                if (ref := TerminalRef(component.name, terminal.name)) in self._names
            },
        )

    def _placed_arms(self, designs: Designs, count: int) -> tuple[Arm, ...]:
        beside, beyond = (
            round(1e3 * length) for length in (designs.station_beside_m, designs.reach_beyond_m)
        )
        left, right = self._left, self._right
        sides = [(left, left - beside, (left - beyond, right + beyond))]
        if count == 2:
            reach = round((right - left) * designs.reach_of_two)
            sides = [
                (left, left - beside, (left - beyond, left + reach)),
                (right, right + beside, (right - reach, right + beyond)),
            ]
        return tuple(
            Arm(name, (station, self._slot_y), reach, (home, self._home_y), designs.tool, None)
            for name, (home, station, reach) in zip(designs.arms, sides, strict=False)
        )

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
        """Return x of each wire's slot [mm]: the magazine holds the wires by their middles."""
        middle = {wire.name: sum(self._ends_x(wire)) for wire in self._wires}
        ranked = sorted(middle, key=lambda name: middle[name])
        pitch = (self._right - self._left) / len(ranked)
        return {name: round(self._left + (i + 0.5) * pitch) for i, name in enumerate(ranked)}

    def _ends_x(self, wire: Wire) -> tuple[int, int]:
        a, b = (_mm(self._board.mouths[ref])[0] for ref in (wire.a, wire.b))
        return a, b

    def _task(self, wire: Wire, slot_x: int) -> Task:
        order, ends = self._board.order, self._ends_x(wire)
        able = [
            arm.reach_mm
            for arm in self._arms
            if arm.reach_mm[0] <= min(ends) and max(ends) <= arm.reach_mm[1]
        ]
        # A wire that no arm can place alone is handed over; either one may pick it.
        low = min((reach[0] for reach in able), default=self._arms[-1].reach_mm[0])
        high = max((reach[1] for reach in able), default=self._arms[0].reach_mm[1])
        path = tuple(map(_mm, self._board.ways[wire.name]))
        clips = order.clips_of(wire) if wire.route else ()
        nearer = self._arms[sum(ends) >= self._left + self._right] if len(self._arms) > 1 else None
        return Task(
            name=self._task_names[wire.name],
            terminals=(self._names[wire.a], self._names[wire.b]),
            slot_mm=(min(high, max(low, slot_x)), self._slot_y),
            characteristics=self._stated(wire),
            ways=(
                Way(
                    path,
                    tuple(Clip(clip.name, _mm(self._board.clips[clip.name])) for clip in clips),
                    tuple(sorted(set(wire.route))),
                ),
            ),
            meeting_mm=None if able else self._meeting(path),
            preferred_arm=nearer.name if nearer else None,
        )

    def _meeting(self, path: tuple[Point, ...]) -> Point:
        """Return where a way first crosses the middle of the board."""
        middle = (self._left + self._right) / 2
        for p, q in pairwise(path):
            if min(p[0], q[0]) <= middle <= max(p[0], q[0]):
                share = 0.0 if p[0] == q[0] else (middle - p[0]) / (q[0] - p[0])
                return round(middle), round(p[1] + share * (q[1] - p[1]))
        raise AssertionError("a way between both outer parts of the board crosses its middle")

    def _stated(self, wire: Wire) -> dict[str, Value]:
        said: dict[str, Value] = {
            "section_mm2": wire.section_mm2,
            "colour": wire.colour,
            "cable": wire.cable,
            "core": wire.core,
            "length_mm": round(1e3 * self._board.length_of(wire)),
            "left_end_mm": min(self._ends_x(wire)),
        }
        return _declared(said, self._use_case.task_characteristics)

    def _said(self, component: Component) -> dict[str, Value]:
        said: dict[str, Value] = {
            "role": component.role.value,
            "part_number": component.part_number,
        }
        return _declared(said, self._use_case.component_characteristics)


def _access(terminal: DesignTerminal) -> Access:
    return Access(terminal.insertion_force_limit_n, terminal.clearance_m, terminal.approach)


def _task_names(wires: Sequence[Wire]) -> dict[str, str]:
    """Return a name for each wire's task; the files of behaviors do not tell capitals apart."""
    names: dict[str, str] = {}
    taken: set[str] = set()
    for wire in wires:
        name, number = wire.name, 1
        while name.lower() in taken:
            number += 1
            name = f"{wire.name}#{number}"
        taken.add(name.lower())
        names[wire.name] = name
    return names


def _declared(said: dict[str, Value], known: dict[str, Characteristic]) -> dict[str, Value]:
    """Return what a use case has a characteristic for, of what a design says."""
    return {name: value for name, value in said.items() if name in known and value != ""}


def _mm(point: PointM) -> Point:
    return round(1e3 * point[0]), round(1e3 * point[1])
