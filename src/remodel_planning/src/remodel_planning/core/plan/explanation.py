"""Why a plan is as it is, in words: what it costs, what it breaks, and what mending would cost.

For each wish that the plan breaks, the plan is simulated again with the one wire moved right before
the other, or done by the arm that was asked for: what it costs more is the reason for which the
wish was not kept. A wish that the order constraints forbid is told with the constraints. So is the
order: by what exchanging two neighbours would cost.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from remodel_planning.core.plan.checker import Verdict
from remodel_planning.core.problem.modes import possible_modes
from remodel_planning.core.problem.order import wire_order
from remodel_planning.core.problem.preferences import Preferred
from remodel_planning.core.problem.problem import ActionKind, Plan, Problem, Ranking, Wish

_TICKS_PER_S = 10
# Of one preference, so many broken pairs are told one by one; of all exchanges, the nearest ones.
_TOLD = 3
# Exchanges are simulated one by one; of a large panel, those of the first wires.
_EXAMINED = 200
_PENALTIES = {
    "tool": "changes of tool",
    "heavy": "heavy wires picked after a light one",
    "colour": "changes of colour",
    "zone": "zones gone back to the left",
    "start": "zones between the left and the first wire",
    "arm": "wires picked by another arm than preferred",
}


class Mender(Protocol):
    """Whoever simulates a plan with a change, and says what it costs more in all."""

    def picked_before(self, first: str, second: str) -> int:
        """Return the difference if a wire is picked right before another one."""

    def done_by(self, wire: str, arm: str) -> int | None:
        """Return the least difference if an arm picks a wire; None if it cannot."""


@dataclass(frozen=True)
class BrokenWish:
    """A wish that a plan breaks.

    Attributes:
        places: of the two wires among the picks, from 1.
    """

    wish: Wish
    places: tuple[int, int]


def broken_wishes(problem: Problem, plan: Plan) -> tuple[BrokenWish, ...]:
    """Return the wishes that a valid plan breaks, the dearest first."""
    picks = [str(action.wire) for action in plan.actions if action.kind is ActionKind.PICK]
    place = {wire: i for i, wire in enumerate(picks, 1)}
    ranked = (wish for ranking in problem.rankings for wish in _against_ranks(ranking, picks))
    broken = []
    for wish in itertools.chain(problem.wishes, ranked):
        places = place.get(wish.before), place.get(wish.after)
        if places[0] is not None and places[1] is not None and places[0] > places[1]:
            broken.append(BrokenWish(wish, (places[0], places[1])))
    return tuple(sorted(broken, key=lambda item: -item.wish.weight))


def _against_ranks(ranking: Ranking, picks: list[str]) -> Iterator[Wish]:
    """Yield the wishes that the picks break, of each wire those of the nearest rank first."""
    groups: dict[int, list[str]] = {}
    for wire in picks:
        rank = ranking.rank.get(wire)
        if rank is None:
            continue
        for later in sorted(other for other in groups if other > rank):
            for picked in reversed(groups[later]):
                yield Wish(wire, picked, ranking.weight, ranking.reason)
        groups.setdefault(rank, []).append(wire)


def explain(preferred: Preferred, plan: Plan, verdict: Verdict, mender: Mender) -> Iterator[str]:
    """Yield the explanation of a valid plan, line by line."""
    problem = preferred.problem
    yield (
        f"{problem.name}: cost {verdict.cost} = makespan {verdict.makespan} "
        f"({verdict.makespan / _TICKS_PER_S:.1f} s) + penalties {sum(verdict.penalties.values())}"
    )
    weights = vars(problem.weights)
    for name, what in _PENALTIES.items():
        paid = verdict.penalties[name]
        if paid:
            yield f"  {paid}: {paid // weights[name]} {what}, {weights[name]} each"
    if verdict.penalties["soft"]:
        yield f"  {verdict.penalties['soft']}: wishes broken, of {_wished(problem)}"
    yield from _tell_order(problem, plan, mender)
    for reason, wires in _by_reason(preferred.detours).items():
        yield f"kept: `{reason}`: {', '.join(wires)} done in another way"
    yield from _tell_arms(preferred, plan, mender)
    after: dict[str, list[str]] = {}
    for before, later in wire_order(problem):
        after.setdefault(before, []).append(later)
    by_reason = sorted(broken_wishes(problem, plan), key=lambda item: item.wish.reason)
    for reason, group in itertools.groupby(by_reason, lambda item: item.wish.reason):
        yield from _tell_group(reason, list(group), problem, after, mender)


def _wished(problem: Problem, reason: str | None = None) -> int:
    """Return how many pairs of wires wishes are about; those of one reason, if it is given."""
    return sum(reason in (None, wish.reason) for wish in problem.wishes) + sum(
        ranking.pairs for ranking in problem.rankings if reason in (None, ranking.reason)
    )


def _tell_order(problem: Problem, plan: Plan, mender: Mender) -> Iterator[str]:
    """Tell the order of the picks, and what the nearest other orders would cost."""
    picks = [str(action.wire) for action in plan.actions if action.kind is ActionKind.PICK]
    yield f"order: {' '.join(picks)}"
    neighbours = list(itertools.pairwise(picks))[:_EXAMINED]
    bound = set(wire_order(problem))
    free = [pair for pair in neighbours if pair not in bound]
    if not free:
        return
    costs = sorted(
        (mender.picked_before(later, earlier), later, earlier) for earlier, later in free
    )
    yield (
        f"of {len(neighbours)} neighbours in it, order constraints hold "
        f"{len(neighbours) - len(free)}; the nearest exchanges of others:"
    )
    for mending, later, earlier in costs[:_TOLD]:
        yield _judge(f"{later} right before {earlier}", mending)


def _by_reason(reasons: dict[str, str]) -> dict[str, list[str]]:
    wires: dict[str, list[str]] = {}
    for wire, reason in reasons.items():
        wires.setdefault(reason, []).append(wire)
    return wires


def _tell_arms(preferred: Preferred, plan: Plan, mender: Mender) -> Iterator[str]:
    """Tell which of the user's preferences for an arm the plan breaks."""
    problem = preferred.problem
    index = {arm.name: i for i, arm in enumerate(problem.arms)}
    modes = possible_modes(problem)
    against: dict[str, list[str]] = {}
    for action in plan.actions:
        name = str(action.wire)
        wished = problem.wire[name].preferred_arm if name in preferred.arm_reasons else None
        if action.kind is ActionKind.PICK and wished is not None and wished != action.arm:
            against.setdefault(preferred.arm_reasons[name], []).append(name)
    for reason, names in against.items():
        arms = {name: str(problem.wire[name].preferred_arm) for name in names}
        able = [n for n in names if any(mode.arm == index[arms[n]] for mode in modes[n])]
        yield (
            f"broken, costs {len(names) * problem.weights.arm}: `{reason}`: another arm picks "
            f"{', '.join(names)}; {len(names) - len(able)} of {len(names)} are out of its "
            "reach"
        )
        for name in able[:_TOLD]:
            yield _judge(f"{name} by {arms[name]}", mender.done_by(name, arms[name]))


