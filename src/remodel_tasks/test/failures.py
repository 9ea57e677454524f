"""Failures: the problem that is left when part of a plan has been executed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from remodel_tasks.core.problem.problem import (
    Action,
    ActionKind,
    End,
    Handover,
    Plan,
    PlannedArm,
    PlannedWire,
    Point,
    Problem,
    Stage,
)
from remodel_tasks.core.search import Integers, Planned, Tables

# How much longer a wire's route becomes when its terminal is moved [mm/tick]: the speed of routing.
_ROUTE_MM_PER_TICK = 10


def after_jam(problem: Problem, plan: Plan, index: int) -> Problem:
    """Return what is left when an insertion has failed: its end is jammed, its component lost.

    What the other arm began before the failure is finished first. The index is that of the failing
    insertion among the plan's actions.
    """
    failing = plan.actions[index]
    wire = problem.wire[str(failing.wire)]
    end = End(failing.end or 0)
    until = failing.start_ticks + problem.insert_ticks(wire, end)
    left = _executed(problem, _begun(plan, index, until), at_least=until)
    component = problem.end_terminal(wire, end).component
    wires = tuple(replace(w, jammed=end) if w.name == wire.name else w for w in left.wires)
    at = problem.end_terminal(wire, end).position_mm
    arms = tuple(replace(a, position_mm=at) if a.name == failing.arm else a for a in left.arms)
    return replace(left, wires=wires, arms=arms, located=left.located - {component})


def after_move(
    problem: Problem, plan: Plan, index: int, component: str, shift_mm: Point
) -> Problem:
    """Return what is left when, before an action, a component is found at another place.

    Its terminals move, it must be located again, and the wires in the magazine that end there get
    longer routes.
    """
    left = _executed(problem, _begun(plan, index, plan.actions[index].start_ticks))
    longer = -(-(abs(shift_mm[0]) + abs(shift_mm[1])) // _ROUTE_MM_PER_TICK)
    wires = tuple(
        _lengthened(left, wire, component, longer) if wire.stage is Stage.STORED else wire
        for wire in left.wires
    )
    terminals = tuple(
        replace(t, position_mm=(t.position_mm[0] + shift_mm[0], t.position_mm[1] + shift_mm[1]))
        if t.component == component
        else t
        for t in left.terminals
    )
    return replace(left, wires=wires, terminals=terminals, located=left.located - {component})


def remaining_order(old: Planned, tables: Tables) -> tuple[Integers, Integers]:
    """Return an old plan's order and modes in the numbers of a problem that follows from it."""
    number = {name: i for i, name in enumerate(tables.wires)}
    names = [old.tables.wires[i] for i in old.order]
    order = np.array([number[name] for name in names if name in number], np.int32)
    modes = np.full(len(tables.wires), -1, np.int32)
    for name, mode in zip(old.tables.wires, old.modes.tolist(), strict=True):
        if name in number:
            modes[number[name]] = mode
    return order, modes


def _begun(plan: Plan, index: int, until: int) -> list[Action]:
    """Return the actions begun before a time, without what the failing arm had still to do."""
    failing = plan.actions[index]
    return [
        action
        for i, action in enumerate(plan.actions)
        if i != index
        and action.start_ticks < until
        and not (i > index and failing.arm in (action.arm, action.target))
    ]


def _lengthened(problem: Problem, wire: PlannedWire, component: str, ticks: int) -> PlannedWire:
    there = [problem.end_terminal(wire, end).component == component for end in End]
    route = wire.route_ticks + ticks * sum(there)
    if wire.handover is None:
        return replace(wire, route_ticks=route)
    a, b = (
        part + ticks * is_there
        for part, is_there in zip(wire.handover.route_ticks, there, strict=True)
    )
    return replace(wire, route_ticks=route, handover=Handover(wire.handover.position_mm, (a, b)))


@dataclass
class _State:
    arms: dict[str, PlannedArm]
    wires: dict[str, PlannedWire]
    located: set[str]
    history: list[tuple[str, str]]


def _state_at_start(problem: Problem) -> _State:
    return _State(
        {arm.name: arm for arm in problem.arms},
        dict(problem.wire),
        set(problem.located),
        list(problem.history),
    )


def _executed(problem: Problem, actions: Sequence[Action], at_least: int = 0) -> Problem:
    """Return the problem as it is when some of a valid plan's actions have ended."""
    state = _state_at_start(problem)
    now = max(problem.start_ticks, at_least)
    for action in actions:
        now = max(now, action.start_ticks + _execute(problem, state, action))
    return replace(
        problem,
        arms=tuple(state.arms.values()),
        wires=tuple(state.wires.values()),
        located=frozenset(state.located),
        history=tuple(state.history),
        start_ticks=now,
    )


def _execute(problem: Problem, state: _State, action: Action) -> int:
    """Apply an action's effects, and return its duration [ticks]."""
    durations = problem.durations
    arm = state.arms[action.arm]
    if action.kind is ActionKind.CHANGE_TOOL:
        station, tool = arm.station_mm, str(action.target)
        state.arms[arm.name] = replace(arm, tool=tool, position_mm=station)
        return durations.change_tool
    if action.kind is ActionKind.LOCATE:
        terminal = problem.terminal[str(action.target)]
        state.located.add(terminal.component)
        state.arms[arm.name] = replace(arm, position_mm=terminal.position_mm)
        return durations.locate
    wire = state.wires[str(action.wire)]
    ticks, position, holding = problem.pick_ticks(wire), wire.slot_mm, arm.holding
    if action.kind is ActionKind.PICK:
        holding = wire.name
        wire = replace(wire, stage=Stage.HELD)
        state.history.append((wire.name, arm.name))
    elif action.kind is ActionKind.HAND_OVER and wire.handover is not None:
        ticks, position, holding = durations.hand_over, wire.handover.position_mm, None
        receiver = state.arms[str(action.target)]
        state.arms[receiver.name] = replace(receiver, position_mm=position, holding=wire.name)
        wire = replace(wire, stage=Stage.GIVEN)
    elif action.kind is ActionKind.ROUTE and action.end is None and wire.handover is not None:
        ticks, position = wire.handover.route_ticks[End(wire.first or 0)], wire.handover.position_mm
        wire = replace(wire, stage=Stage.HALF)
    else:
        end = action.end if action.end is not None else End(wire.first or 0).other
        position = problem.end_terminal(wire, end).position_mm
        if action.kind is ActionKind.INSERT:
            ticks = problem.insert_ticks(wire, end)
            is_first = wire.stage is Stage.HELD
            wire = replace(wire, first=end, stage=Stage.FIRST_IN) if is_first else wire
            wire = wire if is_first else replace(wire, stage=Stage.SECOND_IN)
        elif action.kind is ActionKind.ROUTE:
            given = wire.stage is Stage.GIVEN and wire.handover is not None
            ticks = wire.handover.route_ticks[end] if given and wire.handover else wire.route_ticks
            wire = replace(wire, stage=Stage.ROUTED)
        elif action.kind is ActionKind.EXTRACT:
            ticks, wire = durations.extract, replace(wire, jammed=None)
        else:
            ticks, holding = problem.fix_ticks(wire), None
            wire = replace(wire, stage=Stage.FIXED)
    state.wires[wire.name] = wire
    state.arms[arm.name] = replace(arm, position_mm=position, holding=holding)
    return ticks
