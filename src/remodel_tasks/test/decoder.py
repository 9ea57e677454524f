"""The plain reference of the kernel's simulation: what the arms do with a list of wires.

An arm does the wires that their modes give it, in the list's order. Whichever arm can start its
next action first, starts it; a tie goes to the first arm. An arm locates a component just before
the first insertion there. The kernel (kernel/simulation.cpp) does the same in blocks; a test holds
the two equal on random problems and lists. This one is written to be read.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from remodel_tasks.core.problem.problem import (
    Action,
    ActionKind,
    End,
    Mode,
    PlannedWire,
    Point,
    Problem,
    Stage,
)


@dataclass(frozen=True)
class Step:
    """An action before it has a start.

    Attributes:
        excludes: what no two arms may have at the same time.
        awaits: facts that must hold before: ("in", wire, end), ("routed", wire), ("at", component),
            ("given", wire).
        gives: the fact that holds from the end on.
    """

    kind: ActionKind
    ticks: int
    origin: Point
    goal: Point
    wire: PlannedWire
    end: End | None = None
    excludes: frozenset[str] = frozenset()
    awaits: tuple[tuple[object, ...], ...] = ()
    gives: tuple[object, ...] | None = None


@dataclass
class _ArmRun:
    position: Point
    tool: str
    steps: Iterator[Step]
    free: int = 0
    step: Step | None = None
    floor: int = 0
    last: tuple[Step, int] | None = None


@dataclass
class _World:
    problem: Problem
    arms: list[_ArmRun]
    facts: dict[tuple[object, ...], int] = field(default_factory=dict)


def decode(problem: Problem, wires: Sequence[PlannedWire], modes: dict[str, Mode]) -> list[Action]:
    """Return the actions that carry out a list of the unfinished wires, by their starts.

    Returns fewer actions than the wires need where the arms would wait for each other.
    """
    world = _World(problem, [])
    world.facts.update(_facts_at_start(problem))
    for index, arm in enumerate(problem.arms):
        steps = _steps(world, index, wires, modes)
        world.arms.append(_ArmRun(arm.position_mm, arm.tool, steps))
    actions: list[Action] = []
    for run in world.arms:
        run.step = next(run.steps, None)
    while True:
        starts = [_earliest(world, index) for index in range(len(world.arms))]
        possible = [start for start in starts if start is not None]
        if not possible:
            return actions
        index = starts.index(min(possible))
        actions.append(_begin(world, index, min(possible)))


def _facts_at_start(problem: Problem) -> Iterator[tuple[tuple[object, ...], int]]:
    for component in problem.located:
        yield ("at", component), 0
    for wire in problem.wires:
        if wire.stage >= Stage.ROUTED:
            yield ("routed", wire.name), 0
        for end in End:
            if wire.stage >= Stage.SECOND_IN or (
                wire.stage >= Stage.FIRST_IN and wire.first is end
            ):
                yield ("in", wire.name, end), 0


def _steps(
    world: _World, index: int, wires: Sequence[PlannedWire], modes: dict[str, Mode]
) -> Iterator[Step]:
    """Yield what an arm does, each step once the ones before have been begun."""
    for wire in wires:
        mode = modes[wire.name]
        if mode.arm == index:
            yield from _first_part(world, index, wire, mode)
            if not mode.hands_over:
                yield from _second_part(world, wire, mode)
        elif mode.hands_over:
            yield from _tool(world, index, wire)
            yield _handover(world, wire, ActionKind.HAND_OVER, receives=True)
            yield from _second_part(world, wire, mode)


def _tool(world: _World, index: int, wire: PlannedWire) -> Iterator[Step]:
    if world.arms[index].tool != wire.tool:
        station = world.problem.arms[index].station_mm
        ticks = world.problem.durations.change_tool
        yield Step(ActionKind.CHANGE_TOOL, ticks, station, station, wire=wire)


def _first_part(world: _World, index: int, wire: PlannedWire, mode: Mode) -> Iterator[Step]:
    durations = world.problem.durations
    if wire.stage is Stage.STORED:
        yield from _tool(world, index, wire)
        slot = wire.slot_mm
        ticks = world.problem.pick_ticks(wire)
        yield Step(ActionKind.PICK, ticks, slot, slot, wire=wire, excludes=frozenset({"magazine"}))
    if wire.stage is Stage.HELD and wire.jammed is not None:
        yield _at_terminal(world, wire, wire.jammed, ActionKind.EXTRACT, ticks=durations.extract)
    if wire.stage <= Stage.HELD:
        yield from _insertion(world, wire, mode.first)
    if mode.hands_over:
        if wire.stage <= Stage.FIRST_IN:
            yield _routing(world, wire, mode.first, to_handover=True)
        yield _handover(world, wire, ActionKind.HAND_OVER, receives=False)


def _second_part(world: _World, wire: PlannedWire, mode: Mode) -> Iterator[Step]:
    durations, second = world.problem.durations, mode.first.other
    if mode.hands_over or wire.stage <= Stage.GIVEN:
        yield _routing(world, wire, mode.first, given=mode.hands_over or wire.stage is Stage.GIVEN)
    if wire.stage is Stage.ROUTED and wire.jammed is not None:
        yield _at_terminal(world, wire, second, ActionKind.EXTRACT, ticks=durations.extract)
    if wire.stage <= Stage.ROUTED:
        yield from _insertion(world, wire, second)
    yield _at_terminal(world, wire, second, ActionKind.FIX, ticks=world.problem.fix_ticks(wire))


def _insertion(world: _World, wire: PlannedWire, end: End) -> Iterator[Step]:
    component = world.problem.end_terminal(wire, end).component
    located = ("at", component)
    if located not in world.facts:
        ticks = world.problem.durations.locate
        yield _at_terminal(world, wire, end, ActionKind.LOCATE, ticks=ticks, gives=located)
    before = tuple(
        ("in", pin.before, pin.before_end)
        for pin in world.problem.pins
        if (pin.after, pin.after_end) == (wire.name, end)
    )
    fact = ("in", wire.name, end)
    ticks = world.problem.insert_ticks(wire, end)
    yield _at_terminal(
        world, wire, end, ActionKind.INSERT, ticks=ticks, awaits=(located, *before), gives=fact
    )


def _at_terminal(
    world: _World,
    wire: PlannedWire,
    end: End,
    kind: ActionKind,
    ticks: int,
    awaits: tuple[tuple[object, ...], ...] = (),
    gives: tuple[object, ...] | None = None,
) -> Step:
    terminal = world.problem.end_terminal(wire, end)
    excludes = {f"component {terminal.component}"}
    if kind is ActionKind.LOCATE:
        excludes.add("camera")
    at = terminal.position_mm
    return Step(
        kind,
        ticks,
        at,
        at,
        wire=wire,
        end=end,
        excludes=frozenset(excludes),
        awaits=awaits,
        gives=gives,
    )


def _routing(
    world: _World, wire: PlannedWire, first: End, *, to_handover: bool = False, given: bool = False
) -> Step:
    at_first = world.problem.end_terminal(wire, first).position_mm
    at_second = world.problem.end_terminal(wire, first.other).position_mm
    ticks, origin, goal = wire.route_ticks, at_first, at_second
    if wire.handover and to_handover:
        ticks, goal = wire.handover.route_ticks[first], wire.handover.position_mm
    elif wire.handover and given:
        ticks, origin = wire.handover.route_ticks[first.other], wire.handover.position_mm
    return Step(
        ActionKind.ROUTE,
        ticks,
        origin,
        goal,
        wire=wire,
        end=None if to_handover else first.other,
        excludes=frozenset(f"duct {segment}" for segment in wire.segments),
        awaits=tuple(("routed", u.before) for u in world.problem.unders if u.after == wire.name),
        gives=None if to_handover else ("routed", wire.name),
    )


def _handover(world: _World, wire: PlannedWire, kind: ActionKind, *, receives: bool) -> Step:
    assert wire.handover is not None
    meeting = wire.handover.position_mm
    # The giver begins for both; the receiver only stands ready.
    awaits = (("never",),) if receives else ()
    return Step(kind, world.problem.durations.hand_over, meeting, meeting, wire=wire, awaits=awaits)


def _travel(problem: Problem, origin: Point, goal: Point) -> int:
    distance = max(abs(origin[0] - goal[0]), abs(origin[1] - goal[1]))
    return -(-distance // problem.speed_mm)


def _arrival(world: _World, run: _ArmRun) -> int:
    assert run.step is not None
    return run.free + _travel(world.problem, run.position, run.step.origin)


def _earliest(world: _World, index: int) -> int | None:
    """Return when an arm can start its next step, as far as the steps begun show; None: not yet."""
    run = world.arms[index]
    if run.step is None:
        return None
    if run.step.kind is ActionKind.LOCATE and run.step.gives in world.facts:
        run.step, run.floor = next(run.steps), 0
    step = run.step
    if any(fact not in world.facts for fact in step.awaits):
        return None
    start = max([_arrival(world, run), run.floor, *(world.facts[fact] for fact in step.awaits)])
    for other in world.arms:
        if other is run:
            continue
        if step.kind is ActionKind.HAND_OVER:
            met = other.step
            if met is None or met.kind is not step.kind or met.wire is not step.wire:
                return None
            start = max(start, _arrival(world, other))
        if other.last and other.last[0].excludes & step.excludes:
            start = max(start, other.last[1])
    # The other arm's next step may hide the one that excludes this step.
    run.floor = start
    return start


def _begin(world: _World, index: int, start: int) -> Action:
    run, problem = world.arms[index], world.problem
    step = run.step
    assert step is not None
    end = start + step.ticks
    others = [arm for arm in world.arms if arm is not run]
    taking_part = [run, *others] if step.kind is ActionKind.HAND_OVER else [run]
    if step.kind is ActionKind.CHANGE_TOOL:
        run.tool = step.wire.tool
    if step.gives is not None:
        world.facts[step.gives] = end
    for arm in taking_part:
        arm.free, arm.position, arm.last, arm.floor = end, step.goal, (step, end), 0
    for arm in taking_part:
        arm.step = next(arm.steps, None)
    in_hand = step.kind not in (ActionKind.CHANGE_TOOL, ActionKind.LOCATE)
    with_end = step.kind in (ActionKind.INSERT, ActionKind.EXTRACT, ActionKind.ROUTE)
    return Action(
        step.kind,
        problem.arms[index].name,
        start + problem.start_ticks,
        step.wire.name if in_hand else None,
        end=step.end if with_end else None,
        target=_target(problem, index, step),
    )


def _target(problem: Problem, index: int, step: Step) -> str | None:
    if step.kind is ActionKind.CHANGE_TOOL:
        return step.wire.tool
    if step.kind is ActionKind.HAND_OVER:
        return problem.arms[1 - index].name
    if step.kind is ActionKind.LOCATE and step.end is not None:
        return step.wire.terminals[step.end]
    return None
