"""Explain a plan: what it costs, what it violates, and what the alternatives would cost.

For each soft constraint that the plan violates, the plan is simulated again with the one wire moved
right before the other, or done by the preferred arm: the extra cost is the reason for the
violation. Where the order constraints forbid to satisfy it, these are listed. The order is
explained by the costs of exchanging two neighbours.
"""

from __future__ import annotations

import itertools
from bisect import bisect_right, insort
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from remodel_tasks.core.plan.checker import Verdict
from remodel_tasks.core.problem.preferences import Preferred
from remodel_tasks.core.problem.problem import (
    TICKS_PER_S,
    ActionKind,
    End,
    Mode,
    Plan,
    Problem,
    Ranking,
    SoftConstraint,
    directly_before,
    grouped,
    possible_modes,
    reached,
    wire_order,
)


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
        moved = reached([first], directly_before(problem))
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


# Of one preference, so many violated pairs are listed one by one; of all exchanges, the nearest.
_LISTED = 3
# Exchanges are simulated one by one; of a large panel, those of the first wires.
_EXAMINED = 200
_PENALTIES = {
    "tool": "changes of tool",
    "heavy": "heavy wires picked after a light one",
    "cable": "times that a cable is taken up again",
    "colour": "changes of colour",
    "zone": "zones gone back to the left",
    "start": "zones between the left and the first wire",
    "arm": "wires picked by another arm than preferred",
}


class Alternatives(Protocol):
    """Simulates a plan with a change, and returns what it costs more in all."""

    def picked_before(self, first: str, second: str) -> int:
        """Return the difference if a wire is picked right before another one."""

    def done_by(self, wire: str, arm: str) -> int | None:
        """Return the least difference if an arm picks a wire; None if it cannot."""


@dataclass(frozen=True)
class Violation:
    """A soft constraint that a plan violates.

    Attributes:
        places: of the two wires among the picks, from 1.
    """

    soft: SoftConstraint
    places: tuple[int, int]


def violations(problem: Problem, plan: Plan) -> Iterator[Violation]:
    """Yield the soft constraints that a valid plan violates."""
    picks = [str(action.wire) for action in plan.actions if action.kind is ActionKind.PICK]
    place = {wire: i for i, wire in enumerate(picks, 1)}
    ranked = (soft for ranking in problem.rankings for soft in _against_ranks(ranking, picks))
    for soft in itertools.chain(problem.soft_constraints, ranked):
        places = place.get(soft.before), place.get(soft.after)
        if places[0] is not None and places[1] is not None and places[0] > places[1]:
            yield Violation(soft, (places[0], places[1]))


def violated_constraints(problem: Problem, plan: Plan) -> tuple[Violation, ...]:
    """Return the soft constraints that a valid plan violates, the most expensive first."""
    return tuple(sorted(violations(problem, plan), key=lambda item: -item.soft.weight))


def _against_ranks(ranking: Ranking, picks: list[str]) -> Iterator[SoftConstraint]:
    """Yield the pairs that the picks violate, of each wire those of the nearest rank first."""
    groups: dict[int, list[str]] = {}
    ranks: list[int] = []  # of the groups, in order
    for wire in picks:
        rank = ranking.rank.get(wire)
        if rank is None:
            continue
        for later in ranks[bisect_right(ranks, rank) :]:
            for picked in reversed(groups[later]):
                yield SoftConstraint(wire, picked, ranking.weight, ranking.reason)
        if rank not in groups:
            insort(ranks, rank)
        groups.setdefault(rank, []).append(wire)


def explain(
    preferred: Preferred, plan: Plan, verdict: Verdict, alternatives: Alternatives
) -> Iterator[str]:
    """Yield the explanation of a valid plan, line by line."""
    problem = preferred.problem
    yield (
        f"{problem.name}: cost {verdict.cost} = makespan {verdict.makespan} "
        f"({verdict.makespan / TICKS_PER_S:.1f} s) + penalties {sum(verdict.penalties.values())}"
    )
    weights = vars(problem.weights)
    for name, what in _PENALTIES.items():
        paid = verdict.penalties[name]
        if paid:
            yield f"  {paid}: {paid // weights[name]} {what}, {weights[name]} each"
    if verdict.penalties["soft"]:
        yield f"  {verdict.penalties['soft']}: soft constraints violated, of {_count(problem)}"
    yield from _explain_order(problem, plan, alternatives)
    by_detour = grouped((reason, wire) for wire, reason in preferred.detours.items())
    for reason, wires in by_detour.items():
        yield f"kept: `{reason}`: {', '.join(wires)} done by another method or route"
    yield from _explain_arms(preferred, plan, alternatives)
    after = grouped(wire_order(problem))
    by_reason = sorted(violated_constraints(problem, plan), key=lambda item: item.soft.reason)
    for reason, group in itertools.groupby(by_reason, lambda item: item.soft.reason):
        yield from _explain_group(reason, list(group), problem, after, alternatives=alternatives)


