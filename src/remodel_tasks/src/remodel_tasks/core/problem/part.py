"""A part of a problem: the wires that are left of it, and wires that are deferred to its end."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

from remodel_tasks.core.problem.order import wire_order
from remodel_tasks.core.problem.problem import Problem, Ranking, Under

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
    late = _with_successors(problem, last)
    unders = (
        Under(wire.name, name, _DEFERRED)
        for name in last
        for wire in problem.wires
        if wire.name not in late
    )
    return replace(problem, unders=(*problem.unders, *unders)) if last else problem


def _unders(problem: Problem, left: set[str]) -> Iterator[Under]:
    after: dict[str, list[str]] = {}
    for under in problem.unders:
        after.setdefault(under.before, []).append(under.after)
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


def _with_successors(problem: Problem, names: Collection[str]) -> set[str]:
    """Return wires, and all that must come after one of them."""
    after: dict[str, list[str]] = {}
    for before, later in wire_order(problem):
        after.setdefault(before, []).append(later)
    found, frontier = set(names), list(names)
    while frontier:
        fresh = [name for name in after.get(frontier.pop(), ()) if name not in found]
        found.update(fresh)
        frontier.extend(fresh)
    return found
