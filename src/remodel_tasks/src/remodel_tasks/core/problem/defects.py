"""What makes a problem impossible to plan, found before anything is planned.

Each pass returns all its findings. Later passes need what earlier ones ask for, so that the first
pass with findings is the last one.

The last thing to find is a deadlock. An arm that holds a wire can do no other before it. A wire
that the held one has to wait for must then be done by the other arm, without a handover. So held
wires, and the unfinished wires that they wait for, open the plan in a fixed order (`opening_of`).
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter

from remodel_production.errors import InfeasibleError, InstanceError
from remodel_tasks.core.problem.problem import (
    End,
    Mode,
    PlannedWire,
    Problem,
    Stage,
    directly_before,
    possible_modes,
    reached,
    wire_order,
)


def cycle_in(successors: Mapping[str, Iterable[str]]) -> list[str]:
    """Return the nodes of a cycle in their order, the first one again at the end; or nothing."""
    try:
        TopologicalSorter(successors).prepare()
    except CycleError as error:
        return list(reversed(error.args[1]))
    return []


@dataclass(frozen=True)
class Opening:
    """The wires that open every plan, in order, and the modes left to each wire."""

    wires: tuple[str, ...]
    modes: dict[str, tuple[Mode, ...]]


def opening_of(problem: Problem) -> Opening:
    """Return the opening of a problem whose order constraints have no cycle.

    Raises:
        InfeasibleError: if the arms would wait for each other.
    """
    modes = possible_modes(problem)
    holders = {arm.holding: i for i, arm in enumerate(problem.arms) if arm.holding is not None}
    before = directly_before(problem)
    graph: dict[str, set[str]] = {}
    for held, arm in holders.items():
        for wire in sorted(reached([held], before) - {held}):
            modes[wire] = tuple(mode for mode in modes[wire] if arm not in _arms(mode))
            graph.setdefault(wire, set())
        graph.setdefault(held, set())
    for wire, earlier in graph.items():
        earlier.update(before.get(wire, ()))
        earlier |= {
            held
            for held, arm in holders.items()
            if held != wire and any(arm in _arms(mode) for mode in modes[wire])
        }
    try:
        # Sorted: of wires that do not wait for each other, the order is the same in every process.
        sorter = TopologicalSorter({wire: sorted(earlier) for wire, earlier in graph.items()})
        order = tuple(sorter.static_order())
    except CycleError as error:
        raise InfeasibleError(deadlock(problem)) from error
    if not all(modes[wire] for wire in order):
        raise InfeasibleError(deadlock(problem))
    return Opening(order, modes)


def _arms(mode: Mode) -> tuple[int, ...]:
    return (0, 1) if mode.hands_over else (mode.arm,)


def deadlock(problem: Problem) -> str:
    """Return the message for a problem in which the arms would deadlock."""
    held = ", ".join(f"{arm.name} {arm.holding}" for arm in problem.arms if arm.holding)
    return (
        f"{problem.name}: no plan, since the arms would wait for each other with the wires that "
        f"they hold ({held}): take one out by hand, and plan again"
    )


_MOST_ARMS = 2
_MOST_SHOWN = 20
# Of a problem without a plan: one reason suffices.
_MOST_SHOWN_OF_NO_PLAN = 3


def require_sound(problem: Problem) -> None:
    """Return if the problem can be planned.

    Raises:
        InstanceError: with all findings, a line each.
        InfeasibleError: likewise, if it is well formed, but has no plan.
    """
    for find in _PASSES:
        found = list(find(problem))
        if found:
            kind, shown = InstanceError, _MOST_SHOWN
            if find in _NO_PLAN:
                kind, shown = InfeasibleError, _MOST_SHOWN_OF_NO_PLAN
            more = len(found) - shown
            lines = found[:shown] + ([f"and {more} more"] if more > 0 else [])
            raise kind(f"{problem.name}: " + "\n  ".join(lines))
    opening_of(problem)


def find_duplicates(problem: Problem) -> Iterator[str]:
    """Find names that stand for two things, and a count of arms that is not planned for."""
    if not 1 <= len(problem.arms) <= _MOST_ARMS:
        yield f"arms: {len(problem.arms)} found; this planner plans for one or two"
    for ranking in problem.rankings:
        for double, count in Counter(itertools.chain(*ranking.groups)).items():
            if count > 1:
                yield f"ranking {ranking.reason}: wire {double} has {count} ranks"
    for what, names in (
        ("arm", [arm.name for arm in problem.arms]),
        ("component", problem.components),
        ("terminal", [terminal.name for terminal in problem.terminals]),
        ("wire", [wire.name for wire in problem.wires]),
    ):
        for double, count in Counter(names).items():
            if count > 1:
                yield f"{what} {double}: defined {count} times; names must be unique"


def find_unknown_names(problem: Problem) -> Iterator[str]:
    """Find references to components, terminals, wires, arms and tools that are not there."""
    components, tools = set(problem.components), set(problem.tools)
    arms = {arm.name for arm in problem.arms}
    for terminal in problem.terminals:
        if terminal.component not in components:
            yield f"terminal {terminal.name}: component {terminal.component} is missing"
    for wire in problem.wires:
        for end in End:
            if wire.terminals[end] not in problem.terminal:
                yield f"wire {wire.name}, end {end.letter}: no terminal {wire.terminals[end]}"
        if wire.tool not in tools:
            yield f"wire {wire.name}: no tool {wire.tool}; there are {_listed(tools)}"
        if wire.preferred_arm is not None and wire.preferred_arm not in arms:
            yield f"wire {wire.name}: no arm {wire.preferred_arm}; there are {_listed(arms)}"
    for arm in problem.arms:
        if arm.tool not in tools:
            yield f"arm {arm.name}: no tool {arm.tool}; there are {_listed(tools)}"
        if arm.holding is not None and arm.holding not in problem.wire:
            yield f"arm {arm.name} holds wire {arm.holding}, which is not there"
    yield from _unknown_wires(problem)
    for component in sorted(problem.located - components):
        yield f"located component {component} is missing"
    for picked, by in problem.history:
        if picked not in problem.wire or by not in arms:
            yield f"history: no wire {picked} or no arm {by}"


def _unknown_wires(problem: Problem) -> Iterator[str]:
    relations = (
        *(("constraint under", under.before, under.after) for under in problem.unders),
        *(("constraint pin", pin.before, pin.after) for pin in problem.pins),
        *(("soft constraint", soft.before, soft.after) for soft in problem.soft_constraints),
    )
    for what, *pair in relations:
        for name in pair:
            if name not in problem.wire:
                yield f"{what} {' before '.join(pair)}: no wire {name}"
    for ranking in problem.rankings:
        for name in sorted(ranking.rank.keys() - problem.wire.keys()):
            yield f"ranking {ranking.reason}: no wire {name}"


def find_shared_terminals(problem: Problem) -> Iterator[str]:
    """Find terminals that two wire ends would share."""
    users: dict[str, list[str]] = {}
    for wire in problem.wires:
        for end in End:
            users.setdefault(wire.terminals[end], []).append(f"{wire.name}.{end.letter}")
    for terminal, ends in users.items():
        if len(ends) > 1:
            yield f"terminal {terminal}: used by {_listed(ends)}; a terminal takes one wire end"


def find_impossible_states(problem: Problem) -> Iterator[str]:
    """Find wires whose stage, ends and holder do not fit together."""
    holders = Counter(arm.holding for arm in problem.arms if arm.holding is not None)
    for wire in problem.wires:
        held = Stage.STORED < wire.stage < Stage.FIXED
        if holders[wire.name] != held:
            where = "one arm must hold it" if held else "no arm can hold it"
            yield f"wire {wire.name} is {_stage(wire)}, so {where}; {holders[wire.name]} do"
        if held and wire.stage > Stage.HELD and wire.first is None:
            yield f"wire {wire.name} is {_stage(wire)}: its first end must be given"
        if wire.jammed is not None:
            yield from _jam_defects(wire)
        if wire.stage in (Stage.HALF, Stage.GIVEN) and wire.handover is None:
            yield f"wire {wire.name} is {_stage(wire)}, but has no handover point"


def _jam_defects(wire: PlannedWire) -> Iterator[str]:
    if wire.stage not in (Stage.HELD, Stage.ROUTED):
        yield f"wire {wire.name} is {_stage(wire)}: no end can be jammed then"
    elif wire.stage is Stage.ROUTED and wire.jammed is wire.first:
        yield f"wire {wire.name}: its first end is in, and cannot be jammed"


def _stage(wire: PlannedWire) -> str:
    return wire.stage.name.lower().replace("_", " ")


def find_cycles(problem: Problem) -> Iterator[str]:
    """Find a cycle of wires that must each be done before the next one."""
    after: dict[str, list[str]] = {wire.name: [] for wire in problem.wires}
    for before, later in wire_order(problem):
        after[before].append(later)
    cycle = cycle_in(after)
    if cycle:
        yield "cyclic precedence: " + " before ".join(cycle) + _reasons(problem, cycle)
    own = {(pin.after, pin.after_end) for pin in problem.pins if pin.before == pin.after}
    pinned_first = Counter(wire for wire, _ in own)
    for name, count in pinned_first.items():
        if count > 1:
            yield f"cyclic precedence: the pins of wire {name} put each of its ends first"


def _reasons(problem: Problem, cycle: list[str]) -> str:
    """Return which requirement or line of the design makes each step of a cycle."""
    names = {(pin.before, pin.after): pin.source for pin in problem.pins}
    names |= {(under.before, under.after): under.source for under in problem.unders}
    names |= {(u.before, u.after): f"`{u.reason}`" for u in problem.unders if u.reason}
    steps = [
        f"{before} before {after}: {names.get((before, after)) or 'the design'}"
        for before, after in itertools.pairwise(cycle)
    ]
    return f" ({'; '.join(steps)})" if any(map(names.get, itertools.pairwise(cycle))) else ""


def find_unreachable(problem: Problem) -> Iterator[str]:
    """Find wires that no arm, and no pair of arms, can do."""
    for name, modes in possible_modes(problem).items():
        if not modes:
            wire = problem.wire[name]
            places = [("slot", wire.slot_mm)] if wire.stage is Stage.STORED else []
            places += [
                (f"terminal {terminal.name}", terminal.position_mm)
                for terminal in (problem.end_terminal(wire, end) for end in End)
            ]
            unreached = [
                f"{what} (x = {point[0]} mm)"
                for what, point in places
                if not any(arm.reaches(point) for arm in problem.arms)
            ]
            why = (
                f"{_listed(unreached)} out of every arm's reach"
                if unreached
                else "no arm reaches its slot and both terminals, and no handover is possible"
            )
            reaches = ", ".join(
                f"{a.name} "
                + ("{}..{}".format(*a.reach_mm) if a.reach_mm[0] <= a.reach_mm[1] else "none")
                for a in problem.arms
            )
            limits = ", ".join(f"`{name}`" for a in problem.arms for name in a.limited_by)
            by = f", limited by {limits}" if limits else ""
            yield f"wire {name} is unreachable: {why}; reach in x [mm]: {reaches}{by}"


def _listed(names: Iterable[str]) -> str:
    return ", ".join(sorted(names)) or "none"


_PASSES: tuple[Callable[[Problem], Iterator[str]], ...] = (
    find_duplicates,
    find_unknown_names,
    find_shared_terminals,
    find_impossible_states,
    find_cycles,
    find_unreachable,
)
# What a well-formed problem without a plan has.
_NO_PLAN = (find_cycles, find_unreachable)
