"""Check a plan: simulate its actions one by one, and test what the problem requires.

This knows the problem and the plan, and nothing of how plans are made; it shares no code with the
search. Every rule of docs/planning.md is one check here.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from remodel_tasks.core.problem.problem import (
    Action,
    ActionKind,
    End,
    Plan,
    PlannedArm,
    PlannedWire,
    Point,
    Problem,
    Ranking,
    Stage,
)


@dataclass(frozen=True)
class Verdict:
    """What a check has found.

    Attributes:
        violations: empty for a valid plan; each names the action by its place in the plan.
        durations: [ticks] of the actions; 0 of one that is impossible.
        makespan: [ticks] from the problem's start to the end of the last action.
        penalties: by the name of their weight, `soft` for violated soft constraints.
    """

    violations: tuple[str, ...]
    durations: tuple[int, ...]
    makespan: int
    penalties: dict[str, int]

    @property
    def valid(self) -> bool:
        """Whether the plan may be used."""
        return not self.violations

    @property
    def cost(self) -> int:
        """Makespan and penalties together."""
        return self.makespan + sum(self.penalties.values())


def check(problem: Problem, plan: Plan) -> Verdict:
    """Return the verdict on a plan for a sound problem."""
    simulation = _Simulation(problem)
    for index, action in enumerate(sorted(plan.actions, key=lambda a: a.start_ticks)):
        simulation.check(index, action)
    violations = [*simulation.violations, *_overlaps(simulation.uses), *_unfinished(simulation)]
    if plan.problem != problem.name:
        violations.insert(0, f"the plan is for {plan.problem}, the problem is {problem.name}")
    return Verdict(
        tuple(violations),
        tuple(simulation.durations),
        simulation.end - problem.start_ticks,
        _penalties(problem, simulation),
    )


@dataclass
class _ArmState:
    position: Point
    tool: str
    holding: str | None
    free_at: int


@dataclass
class _WireState:
    stage: Stage
    first: End | None
    jammed: End | None
    inserted_at: dict[End, int] = field(default_factory=dict)
    routed_at: int | None = None


@dataclass(frozen=True)
class _Use:
    """The time in which an arm has something that the other arm cannot have."""

    what: str
    start: int
    end: int
    arm: str
    index: int


class _RefusedError(Exception):
    """An action that is impossible here; it is reported, and has no effect."""


class _Simulation:
    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        start = problem.start_ticks
        self.arm = {a.name: a for a in problem.arms}
        self.arms = {
            a.name: _ArmState(a.position_mm, a.tool, a.holding, start) for a in problem.arms
        }
        self.wires = {w.name: _initial(w, start) for w in problem.wires}
        self.located_at = dict.fromkeys(problem.located, start)
        self.uses: list[_Use] = []
        self.picks: list[tuple[str, str]] = []  # arm, wire
        self.tool_changes = 0
        self.end = start
        self.violations: list[str] = []
        self._index = 0
        self.durations: list[int] = []
        self._unders: dict[str, list[tuple[str, str]]] = {}
        for under in problem.unders:
            required = f", as `{under.reason}` requires," if under.reason else ""
            self._unders.setdefault(under.after, []).append((under.before, required))
        self._pins: dict[tuple[str, End], list[tuple[str, End]]] = {}
        for pin in problem.pins:
            self._pins.setdefault((pin.after, pin.after_end), []).append(
                (pin.before, pin.before_end)
            )

    def check(self, index: int, action: Action) -> None:
        """Check one action, and apply its effects."""
        self._index = index
        self.durations.append(0)
        try:
            if action.arm not in self.arms:
                raise _RefusedError(f"no arm {action.arm}")
            _CHECKS[action.kind](self, action, self.arms[action.arm])
        except _RefusedError as refusal:
            self._report(str(refusal))

    def _report(self, text: str) -> None:
        self.violations.append(f"action {self._index}: {text}")

    def _require(self, condition: bool, text: str) -> None:
        if not condition:
            self._report(text)

    def _after(self, action: Action, time: int | None, what: str) -> None:
        """Require that something has happened, and before the action starts."""
        if time is None:
            self._report(f"{what} has not happened")
        elif action.start_ticks < time:
            self._report(f"starts at {action.start_ticks}, but {what} only at {time}")

    def _move(self, action: Action, arm: str, to: Point) -> None:
        """Require that an arm can be at a position when the action starts."""
        state = self.arms[arm]
        dx, dy = abs(state.position[0] - to[0]), abs(state.position[1] - to[1])
        arrival = state.free_at - (-max(dx, dy) // self.problem.speed_mm)
        if action.start_ticks < arrival:
            self._report(
                f"starts at {action.start_ticks}, but arm {arm} is there only at {arrival}"
            )

    def _work(
        self, action: Action, ticks: int, at: Point, *taken: str, to: Point | None = None
    ) -> int:
        """Bring the arm to the place of work, and let the work take its time and end `to` or there.

        Returns:
            When it ends.
        """
        arm: PlannedArm = self.arm[action.arm]
        for point in (at, to or at):
            limits = "".join(f", limited by `{name}`" for name in arm.limited_by)
            self._require(
                arm.reaches(point), f"x = {point[0]} is out of reach of arm {arm.name}{limits}"
            )
        return self._spend(action, ticks, at, *taken, to=to)

    def _spend(
        self, action: Action, ticks: int, at: Point, *taken: str, to: Point | None = None
    ) -> int:
        self._move(action, action.arm, at)
        end = action.start_ticks + ticks
        self.durations[-1] = ticks
        state = self.arms[action.arm]
        state.position, state.free_at = to or at, end
        self.end = max(self.end, end)
        for what in taken:
            self.uses.append(_Use(what, action.start_ticks, end, action.arm, index=self._index))
        return end

    def _wire(self, action: Action) -> tuple[PlannedWire, _WireState]:
        if action.wire is None or action.wire not in self.wires:
            raise _RefusedError(f"no wire {action.wire}")
        return self.problem.wire[action.wire], self.wires[action.wire]

    def _held(self, action: Action, arm: _ArmState) -> tuple[PlannedWire, _WireState]:
        wire, state = self._wire(action)
        self._require(arm.holding == wire.name, f"arm {action.arm} does not hold wire {wire.name}")
        return wire, state

    def _change_tool(self, action: Action, arm: _ArmState) -> None:
        if action.target not in self.problem.tools or action.target is None:
            raise _RefusedError(f"no tool {action.target}")
        self._require(arm.holding is None, f"arm {action.arm} holds a wire while its tool changes")
        station = self.arm[action.arm].station_mm
        self._spend(action, self.problem.durations.change_tool, station)
        arm.tool = action.target
        self.tool_changes += 1

    def _pick(self, action: Action, arm: _ArmState) -> None:
        wire, state = self._wire(action)
        self._require(arm.holding is None, f"arm {action.arm} holds wire {arm.holding} already")
        self._require(state.stage is Stage.STORED, f"wire {wire.name} is not in the magazine")
        self._require(arm.tool == wire.tool, f"wire {wire.name} needs tool {wire.tool}")
        ticks = self.problem.pick_ticks(wire)
        self._work(action, ticks, wire.slot_mm, "the magazine")
        arm.holding, state.stage = wire.name, Stage.HELD
        self.picks.append((action.arm, wire.name))

    def _locate(self, action: Action, arm: _ArmState) -> None:
        terminal = self.problem.terminal.get(action.target or "")
        if terminal is None:
            raise _RefusedError(f"no terminal {action.target}")
        at = terminal.position_mm
        taken = ("the camera", f"component {terminal.component}")
        end = self._work(action, self.problem.durations.locate, at, *taken)
        earlier = self.located_at.get(terminal.component, end)
        self.located_at[terminal.component] = min(earlier, end)

    def _insert(self, action: Action, arm: _ArmState) -> None:
        wire, state = self._held(action, arm)
        end = action.end
        if end is None or state.stage not in (Stage.HELD, Stage.ROUTED):
            raise _RefusedError(f"wire {wire.name} is {state.stage.name}, and cannot be inserted")
        self._require(state.jammed is None, f"wire {wire.name} is jammed")
        if state.stage is Stage.HELD:
            self._require(state.first in (None, end), f"wire {wire.name} starts with the other end")
        else:
            self._require(state.first is not end, f"this end of wire {wire.name} is in already")
        terminal = self.problem.end_terminal(wire, end)
        component = terminal.component
        self._after(action, self.located_at.get(component), f"locating component {component}")
        for name, other in self._pins.get((wire.name, end), ()):
            time = self.wires[name].inserted_at.get(other)
            self._after(action, time, f"inserting end {other.letter} of wire {name}")
        at = terminal.position_mm
        done = self._work(
            action, self.problem.insert_ticks(wire, end), at, f"component {component}"
        )
        state.inserted_at[end] = done
        if state.stage is Stage.HELD:
            state.stage, state.first = Stage.FIRST_IN, end
        else:
            state.stage = Stage.SECOND_IN

    def _route(self, action: Action, arm: _ArmState) -> None:
        wire, state = self._held(action, arm)
        if state.first is None or action.end is state.first:
            raise _RefusedError(f"wire {wire.name} cannot be routed to that end")
        for name, required in self._unders.get(wire.name, ()):
            self._after(action, self.wires[name].routed_at, f"routing wire {name}{required}")
        ducts = [f"duct {segment}" for segment in wire.segments]
        first = self.problem.end_terminal(wire, state.first).position_mm
        second = self.problem.end_terminal(wire, state.first.other).position_mm
        if state.stage is Stage.FIRST_IN and action.end is not None:
            state.routed_at = self._work(action, wire.route_ticks, first, *ducts, to=second)
            state.stage = Stage.ROUTED
        elif state.stage is Stage.FIRST_IN and wire.handover is not None:
            meeting = wire.handover.position_mm
            ticks = wire.handover.route_ticks[state.first]
            self._work(action, ticks, first, *ducts, to=meeting)
            state.stage = Stage.HALF
        elif state.stage is Stage.GIVEN and wire.handover and action.end is not None:
            meeting = wire.handover.position_mm
            ticks = wire.handover.route_ticks[action.end]
            state.routed_at = self._work(action, ticks, meeting, *ducts, to=second)
            state.stage = Stage.ROUTED
        else:
            raise _RefusedError(f"wire {wire.name} is {state.stage.name}, and cannot be routed so")

    def _hand_over(self, action: Action, arm: _ArmState) -> None:
        wire, state = self._held(action, arm)
        receiver = self.arms.get(action.target or "")
        if receiver is None or receiver is arm or wire.handover is None:
            raise _RefusedError(f"wire {wire.name} cannot be handed over to {action.target}")
        self._require(state.stage is Stage.HALF, f"wire {wire.name} is not at its handover point")
        self._require(receiver.holding is None, f"arm {action.target} holds a wire")
        self._require(receiver.tool == wire.tool, f"arm {action.target} lacks tool {wire.tool}")
        meeting = wire.handover.position_mm
        receiving = self.arm[str(action.target)]
        self._require(
            receiving.reaches(meeting), f"the handover is out of reach of arm {receiving.name}"
        )
        self._move(action, receiving.name, meeting)
        end = self._work(action, self.problem.durations.hand_over, meeting)
        receiver.position, receiver.free_at, receiver.holding = meeting, end, wire.name
        arm.holding, state.stage = None, Stage.GIVEN

    def _fix(self, action: Action, arm: _ArmState) -> None:
        wire, state = self._held(action, arm)
        if state.stage is not Stage.SECOND_IN or state.first is None:
            raise _RefusedError(f"wire {wire.name} is {state.stage.name}, and cannot be fixed")
        terminal = self.problem.end_terminal(wire, state.first.other)
        ticks, at = self.problem.fix_ticks(wire), terminal.position_mm
        self._work(action, ticks, at, f"component {terminal.component}")
        arm.holding, state.stage = None, Stage.FIXED

    def _extract(self, action: Action, arm: _ArmState) -> None:
        wire, state = self._held(action, arm)
        if action.end is None or state.jammed is not action.end:
            raise _RefusedError(f"that end of wire {wire.name} is not jammed")
        terminal = self.problem.end_terminal(wire, action.end)
        ticks, at = self.problem.durations.extract, terminal.position_mm
        self._work(action, ticks, at, f"component {terminal.component}")
        state.jammed = None


_CHECKS: dict[ActionKind, Callable[[_Simulation, Action, _ArmState], None]] = {
    ActionKind.CHANGE_TOOL: _Simulation._change_tool,
    ActionKind.PICK: _Simulation._pick,
    ActionKind.LOCATE: _Simulation._locate,
    ActionKind.INSERT: _Simulation._insert,
    ActionKind.ROUTE: _Simulation._route,
    ActionKind.HAND_OVER: _Simulation._hand_over,
    ActionKind.FIX: _Simulation._fix,
    ActionKind.EXTRACT: _Simulation._extract,
}


def _initial(wire: PlannedWire, start: int) -> _WireState:
    state = _WireState(wire.stage, wire.first, wire.jammed)
    if wire.stage >= Stage.FIRST_IN and wire.first is not None:
        state.inserted_at[wire.first] = start
    if wire.stage >= Stage.ROUTED:
        state.routed_at = start
    if wire.stage >= Stage.SECOND_IN:
        state.inserted_at = {End.A: start, End.B: start}
    return state


def _overlaps(uses: list[_Use]) -> Iterator[str]:
    """Find what two arms use at the same time."""
    by_name: dict[str, list[_Use]] = {}
    for use in uses:
        by_name.setdefault(use.what, []).append(use)
    for what, group in by_name.items():
        if len({use.arm for use in group}) == 1:
            continue
        latest: dict[str, _Use] = {}
        for use in sorted(group, key=lambda u: u.start):
            for arm, other in latest.items():
                if arm != use.arm and use.start < other.end and other.start < use.end:
                    yield (
                        f"action {use.index}: arm {use.arm} needs {what}, "
                        f"which arm {arm} has until {other.end}"
                    )
            if use.arm not in latest or latest[use.arm].end < use.end:
                latest[use.arm] = use


def _unfinished(simulation: _Simulation) -> Iterator[str]:
    for name, state in simulation.wires.items():
        if state.stage is not Stage.FIXED:
            yield f"end: wire {name} is {state.stage.name}, not FIXED"


def _penalties(problem: Problem, simulation: _Simulation) -> dict[str, int]:
    """Return what the picks and tool changes of a plan cost; earlier picks are paid for."""
    weights = problem.weights
    cost = dict.fromkeys(("cable", "colour", "zone", "start", "heavy", "arm", "soft"), 0)
    cost["tool"] = weights.tool * simulation.tool_changes
    last = {arm: problem.wire[wire] for wire, arm in problem.history}
    light = any(not problem.wire[wire].heavy for wire, _ in problem.history)
    begun = {problem.wire[wire].cable for wire, _ in problem.history}
    for arm, name in simulation.picks:
        wire = problem.wire[name]
        if wire.cable and (arm not in last or last[arm].cable != wire.cable):
            cost["cable"] += weights.cable if wire.cable in begun else 0
        begun.add(wire.cable)
        if arm in last:
            cost["colour"] += weights.colour if last[arm].colour != wire.colour else 0
            cost["zone"] += weights.zone * max(0, last[arm].zone - wire.zone)
        elif arm == problem.arms[0].name:
            cost["start"] += weights.start * wire.zone
        cost["heavy"] += weights.heavy if wire.heavy and light else 0
        if wire.preferred_arm not in (None, arm):
            cost["arm"] += weights.arm
        light = light or not wire.heavy
        last[arm] = wire
    place = {wire: i for i, (wire, _) in enumerate(problem.history)}
    earlier = len(problem.history)
    place.update({wire: i + len(problem.history) for i, (_, wire) in enumerate(simulation.picks)})
    for soft in problem.soft_constraints:
        if place.get(soft.after, -1) < earlier:
            continue
        if soft.before not in place or place[soft.before] > place[soft.after]:
            cost["soft"] += soft.weight
    for ranking in problem.rankings:
        cost["soft"] += ranking.weight * _against_ranks(ranking, place, earlier)
    return cost


def _against_ranks(ranking: Ranking, place: dict[str, int], earlier: int) -> int:
    """Count the pairs of which the wire of the later group is picked first.

    Args:
        ranking: of the wires.
        place: of each wire among the picks.
        earlier: picks from that place on are the plan's; pairs whose second wire was picked before
            do not change.
    """
    never = len(place)
    pairs = 0
    before: list[int] = []
    for group in ranking.groups:
        for wire in group:
            own = place.get(wire, -1)
            if own >= earlier:
                pairs += len(before) - bisect(before, own)
        before = sorted((*before, *(place.get(wire, never) for wire in group)))
    return pairs