def _tell_group(
    reason: str,
    group: list[BrokenWish],
    problem: Problem,
    after: dict[str, list[str]],
    mender: Mender,
) -> Iterator[str]:
    """Tell the broken pairs of one preference; those of the design one by one."""
    told = group if not reason else group[:_TOLD]
    if len(told) < len(group):
        pairs = _wished(problem, reason)
        paid = sum(item.wish.weight for item in group)
        yield f"broken, costs {paid}: `{reason}`: {len(group)} of {pairs} pairs, such as"
    for item in told:
        lines = _tell(item, after, mender)
        yield from lines if told == group else (f"  {line}" for line in lines)


def _tell(item: BrokenWish, after: dict[str, list[str]], mender: Mender) -> Iterator[str]:
    wish = item.wish
    title = f"`{wish.reason}`: " if wish.reason else ""
    yield (
        f"broken, costs {wish.weight}: {title}{wish.before} should be picked before {wish.after}, "
        f"but they are numbers {item.places[0]} and {item.places[1]}"
    )
    chain = _chain(after, wish.after, wish.before)
    if chain:
        yield f"    cannot be kept: {' must come before '.join(chain)}"
    else:
        mending = mender.picked_before(wish.before, wish.after)
        yield _judge(f"{wish.before} right before {wish.after}", mending)


def _judge(change: str, mending: int | None) -> str:
    if mending is None:
        return f"    rejected: {change} makes the arms wait for each other for ever"
    if mending == 0:
        return f"    as good: {change} costs the same in all"
    if mending > 0:
        return f"    rejected: {change} would cost {mending} more in all"
    return f"    not found: {change} would save {-mending}; more time for the search may mend it"


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
