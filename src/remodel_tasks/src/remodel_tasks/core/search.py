"""What the search works on, how much it does, and what it finds.

The kernel takes the problem as arrays of integers (kernel/problem.hpp), and returns a plan in
numbers, which becomes one with names (`Planned`).

A search is a chain of rounds. Each round anneals from the best plan so far; each is longer than the
one before, up to a length beyond which another round brings more than a longer one. The work is
counted in moves: as many as were asked for, or as follow from the limit of time; a machine too slow
for those is stopped by its clock.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from math import sqrt

import numpy as np
import numpy.typing as npt

from remodel_tasks.core.problem.defects import Opening, opening_of
from remodel_tasks.core.problem.part import first_picks
from remodel_tasks.core.problem.problem import (
    Action,
    ActionKind,
    End,
    Mode,
    Plan,
    PlannedWire,
    Problem,
    Stage,
    is_inserted,
    wire_order,
)

Integers = npt.NDArray[np.int32]


@dataclass(frozen=True)
class Tables:
    """A problem in arrays, with the names that the numbers stand for.

    Attributes:
        wires: names of the unfinished wires, by number.
        scalars: single values by the kernel's names.
        arrays: arrays by the kernel's names.
        modes: those possible, by the wire's name.
        constant: what every plan pays besides what the kernel counts: for soft constraints that are
            already violated, and less for the first pick of each cable, which the kernel charges.
    """

    problem: Problem
    wires: tuple[str, ...]
    scalars: dict[str, int]
    arrays: dict[str, Integers]
    modes: dict[str, tuple[Mode, ...]]
    constant: int


def tables_of(problem: Problem) -> Tables:
    """Return the tables of a sound problem."""
    opening = opening_of(problem)
    wires = [wire for wire in problem.wires if wire.stage is not Stage.FIXED]
    number = {wire.name: i for i, wire in enumerate(wires)}
    picked = {wire for wire, _ in problem.history}
    stored = {wire.name for wire in problem.wires if wire.stage is Stage.STORED} - picked
    constraints, lost_by_pair = _open_constraints(problem, number, picked, stored)
    ranks, lost_by_rank = _open_ranks(problem, number, picked, stored)
    relations = _relations(problem, number)
    relations["soft"] = _array(constraints, 3)
    arrays = {**_wire_arrays(problem, wires, opening), **_arm_arrays(problem), **relations}
    arrays["rank"] = _array(ranks)
    arrays["rank_weight"] = _array(ranking.weight for ranking in problem.rankings)
    arrays["opening"] = _array(number[name] for name in opening.wires)
    arrays["located"] = _array([name in problem.located for name in problem.components])
    durations = problem.durations
    light = any(not problem.wire[name].heavy for name, _ in problem.history)
    scalars = {
        "wires": len(wires),
        "components": len(problem.components),
        "segments": int(arrays["segment"].max(initial=-1)) + 1,
        "arms": len(problem.arms),
        "unders": len(arrays["under"]),
        "pins": len(arrays["pin"]),
        "softs": len(constraints),
        "rankings": len(problem.rankings),
        "openings": len(opening.wires),
        "speed": problem.speed_mm,
        "locate": durations.locate,
        "change_tool": durations.change_tool,
        "extract": durations.extract,
        "hand_over": durations.hand_over,
        **{f"{name}_weight": weight for name, weight in vars(problem.weights).items()},
        "light_started": int(light),
    }
    return Tables(
        problem,
        tuple(number),
        scalars,
        arrays,
        modes=opening.modes,
        constant=lost_by_pair + lost_by_rank - first_picks(problem),
    )


def _array(rows: Iterable[object], width: int = 1) -> Integers:
    array = np.array(list(rows), dtype=np.int32)
    return array.reshape(-1, width) if width > 1 else array


def _wire_arrays(
    problem: Problem, wires: list[PlannedWire], opening: Opening
) -> dict[str, Integers]:
    component = {name: i for i, name in enumerate(problem.components)}
    tool = {name: i for i, name in enumerate(problem.tools)}
    colour = _numbering(wire.colour for wire in problem.wires)
    cable = _cables(problem)
    segment = _numbering(name for wire in wires for name in wire.segments)
    arm = {a.name: i for i, a in enumerate(problem.arms)}
    ends = [[problem.end_terminal(wire, end) for end in End] for wire in wires]
    counts = [len(wire.segments) for wire in wires]
    return {
        "slot": _array((wire.slot_mm for wire in wires), 2),
        "end_position": _array(([t.position_mm for t in pair] for pair in ends), 4),
        "end_component": _array(([component[t.component] for t in pair] for pair in ends), 2),
        "tool": _array(tool[wire.tool] for wire in wires),
        "colour": _array(colour[wire.colour] for wire in wires),
        "cable": _array(cable[wire.cable] for wire in wires),
        "zone": _array(wire.zone for wire in wires),
        "heavy": _array(wire.heavy for wire in wires),
        "pick": _array(problem.pick_ticks(wire) for wire in wires),
        "insert": _array(([problem.insert_ticks(w, end) for end in End] for w in wires), 2),
        "fix": _array(problem.fix_ticks(wire) for wire in wires),
        "route": _array(wire.route_ticks for wire in wires),
        "handover": _array((w.handover.position_mm if w.handover else (0, 0) for w in wires), 2),
        "handover_route": _array(
            (w.handover.route_ticks if w.handover else (0, 0) for w in wires), 2
        ),
        "preferred_arm": _array(
            -1 if w.preferred_arm is None else arm[w.preferred_arm] for w in wires
        ),
        "modes": _array(
            sum(1 << mode.number for mode in opening.modes[wire.name]) for wire in wires
        ),
        "stage": _array(wire.stage for wire in wires),
        "jammed": _array(-1 if wire.jammed is None else wire.jammed for wire in wires),
        "segment_start": _array(np.concatenate(([0], np.cumsum(counts, dtype=np.int64)))),
        "segment": _array(segment[name] for wire in wires for name in wire.segments),
    }


def _cables(problem: Problem) -> dict[str, int]:
    """Return the numbers of the cables; -1 for the name of none."""
    return {**_numbering(wire.cable for wire in problem.wires if wire.cable), "": -1}


def _arm_arrays(problem: Problem) -> dict[str, Integers]:
    tool = {name: i for i, name in enumerate(problem.tools)}
    colour = _numbering(wire.colour for wire in problem.wires)
    cable = _cables(problem)
    last = {arm: problem.wire[wire] for wire, arm in problem.history}
    lasts = [last.get(arm.name) for arm in problem.arms]
    return {
        "arm_position": _array((arm.position_mm for arm in problem.arms), 2),
        "arm_station": _array((arm.station_mm for arm in problem.arms), 2),
        "arm_tool": _array(tool[arm.tool] for arm in problem.arms),
        "arm_colour": _array(colour[wire.colour] if wire else -1 for wire in lasts),
        "arm_cable": _array(cable[wire.cable] if wire else -1 for wire in lasts),
        "arm_zone": _array(wire.zone if wire else 0 for wire in lasts),
    }


def _relations(problem: Problem, number: dict[str, int]) -> dict[str, Integers]:
    """Return the order constraints that are still to be satisfied."""
    ordered = set(wire_order(problem))
    unders = [
        (number[u.before], number[u.after])
        for u in problem.unders
        if (u.before, u.after) in ordered
    ]
    pins = [
        (number[p.before], p.before_end, number[p.after], p.after_end)
        for p in problem.pins
        if (p.before, p.after) in ordered and not is_inserted(problem.wire[p.before], p.before_end)
    ]
    return {"under": _array(unders, 2), "pin": _array(pins, 4)}


def _open_constraints(
    problem: Problem, number: dict[str, int], picked: set[str], stored: set[str]
) -> tuple[list[tuple[int, ...]], int]:
    """Return the soft constraints that are open, and the weight of those already violated.

    Args:
        problem: with its soft constraints.
        number: of the unfinished wires.
        picked: wires picked before the plan.
        stored: those that the plan picks.
    """
    constraints: list[tuple[int, ...]] = []
    lost = 0
    for soft in problem.soft_constraints:
        if soft.after not in stored or soft.before in picked:
            continue
        if soft.before in stored:
            constraints.append((number[soft.before], number[soft.after], soft.weight))
        else:
            lost += soft.weight
    return constraints, lost


def _open_ranks(
    problem: Problem, number: dict[str, int], picked: set[str], stored: set[str]
) -> tuple[list[list[int]], int]:
    """Return the same of rankings: of each, the ranks by wire.

    -1 stands for wires that the plan does not pick: their place among the picks is fixed.
    """
    ranks = []
    lost = 0
    for ranking in problem.rankings:
        by_wire = [ranking.rank.get(name, -1) if name in stored else -1 for name in number]
        ranks.append(by_wire)
        # Wires that are never picked come after all that are.
        never = [r for name, r in ranking.rank.items() if name not in stored | picked]
        lost += ranking.weight * sum(rank > r for r in never for rank in by_wire)
    return ranks, lost


def _numbering(names: Iterable[str]) -> dict[str, int]:
    return {name: i for i, name in enumerate(dict.fromkeys(names))}


# By the kernel's numbers (kernel/simulation.hpp).
_KINDS = (
    ActionKind.CHANGE_TOOL,
    ActionKind.PICK,
    ActionKind.LOCATE,
    ActionKind.INSERT,
    ActionKind.ROUTE,
    ActionKind.HAND_OVER,
    ActionKind.FIX,
    ActionKind.EXTRACT,
)
_HANDOVER_POINT = 2


@dataclass(frozen=True)
class Planned:
    """A list of wires with the actions that carry it out.

    The plan's objects are made when they are asked for: the search makes many lists and shows few.

    Attributes:
        order: (wires,) numbers of the wires in the list's order.
        modes: (wires,) mode number of each wire.
        actions: (n, 5) kind, arm, wire, detail, start [ticks] (kernel/simulation.hpp).
    """

    tables: Tables
    order: Integers
    modes: Integers
    actions: Integers
    makespan: int
    penalty: int

    @property
    def wires(self) -> tuple[str, ...]:
        """The wires' names in the list's order, which keeps to the problem's constraints.

        With two arms a wire may be picked before another that precedes it in the list.
        """
        return tuple(self.tables.wires[i] for i in self.order)

    @property
    def cost(self) -> int:
        """What the planner makes small."""
        return self.makespan + self.penalty

    @cached_property
    def plan(self) -> Plan:
        """The plan in names."""
        return Plan(self.tables.problem.name, tuple(map(self._action, self.actions.tolist())))

    def _action(self, row: list[int]) -> Action:
        problem = self.tables.problem
        kind, arm, wire_number, detail = _KINDS[row[0]], problem.arms[row[1]].name, row[2], row[3]
        start = row[4] + problem.start_ticks
        if kind is ActionKind.CHANGE_TOOL:
            return Action(kind, arm, start, target=problem.tools[detail])
        wire = problem.wire[self.tables.wires[wire_number]]
        if kind is ActionKind.LOCATE:
            return Action(kind, arm, start, target=wire.terminals[detail])
        if kind is ActionKind.HAND_OVER:
            return Action(kind, arm, start, wire.name, target=problem.arms[detail].name)
        if kind in (ActionKind.INSERT, ActionKind.EXTRACT):
            return Action(kind, arm, start, wire.name, end=End(detail))
        if kind is ActionKind.ROUTE:
            end = None if detail == _HANDOVER_POINT else End(detail)
            return Action(kind, arm, start, wire.name, end=end)
        return Action(kind, arm, start, wire.name)


@dataclass(frozen=True)
class Slice:
    """Some moves between two temperatures [ticks], short enough to stop after it at any time."""

    moves: int
    start_temperature: float
    end_temperature: float
    opens_round: bool


# By the number of arms, measured on random panels of 30 to 1000 wires. With two arms a wire moved
# changes a block's whole timing, and costs differ by more.
_TEMPERATURES = {
    1: ((12.0, 0.3), (25.0, 0.4), (50.0, 0.4)),
    2: ((40.0, 2.0), (15.0, 1.0), (25.0, 1.0)),
}
_SHORTEST_ROUND_PER_WIRE = {1: 1_000, 2: 100}
_LONGEST_ROUND_PER_PAIR = 200
# Beyond these a search has found what it will find.
_MOST_MOVES_PER_WIRE = {1: 500_000, 2: 50_000}
_GROWTH = 4
_SLICE_S = 0.02
# Of a search by moves, so that a signal can stop it.
_SLICES = 200
# Of a short search, so that the clock can stop it in time.
_LEAST_SLICES = 10


def first_slice(wires: int, arms: int) -> Slice:
    """Return the moves that improve the first plan before it is shown.

    They take some times as long as its construction, and bring it from 30 % to below 13 % above the
    best known cost with two arms, below 1.2 % with one (benchmarks/planner). With two arms, panels
    of some tens of wires vary most, and get more moves for each wire than larger ones.
    """
    if arms == 1:
        return Slice(100 * wires, 1.0, 0.5, True)
    return Slice(min(10 * wires + min(15 * wires, 360), 5000), 1.0, 0.5, True)


def moves_per_second(wires: int, arms: int) -> float:
    """Return the moves that a search is given for a second.

    About 40 % of what one core of an AMD EPYC of 2024 makes with one arm, 75 % with two.
    """
    if arms == 1:
        return 9e6 / (1 + wires / 1500)
    return 1.3e6 / (1.0 + 0.4 * sqrt(wires))


def slices(wires: int, arms: int, limit_s: float) -> Iterator[Slice]:
    """Yield the slices of a search of that length [s], the next round's after the last one's."""
    allotted = int(limit_s * moves_per_second(wires, arms))
    slice_s = min(_SLICE_S, limit_s / _LEAST_SLICES)
    slice_moves = max(1, int(slice_s * moves_per_second(wires, arms)))
    yield from _rounds(wires, arms, min(allotted, _MOST_MOVES_PER_WIRE[arms] * wires), slice_moves)


def slices_of(wires: int, arms: int, moves: int) -> Iterator[Slice]:
    """Yield the slices of a search of so many moves, which are the same on any machine."""
    yield from _rounds(wires, arms, moves, max(1, moves // _SLICES))


def _rounds(wires: int, arms: int, left: int, slice_moves: int) -> Iterator[Slice]:
    if wires < 2:
        return
    longest = _LONGEST_ROUND_PER_PAIR * wires * wires
    length = min(max(_SHORTEST_ROUND_PER_WIRE[arms] * wires, left // _GROWTH**3), longest)
    turn = 0
    while left > 0:
        # A rest too short for a round of its own lengthens this one.
        length = left if left < length * (1 + 1 / _GROWTH) else length
        start, end = _TEMPERATURES[arms][turn % len(_TEMPERATURES[arms])]
        yield from _round(length, slice_moves, start, end)
        left -= length
        length = min(length * _GROWTH, longest)
        turn += 1


def _round(moves: int, slice_moves: int, start: float, end: float) -> Iterator[Slice]:
    count = max(1, moves // slice_moves)
    ratio = (end / start) ** (1 / count)
    done = 0
    for i in range(count):
        upto = moves * (i + 1) // count
        yield Slice(upto - done, start * ratio**i, start * ratio ** (i + 1), i == 0)
        done = upto