def _count(problem: Problem, reason: str | None = None) -> int:
    """Return the number of soft constraints; of those with one reason, if it is given."""
    return sum(reason in (None, soft.reason) for soft in problem.soft_constraints) + sum(
        ranking.pairs for ranking in problem.rankings if reason in (None, ranking.reason)
    )


def _explain_order(problem: Problem, plan: Plan, alternatives: Alternatives) -> Iterator[str]:
    """Yield the order of the picks, and what the nearest other orders would cost."""
    picks = [str(action.wire) for action in plan.actions if action.kind is ActionKind.PICK]
    yield f"order: {' '.join(picks)}"
    neighbours = list(itertools.pairwise(picks))[:_EXAMINED]
    bound = set(wire_order(problem))
    free = [pair for pair in neighbours if pair not in bound]
    if not free:
        return
    costs = sorted(
        (alternatives.picked_before(later, earlier), later, earlier) for earlier, later in free
    )
    yield (
        f"of {len(neighbours)} neighbours in it, order constraints hold "
        f"{len(neighbours) - len(free)}; the nearest exchanges of others:"
    )
    for difference, later, earlier in costs[:_LISTED]:
        yield _compare(f"{later} right before {earlier}", difference)


def against_arms(preferred: Preferred, plan: Plan) -> dict[str, list[str]]:
    """Return the wires that another arm picks than the user prefers, by the preference's name."""
    wires, reasons = preferred.problem.wire, preferred.arm_reasons
    picks = ((str(a.wire), a.arm) for a in plan.actions if a.kind is ActionKind.PICK)
    return grouped(
        (reasons[name], name)
        for name, arm in picks
        if name in reasons and wires[name].preferred_arm not in (None, arm)
    )


def _explain_arms(preferred: Preferred, plan: Plan, alternatives: Alternatives) -> Iterator[str]:
    """Yield which of the user's preferences for an arm the plan violates."""
    problem = preferred.problem
    index = {arm.name: i for i, arm in enumerate(problem.arms)}
    modes = possible_modes(problem)
    for reason, names in against_arms(preferred, plan).items():
        arms = {name: str(problem.wire[name].preferred_arm) for name in names}
        able = [n for n in names if any(mode.arm == index[arms[n]] for mode in modes[n])]
        yield (
            f"violated, costs {len(names) * problem.weights.arm}: `{reason}`: another arm picks "
            f"{', '.join(names)}; {len(names) - len(able)} of {len(names)} are out of its "
            "reach"
        )
        for name in able[:_LISTED]:
            yield _compare(f"{name} by {arms[name]}", alternatives.done_by(name, arms[name]))


def _explain_group(
    reason: str,
    group: list[Violation],
    problem: Problem,
    after: dict[str, list[str]],
    alternatives: Alternatives,
) -> Iterator[str]:
    """Yield the violated pairs of one preference; those of the design one by one."""
    listed = group if not reason else group[:_LISTED]
    if len(listed) < len(group):
        pairs = _count(problem, reason)
        paid = sum(item.soft.weight for item in group)
        yield f"violated, costs {paid}: `{reason}`: {len(group)} of {pairs} pairs, such as"
    for item in listed:
        lines = _explain_pair(item, after, alternatives)
        yield from lines if listed == group else (f"  {line}" for line in lines)


def _explain_pair(
    item: Violation, after: dict[str, list[str]], alternatives: Alternatives
) -> Iterator[str]:
    soft = item.soft
    title = f"`{soft.reason}`: " if soft.reason else ""
    yield (
        f"violated, costs {soft.weight}: {title}{soft.before} should be picked before "
        f"{soft.after}, but they are numbers {item.places[0]} and {item.places[1]}"
    )
    chain = _chain(after, soft.after, soft.before)
    if chain:
        yield f"    cannot be kept: {' must come before '.join(chain)}"
    else:
        difference = alternatives.picked_before(soft.before, soft.after)
        yield _compare(f"{soft.before} right before {soft.after}", difference)


def _compare(change: str, difference: int | None) -> str:
    if difference is None:
        return f"    rejected: {change} would deadlock the arms"
    if difference == 0:
        return f"    as good: {change} costs the same in all"
    if difference > 0:
        return f"    rejected: {change} would cost {difference} more in all"
    return f"    not found: {change} would save {-difference}; a longer search may find it"


def _chain(after: dict[str, list[str]], start: str, goal: str) -> tuple[str, ...]:
    """Return the shortest chain of order constraints from one wire to another, if there is one."""
    previous = {start: ""}
    frontier = [start]
    while frontier and goal not in previous:
        following = []
        for wire in frontier:
            for later in after.get(wire, ()):
                if later not in previous:
                    previous[later] = wire
                    following.append(later)
        frontier = following
    if goal not in previous:
        return ()
    chain = [goal]
    while chain[-1] != start:
        chain.append(previous[chain[-1]])
    return tuple(reversed(chain))
