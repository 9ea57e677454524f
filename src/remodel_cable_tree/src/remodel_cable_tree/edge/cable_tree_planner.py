"""Find the order of insertions of a cable tree: feasible first, then better until time is over.

Searches with their own seeds run in threads, one for each core, since the kernel releases Python's
lock.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from remodel_cable_tree.core.constraint import Constraint, constraints_of, with_constraints
from remodel_cable_tree.core.order import cost_of
from remodel_cable_tree.core.problem import CableTree
from remodel_cable_tree.core.rounds import Round, rounds
from remodel_cable_tree.edge.cable_tree_kernel import Feasibility, KernelCableTree
from remodel_tasks.core.problem.conflict import smallest_conflict

_LEAST_SEARCHES = 2
# Of one seed, so that neighbouring seeds do not search alike.
_SEEDS = 1000
# Of the first search for an order; each further one may take twice as many. Public instances take
# some hundreds.
_FIRST_NODES = 1_000
_SLICES = 16


@dataclass(frozen=True)
class Sequenced:
    """What is known at the end: whether there is an order, and the best one found."""

    feasibility: Feasibility
    order: tuple[int, ...]


def sequence(
    tree: CableTree,
    limit_s: float,
    seed: int,
    stopped: Callable[[], bool] = lambda: False,
    clock: Callable[[], float] = time.monotonic,
) -> Sequenced:
    """Return the best order found within a limit of time, or that there is none.

    Args:
        tree: whose ends are to be ordered.
        limit_s: [s] of search, from which its work follows.
        seed: of the searches.
        stopped: asked again and again; true to stop now.
        clock: [s] that ends the search on a machine too slow for that work.

    Raises:
        KernelError: if the kernel is not there.
    """
    deadline = clock() + limit_s

    def over() -> bool:
        return stopped() or clock() >= deadline

    feasibility, order = _first_order(tree, over)
    if feasibility is not Feasibility.FOUND or tree.ends < 2:
        return Sequenced(feasibility, order)

    def search(index: int) -> tuple[int, tuple[int, ...]]:
        return _Search(tree, order, seed * _SEEDS + index).run(limit_s, over)

    count = max(_LEAST_SEARCHES, len(os.sched_getaffinity(0)))
    with ThreadPoolExecutor(count) as pool:
        best = min(pool.map(search, range(count)), key=lambda found: found[0])
    return Sequenced(feasibility, best[1])


def contradiction(
    tree: CableTree, limit_s: float, stopped: Callable[[], bool] = lambda: False
) -> list[Constraint]:
    """Return a smallest set of constraints of a cable tree that no order satisfies.

    Within a limit of time: then, a set without an order, but of which some may not be needed.
    """
    deadline = time.monotonic() + limit_s

    def over() -> bool:
        return stopped() or time.monotonic() >= deadline

    def has_order(kept: Sequence[Constraint]) -> bool:
        # What is not decided in time counts as having one, so that the set found has none.
        return _first_order(with_constraints(tree, kept), over)[0] is not Feasibility.NONE

    return smallest_conflict(constraints_of(tree), has_order)


def _first_order(tree: CableTree, over: Callable[[], bool]) -> tuple[Feasibility, tuple[int, ...]]:
    kernel, nodes = KernelCableTree(tree), _FIRST_NODES
    feasibility, order = kernel.find(nodes)
    while feasibility is Feasibility.UNDECIDED and not over():
        nodes *= 2
        feasibility, order = kernel.find(nodes)
    return feasibility, order


class _Search:
    """One thread's search."""

    def __init__(self, tree: CableTree, order: tuple[int, ...], seed: int) -> None:
        self._tree = tree
        self._kernel = KernelCableTree(tree)
        self._best = (cost_of(tree, order).total, order)
        self._seed = seed << 32

    def run(self, limit_s: float, over: Callable[[], bool]) -> tuple[int, tuple[int, ...]]:
        for part in rounds(self._tree.ends, limit_s):
            if self._best[0] == 0 or over():
                break
            self._kernel.adopt(self._start(part, over), self._next_seed())
            for i in range(_SLICES):
                share = (i / _SLICES, (i + 1) / _SLICES)
                self._kernel.anneal(part.recipe, part.moves // _SLICES + 1, share)
                if over():
                    break
            self._best = min(self._best, self._kernel.best(), key=lambda found: found[0])
        return self._best

    def _start(self, part: Round, over: Callable[[], bool]) -> tuple[int, ...]:
        """Return the best order so far, or the best of some newly gathered ones."""
        starts = []
        for _ in range(part.gathers):
            if over():
                break
            order = self._kernel.gather(part.most_nodes, self._next_seed())
            if order is not None:
                starts.append((cost_of(self._tree, order).total, order))
        if not starts:
            return self._best[1]
        start = min(starts, key=lambda found: found[0])
        self._best = min(self._best, start, key=lambda found: found[0])
        return start[1]

    def _next_seed(self) -> int:
        self._seed += 1
        return self._seed
