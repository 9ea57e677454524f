"""Parts of a problem: the wires that are left of it, those that come last, and its cables.

A cable is one task: its cores, or the wires of a twisted group, follow each other.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

from remodel_run.whole_task import whole_tasks
from remodel_tasks.core.problem.problem import (
    ActionKind,
    Plan,
    Problem,
    Ranking,
    Stage,
    Under,
    directly_before,
    grouped,
    possible_modes,
    reached,
    wire_order,
)

# The reason of the order constraints that defer wires.
_DEFERRED = "deferred"


def part_of(problem: Problem, names: Collection[str]) -> Problem:
    """Return the part of a sound problem that is about some of its wires; it is sound as well.

    Of two wires that one in between kept in order, the order stays when that one is left out.

    Args:
        problem: in which no wire has been picked yet.
        names: of the wires that are left.
    """
    left = set(names)
    return replace(
        problem,
        wires=tuple(wire for wire in problem.wires if wire.name in left),
        unders=tuple(_unders(problem, left)),
        pins=tuple(p for p in problem.pins if p.before in left and p.after in left),
        soft_constraints=tuple(
            w for w in problem.soft_constraints if w.before in left and w.after in left
        ),
        rankings=tuple(_rankings(problem, left)),
    )


def defer(problem: Problem, names: Collection[str]) -> Problem:
    """Return a problem in whose plans some wires come after all others.

    Wires that must come after them by another constraint still do.
    """
    last = tuple(dict.fromkeys(name for name in names if name in problem.wire))
    late = reached(last, grouped(wire_order(problem)))
    unders = (
        Under(wire.name, name, _DEFERRED)
        for name in last
        for wire in problem.wires
        if wire.name not in late
    )
    return replace(problem, unders=(*problem.unders, *unders)) if last else problem


def _unders(problem: Problem, left: set[str]) -> Iterator[Under]:
    after = grouped((under.before, under.after) for under in problem.unders)
    for under in problem.unders:
        if under.before in left and under.after in left:
            yield under
        elif under.before in left:
            for name in _reached(under.after, after, left):
                yield replace(under, after=name)


def _reached(start: str, after: dict[str, list[str]], left: set[str]) -> list[str]:
    """Return the first wires that are left on all paths on from one that is not."""
    seen, frontier = {start}, [start]
    while frontier:
        fresh = [name for name in after.get(frontier.pop(), ()) if name not in seen]
        seen.update(fresh)
        frontier.extend(name for name in fresh if name not in left)
    return sorted(seen & left)


def _rankings(problem: Problem, left: set[str]) -> Iterator[Ranking]:
    for ranking in problem.rankings:
        groups = (tuple(w for w in group if w in left) for group in ranking.groups)
        filled = tuple(group for group in groups if group)
        if len(filled) > 1:
            yield replace(ranking, groups=filled)


# The name of the preference for cables that are begun.
_BEGUN = "a cable that is begun is finished first"


def cores_of(problem: Problem) -> dict[str, tuple[str, ...]]:
    """Return the names of the cores of each cable that has several."""
    tasks = whole_tasks((wire.name, wire.cable) for wire in problem.wires)
    return {task.name: task.wires for task in tasks if task.is_cable}


def with_first(problem: Problem, cores: Collection[str]) -> Problem:
    """Return a problem in whose plans the cores left of cables begun come before other wires."""
    first = tuple(wire.name for wire in problem.wires if wire.name in cores)
    others = tuple(wire.name for wire in problem.wires if wire.name not in cores)
    if not first or not others or not problem.weights.cable:
        return problem
    ranking = Ranking((first, others), problem.weights.cable, _BEGUN)
    return replace(problem, rankings=(*problem.rankings, ranking))


def gathered(problem: Problem, names: Sequence[str]) -> tuple[str, ...]:
    """Return an order of wires in which the cores of each cable follow each other.

    A plan's order of picks has other wires of the other arm among them. A core stays behind a wire
    that must come before it.

    Args:
        problem: of these wires.
        names: of wires, in an order that keeps the order constraints.
    """
    before = directly_before(problem)
    left = list(names)
    order: list[str] = []
    while left:
        order.append(left.pop(0))
        cable = problem.wire[order[-1]].cable
        cores = [name for name in left if problem.wire[name].cable == cable] if cable else []
        for core in cores:
            if set(left).isdisjoint(before.get(core, ())):
                left.remove(core)
                order.append(core)
    return tuple(order)


def first_picks(problem: Problem) -> int:
    """Return what the weight `cable` would add to every plan if first picks were charged too."""
    picked = {wire for wire, _ in problem.history}
    begun = {problem.wire[name].cable for name in picked}
    stored = {
        wire.cable
        for wire in problem.wires
        if wire.cable and wire.stage is Stage.STORED and wire.name not in picked
    }
    return problem.weights.cable * len(stored - begun)


@dataclass(frozen=True)
class CableTask:
    """A cable as a plan does it.

    Attributes:
        parts: arm, and the cores that it picks with no other wire between them; one part, unless
            the plan could not keep the cores together.
        reason: why there are several parts; empty for one.
    """

    name: str
    parts: tuple[tuple[str, tuple[str, ...]], ...]
    reason: str = ""

    def __str__(self) -> str:
        """Return the line for a person."""
        done = ", ".join(f"{' '.join(cores)} by {arm}" for arm, cores in self.parts)
        if len(self.parts) == 1:
            return f"cable {self.name}: {done}"
        return f"cable {self.name} is in {len(self.parts)} parts: {done}; {self.reason}"


def cable_tasks(problem: Problem, plan: Plan) -> tuple[CableTask, ...]:
    """Return the cables of which a valid plan picks cores, in the order of their first picks."""
    several = cores_of(problem)
    picks = sorted(
        (action for action in plan.actions if action.kind is ActionKind.PICK),
        key=lambda action: action.start_ticks,
    )
    begun: dict[str, list[tuple[int, str, tuple[str, ...]]]] = {}
    for arm in problem.arms:
        own = [(i, str(pick.wire)) for i, pick in enumerate(picks) if pick.arm == arm.name]
        for cable, group in groupby(own, lambda pick: problem.wire[pick[1]].cable):
            cores = list(group)
            if cable in several:
                part = (cores[0][0], arm.name, tuple(core for _, core in cores))
                begun.setdefault(cable, []).append(part)
    return tuple(
        CableTask(
            cable,
            tuple((arm, cores) for _, arm, cores in sorted(parts)),
            _reason(problem, several[cable]) if len(parts) > 1 else "",
        )
        for cable, parts in sorted(begun.items(), key=lambda each: min(each[1]))
    )


def _reason(problem: Problem, cores: tuple[str, ...]) -> str:
    modes = possible_modes(problem)
    stored = [name for name in cores if problem.wire[name].stage is Stage.STORED]
    arms = [{mode.arm for mode in modes[name]} for name in stored]
    if not set.intersection(*arms):
        return "no arm reaches the ends of all its cores"
    return "order constraints keep its cores apart"
