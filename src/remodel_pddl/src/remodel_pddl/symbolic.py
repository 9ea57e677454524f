"""A one-arm problem in symbols, for planners that read PDDL or HDDL.

With one arm, locating a component just before the first insertion there costs least, and the time
of a plan is the sum of its actions and moves, so that the costs of actions determine it:

    change-tool   from where the arm is: move to the station, the change, its weight
    pick-heavy, pick-light   move to the slot, picking, what follows from the wire picked before
    keep-soft-order, violate-soft-order, take   resolve the soft orders that end with this pick;
                  the wire is in hand
    aim           which end comes first: the move to its terminal
    locate, insert-first, route, insert-second, fix   as in docs/planning.md
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

from remodel_production.errors import InstanceError
from remodel_tasks.core.problem.problem import (
    Action,
    ActionKind,
    End,
    Plan,
    PlannedWire,
    Point,
    Problem,
    Stage,
)

NOTHING = "nothing"
START, STATION = "at-start", "at-station"
HEAVY_ONLY, LIGHT_BEGUN = "heavy-only", "light-begun"

Ground = tuple[str, ...]


@dataclass(frozen=True)
class Cost:
    """A value of a static function, such as ("approach", "w1", "a") = 12."""

    term: Ground
    value: int


@dataclass(frozen=True)
class Symbols:
    """The problem in symbols.

    Attributes:
        objects: names by type.
        facts: that hold at the start, those that never change among them.
        costs: values of the functions that actions add to the cost.
        names: symbols of wires, components and tools.
    """

    name: str
    objects: dict[str, tuple[str, ...]]
    facts: tuple[Ground, ...]
    costs: tuple[Cost, ...]
    names: dict[tuple[str, str], str]


def symbols_of(problem: Problem) -> Symbols:
    """Return the symbols of a sound problem with one arm whose hand is empty.

    Raises:
        InstanceError: if it has two arms, or a wire in hand.
    """
    if len(problem.arms) != 1:
        raise InstanceError(
            f"{problem.name}: has {len(problem.arms)} arms; costs of actions determine the time "
            "of one arm only: export a problem of one arm"
        )
    if problem.arms[0].holding is not None:
        raise InstanceError(
            f"{problem.name}: the arm holds wire {problem.arms[0].holding}: export the problem "
            "when the hand is empty"
        )
    wires = [wire for wire in problem.wires if wire.stage is Stage.STORED]
    kinds = {
        "wire": [wire.name for wire in wires],
        "component": list(problem.components),
        "tool": list(problem.tools),
    }
    names: dict[tuple[str, str], str] = {}
    for kind, given in kinds.items():
        names |= {(kind, name): _symbol(kind, i, name) for i, name in enumerate(given)}
    writer = _Writer(problem, wires, names)
    return Symbols(
        _symbol("p", 0, problem.name),
        {
            "wire": tuple(names["wire", wire.name] for wire in wires),
            "component": tuple(names["component", name] for name in problem.components),
            "tool": tuple(names["tool", name] for name in problem.tools),
            "place": (
                START,
                STATION,
                *(f"{names['wire', w.name]}-{e.letter}" for w in wires for e in End),
            ),
            "soft-order": tuple(f"soft{i}" for i in range(len(writer.soft))),
        },
        tuple(writer.facts()),
        tuple(writer.costs()),
        names=names,
    )


def _symbol(kind: str, number: int, name: str) -> str:
    """Return a name as PDDL can write it; the number keeps it apart from others."""
    return f"{kind[0]}{number}-{re.sub(r'[^A-Za-z0-9_]', '_', name)}".lower()


class _Writer:
    def __init__(
        self, problem: Problem, wires: Sequence[PlannedWire], names: dict[tuple[str, str], str]
    ) -> None:
        self._p = problem
        self._wires = wires
        self._names = names
        self._arm = problem.arms[0]
        stored = {wire.name for wire in wires}
        self._last = problem.wire[problem.history[-1][0]] if problem.history else None
        of_ranks = (ranking.constraints() for ranking in problem.rankings)
        soft = chain(problem.soft_constraints, *of_ranks)
        self.soft = [each for each in soft if each.before in stored and each.after in stored]

    def facts(self) -> Iterator[Ground]:
        p, wire_name = self._p, {w.name: self._names["wire", w.name] for w in self._wires}
        begun = any(not p.wire[name].heavy for name, _ in p.history)
        yield ("now", LIGHT_BEGUN if begun else HEAVY_ONLY)
        yield ("last", NOTHING)
        yield ("at", START)
        yield ("empty",)
        yield ("has-tool", self._names["tool", self._arm.tool])
        yield ("other", "a", "b")
        yield ("other", "b", "a")
        for name in p.components:
            known = "located" if name in p.located else "unlocated"
            yield (known, self._names["component", name])
        barred = {(pin.after, pin.after_end) for pin in p.pins if pin.before == pin.after}
        for wire in self._wires:
            name = wire_name[wire.name]
            yield ("stored", name)
            yield ("needs", name, self._names["tool", wire.tool])
            yield ("heavy" if wire.heavy else "light", name)
            for end in End:
                component = p.end_terminal(wire, end).component
                yield ("end-at", name, end.letter, f"{name}-{end.letter}")
                yield ("part-of", name, end.letter, self._names["component", component])
                if wire.first in (None, end) and (wire.name, end) not in barred:
                    yield ("may-start", name, end.letter)
        for under in p.unders:
            if under.before in wire_name and under.after in wire_name:
                yield ("under", wire_name[under.before], wire_name[under.after])
        for pin in p.pins:
            if pin.before in wire_name and pin.after in wire_name:
                before, after = wire_name[pin.before], wire_name[pin.after]
                yield ("pin", before, pin.before_end.letter, after, pin.after_end.letter)
        for i, each in enumerate(self.soft):
            yield ("soft-order-of", f"soft{i}", wire_name[each.before], wire_name[each.after])
            yield ("open", f"soft{i}")

    def costs(self) -> Iterator[Cost]:
        p = self._p
        places: list[tuple[str, Point, PlannedWire | None]] = [(START, self._arm.position_mm, None)]
        for wire in self._wires:
            for end in End:
                at = p.end_terminal(wire, end).position_mm
                places.append((f"{self._names['wire', wire.name]}-{end.letter}", at, wire))
        for place, point, _ in places:
            move = self._travel(point, self._arm.station_mm)
            yield Cost(("change-cost", place), move + p.durations.change_tool + p.weights.tool)
        yield Cost(("change-cost", STATION), p.durations.change_tool + p.weights.tool)
        for place, point, last in places:
            yield from self._picks(place, point, last)
        for last in (None, *self._wires):
            yield from self._picks(STATION, self._arm.station_mm, last)
        for wire in self._wires:
            name = self._names["wire", wire.name]
            yield Cost(("route-cost", name), wire.route_ticks)
            yield Cost(("fix-cost", name), p.fix_ticks(wire))
            for end in End:
                move = self._travel(wire.slot_mm, p.end_terminal(wire, end).position_mm)
                yield Cost(("approach", name, end.letter), move)
                yield Cost(("insert-cost", name, end.letter), p.insert_ticks(wire, end))
        yield Cost(("look-cost",), p.durations.locate)
        for i, each in enumerate(self.soft):
            yield Cost(("soft-order-weight", f"soft{i}"), each.weight)

    def _picks(self, place: str, point: Point, last: PlannedWire | None) -> Iterator[Cost]:
        """Yield what picking each wire costs from a place, after the wire picked last."""
        p = self._p
        before = last or self._last
        name = self._names["wire", last.name] if last else NOTHING
        for wire in self._wires:
            if wire is last:
                continue
            cost = self._travel(point, wire.slot_mm) + p.pick_ticks(wire)
            if wire.cable and (before is None or before.cable != wire.cable):
                cost += p.weights.cable
            if before is None:
                cost += p.weights.start * wire.zone
            else:
                cost += p.weights.colour * (wire.colour != before.colour)
                cost += p.weights.zone * max(0, before.zone - wire.zone)
            for phase in (HEAVY_ONLY, LIGHT_BEGUN):
                late = p.weights.heavy if wire.heavy and phase == LIGHT_BEGUN else 0
                yield Cost(
                    ("pick-cost", name, place, self._names["wire", wire.name], phase), cost + late
                )

    def _travel(self, origin: Point, goal: Point) -> int:
        distance = max(abs(origin[0] - goal[0]), abs(origin[1] - goal[1]))
        return -(-distance // self._p.speed_mm)


def steps_of(problem: Problem, plan: Plan, symbols: Symbols) -> list[Ground]:
    """Return a valid plan of the problem as a sequence of the symbolic actions.

    Raises:
        InstanceError: if it locates a component earlier than needed.
    """
    return list(_Steps(problem, symbols).of(plan))


class _Steps:
    def __init__(self, problem: Problem, symbols: Symbols) -> None:
        self._p = problem
        self._s = symbols
        self._place, self._last, self._phase = START, NOTHING, HEAVY_ONLY
        for fact in symbols.facts:
            if fact[0] == "now":
                self._phase = fact[1]
        self._tool = symbols.names["tool", problem.arms[0].tool]
        self._wire: PlannedWire | None = None
        self._first: End | None = None
        self._picked: set[str] = set()

    def of(self, plan: Plan) -> Iterator[Ground]:
        actions = sorted(plan.actions, key=lambda action: action.start_ticks)
        for i, action in enumerate(actions):
            if action.kind is ActionKind.CHANGE_TOOL:
                tool = self._s.names["tool", str(action.target)]
                yield ("change-tool", self._place, self._tool, tool)
                self._place, self._tool = STATION, tool
            elif action.kind is ActionKind.PICK:
                yield from self._pick(self._p.wire[str(action.wire)])
            elif action.kind is ActionKind.LOCATE:
                following = actions[i + 1] if i + 1 < len(actions) else action
                yield from self._insertion_begun(following)
                yield from self._locate(action, following)
            elif self._wire is not None:
                yield from self._hand_work(action, self._wire)

    def _pick(self, wire: PlannedWire) -> Iterator[Ground]:
        name = self._s.names["wire", wire.name]
        kind = "pick-heavy" if wire.heavy else "pick-light"
        yield (kind, name, self._tool, self._last, self._place, self._phase)
        for fact in self._s.facts:
            if fact[0] == "soft-order-of" and fact[3] == name:
                yield (
                    "keep-soft-order" if fact[2] in self._picked else "violate-soft-order",
                    *fact[1:],
                )
        yield ("take", name)
        self._picked.add(name)
        self._last, self._wire, self._first = name, wire, None
        self._phase = self._phase if wire.heavy else LIGHT_BEGUN

    def _insertion_begun(self, insertion: Action) -> Iterator[Ground]:
        if (
            insertion.kind is ActionKind.INSERT
            and insertion.end is not None
            and self._first is None
        ):
            self._first = insertion.end
            yield ("aim", self._s.names["wire", str(insertion.wire)], insertion.end.letter)

    def _locate(self, action: Action, following: Action) -> Iterator[Ground]:
        component = self._p.terminal[str(action.target)].component
        wire = self._wire
        end = following.end
        if (
            following.kind is not ActionKind.INSERT
            or end is None
            or wire is None
            or component != (self._p.end_terminal(wire, end).component)
        ):
            raise InstanceError(
                f"the plan locates component {component} earlier than needed, which its export "
                "cannot state"
            )
        symbol = self._s.names["component", component]
        yield ("locate", symbol, self._s.names["wire", wire.name], end.letter)

    def _hand_work(self, action: Action, wire: PlannedWire) -> Iterator[Ground]:
        name = self._s.names["wire", wire.name]
        if action.kind is ActionKind.INSERT and action.end is not None:
            yield from self._insertion_begun(action)
            first = self._first is action.end
            component = self._p.end_terminal(wire, action.end).component
            symbol = self._s.names["component", component]
            kind = "insert-first" if first else "insert-second"
            yield (kind, name, action.end.letter, symbol)
        elif self._first is not None and action.kind is ActionKind.ROUTE:
            yield ("route", name, self._first.letter, self._first.other.letter)
        elif self._first is not None and action.kind is ActionKind.FIX:
            end = self._first.other.letter
            self._place = f"{name}-{end}"
            yield ("fix", name, end, self._place)
