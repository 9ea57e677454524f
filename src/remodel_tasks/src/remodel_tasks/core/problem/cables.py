"""Cables of a problem: their cores, and the wires of twisted groups, are one task."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from remodel_run.whole_task import whole_tasks
from remodel_tasks.core.problem.order import wire_order
from remodel_tasks.core.problem.problem import Problem, Ranking, Stage

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
    before: dict[str, set[str]] = {}
    for earlier, later in wire_order(problem):
        before.setdefault(later, set()).add(earlier)
    left = list(names)
    order: list[str] = []
    while left:
        order.append(left.pop(0))
        cable = problem.wire[order[-1]].cable
        cores = [name for name in left if problem.wire[name].cable == cable] if cable else []
        for core in cores:
            if before.get(core, set()).isdisjoint(left):
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
