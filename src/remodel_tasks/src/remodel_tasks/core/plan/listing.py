"""The list of wires behind a plan, and lists that differ from it in one place."""

from __future__ import annotations

from dataclasses import dataclass

from remodel_tasks.core.problem.modes import Mode
from remodel_tasks.core.problem.order import wire_order
from remodel_tasks.core.problem.problem import ActionKind, End, Plan, Problem


@dataclass(frozen=True)
class Listing:
    """Unfinished wires in the order of their picks, held ones first, and how each is done."""

    wires: tuple[str, ...]
    modes: dict[str, Mode]

    def with_mode(self, wire: str, mode: Mode) -> Listing:
        """Return the list with a wire done in another mode."""
        return Listing(self.wires, {**self.modes, wire: mode})

    def with_first_before(self, problem: Problem, first: str, second: str) -> Listing:
        """Return the list with a wire, and all that must come before it, right before another."""
        before: dict[str, list[str]] = {}
        for earlier, later in wire_order(problem):
            before.setdefault(later, []).append(earlier)
        moved, frontier = {first}, [first]
        while frontier:
            for wire in before.get(frontier.pop(), ()):
                if wire not in moved:
                    moved.add(wire)
                    frontier.append(wire)
        at = self.wires.index(second)
        late = [wire for wire in self.wires[at:] if wire in moved]
        rest = [wire for wire in self.wires[at:] if wire not in moved]
        return Listing((*self.wires[:at], *late, *rest), self.modes)


def listing_of(problem: Problem, plan: Plan) -> Listing:
    """Return the list of a valid plan."""
    number = {arm.name: i for i, arm in enumerate(problem.arms)}
    arms = {arm.holding: number[arm.name] for arm in problem.arms if arm.holding is not None}
    firsts = {wire.name: wire.first for wire in problem.wires if wire.first is not None}
    handed = set()
    for action in plan.actions:
        name = str(action.wire)
        if action.kind is ActionKind.PICK:
            arms[name] = number[action.arm]
        elif action.kind is ActionKind.INSERT and action.end is not None:
            firsts.setdefault(name, action.end)
        elif action.kind is ActionKind.HAND_OVER:
            handed.add(name)
    wires = tuple(arms)
    modes = {name: Mode(arms[name], End(firsts[name]), name in handed) for name in wires}
    return Listing(wires, modes)
