"""Why a plan is as it is, in words: what it costs, what it breaks, and what mending would cost.

For each wish that the plan breaks, the plan is simulated again with the one wire moved right before
the other: what it costs more is the reason for which the wish was not kept. A wish that the order
constraints forbid is told with the constraints.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from remodel_planner.core.planning.checker import Verdict
from remodel_planner.core.planning.modes import possible_modes
from remodel_planner.core.planning.order import wire_order
from remodel_planner.core.planning.preferences import Preferred
from remodel_planner.core.planning.problem import ActionKind, Plan, Problem, Wish

# What a plan costs more if one wire is picked right before another one.
CostOfMending = Callable[[str, str], int]

_TICKS_PER_S = 10
_PENALTIES = {
    "tool": "changes of tool",
    "heavy": "heavy wires picked after a light one",
    "colour": "changes of colour",
    "zone": "zones gone back to the left",
    "start": "zones between the left and the first wire",
    "arm": "wires picked by another arm than preferred",
}


@dataclass(frozen=True)
class BrokenWish:
    """A wish that a plan breaks.

    Attributes:
        places: of the two wires among the picks, from 1.
        chain: wires that must be done one after the other and forbid the wish; or empty.
        mending: what the plan would cost more if the wish were kept; 0 where it is forbidden.
    """

    wish: Wish
    places: tuple[int, int]
    chain: tuple[str, ...]
    mending: int


def broken_wishes(problem: Problem, plan: Plan, mend: CostOfMending) -> tuple[BrokenWish, ...]:
    """Return the wishes that a valid plan breaks, the dearest first."""
    picks = [str(action.wire) for action in plan.actions if action.kind is ActionKind.PICK]
    place = {wire: i for i, wire in enumerate(picks, 1)}
    after: dict[str, list[str]] = {}
    for before, later in wire_order(problem):
        after.setdefault(before, []).append(later)
    broken = []
    for wish in problem.wishes:
        places = place.get(wish.before), place.get(wish.after)
        if places[0] is None or places[1] is None or places[0] < places[1]:
            continue
        chain = _chain(after, wish.after, wish.before)
        mending = 0 if chain else mend(wish.before, wish.after)
        broken.append(BrokenWish(wish, (places[0], places[1]), chain, mending))
    return tuple(sorted(broken, key=lambda item: -item.wish.weight))


def explain(
    preferred: Preferred, plan: Plan, verdict: Verdict, broken: tuple[BrokenWish, ...]
) -> Iterator[str]:
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
        yield f"  {verdict.penalties['soft']}: wishes broken, of {len(problem.wishes)}"
    yield from _tell_arms(preferred, plan)
    for item in broken:
        yield from _tell(item)


def _tell_arms(preferred: Preferred, plan: Plan) -> Iterator[str]:
    """Tell which of the user's preferences for an arm the plan breaks."""
    problem = preferred.problem
    index = {arm.name: i for i, arm in enumerate(problem.arms)}
    modes = possible_modes(problem)
    against: dict[str, list[bool]] = {}
    for action in plan.actions:
        name = str(action.wire)
        wished = problem.wire[name].preferred_arm if name in preferred.arm_reasons else None
        if action.kind is ActionKind.PICK and wished is not None and wished != action.arm:
            able = any(mode.arm == index[wished] for mode in modes[name])
            against.setdefault(preferred.arm_reasons[name], []).append(able)
    for reason, able_ones in against.items():
        yield (
            f"broken, costs {len(able_ones) * problem.weights.arm}: `{reason}`: {len(able_ones)} "
            f"wires are picked by the other arm, of which {able_ones.count(False)} are out of the "
            "preferred arm's reach"
        )


def _tell(item: BrokenWish) -> Iterator[str]:
    wish = item.wish
    title = f"`{wish.reason}`: " if wish.reason else ""
    yield (
        f"broken, costs {wish.weight}: {title}{wish.before} should be picked before {wish.after}, "
        f"but they are numbers {item.places[0]} and {item.places[1]}"
    )
    if item.chain:
        yield f"    cannot be kept: {' must come before '.join(item.chain)}"
    elif item.mending >= 0:
        yield (
            f"    rejected: {wish.before} right before {wish.after} would cost {item.mending} more "
            "in all"
        )
    else:
        yield (
            f"    not found: {wish.before} right before {wish.after} would save {-item.mending}; "
            "more time for the search may mend it"
        )


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
