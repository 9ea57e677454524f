"""Plan: a first plan at once, a better one until the time is over, or an old one patched.

Two searches with their own seeds run in threads, since the kernel releases Python's lock.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from remodel_planning.core.search.annealing import first_slice, slices
from remodel_planning.core.search.planned import Planned
from remodel_planning.core.search.tables import Integers, Tables
from remodel_planning.edge.search_kernel import Kernel, KernelProblem, KernelSearch

_THREADS = 2


@dataclass(frozen=True)
class Limits:
    """When to stop improving.

    Attributes:
        time_s: at the latest after this time.
        target: once a plan costs no more than this; None: no target.
        stopped: asked again and again; true to stop now.
    """

    time_s: float
    target: int | None = None
    stopped: Callable[[], bool] = lambda: False


@dataclass(frozen=True)
class Result:
    """The best plan of a search, and whether the search did all the work that its limit allots."""

    planned: Planned
    complete: bool


class AnytimePlanner:
    """The planner of one problem."""

    def __init__(self, kernel: Kernel, tables: Tables, seed: int = 1) -> None:
        """Take the kernel, the problem's tables, and the seed that decides among equals."""
        self._tables = tables
        self._seed = seed
        self._problem: KernelProblem = kernel.load(tables)
        self._arms = tables.scalars["arms"]

    def first(self) -> Planned:
        """Return a first valid plan.

        Raises:
            InstanceError: if there is none: the arms would wait for each other.
        """
        return self._shown(self._started(0))

    def patched(self, order: Integers, modes: Integers) -> Planned:
        """Return the plan that keeps an older plan's order as far as the problem lets it.

        Args:
            order: (k,) wires in the order to keep; wires that it leaves out come last.
            modes: (wires,) mode numbers to keep where possible, or -1.

        Raises:
            InstanceError: if there is none: the arms would wait for each other.
        """
        return self._decoded(*self._following(order, modes, opening_first=False))

    def improved(self, limits: Limits, start: Planned | None = None) -> Result:
        """Return the best plan found within the limits, from a plan or from the first plan.

        Both searches do all their moves in the threads, their first ones too: at the same time.
        """
        deadline = time.monotonic() + limits.time_s
        with ThreadPoolExecutor(_THREADS) as pool:
            searches = list(pool.map(lambda i: self._started(i, start), range(_THREADS)))
            shown = self._shown(searches[0])
            offset = shown.cost - searches[0].best()[0]
            best = shown if start is None else start
            reached = threading.Event()

            def over(cost: int) -> bool:
                if limits.target is not None and cost + offset <= limits.target:
                    reached.set()
                return reached.is_set() or limits.stopped() or time.monotonic() >= deadline

            complete = list(
                pool.map(lambda search: self._run(search, limits.time_s, over), searches)
            )
        found = min(map(self._shown, searches), key=lambda planned: planned.cost)
        return Result(min(best, found, key=lambda planned: planned.cost), all(complete))

    def _run(self, search: KernelSearch, limit_s: float, over: Callable[[int], bool]) -> bool:
        """Search until the work is done (true) or it is over."""
        cost = search.best()[0]
        for part in slices(self._problem.size, self._arms, limit_s):
            if over(cost):
                return False
            if part.opens_round:
                search.return_to_best()
            cost = search.anneal(part.moves, part.start_temperature, part.end_temperature)
        return True

    def _started(self, index: int, start: Planned | None = None) -> KernelSearch:
        search = self._problem.search(self._seed * _THREADS + index)
        if start is None:
            search.construct()
        else:
            search.adopt(*self._following(start.order, start.modes, opening_first=True))
        part = first_slice(self._problem.size, self._arms)
        search.anneal(part.moves, part.start_temperature, part.end_temperature)
        return search

    def _following(
        self, order: Integers, modes: Integers, *, opening_first: bool
    ) -> tuple[Integers, Integers]:
        ranks = np.full(self._problem.size, len(order), np.int32)
        ranks[order] = np.arange(len(order), dtype=np.int32)
        return self._problem.follow_ranks(ranks, modes, opening_first=opening_first)

    def _shown(self, search: KernelSearch) -> Planned:
        _, order, modes = search.best()
        return self._decoded(order, modes)

    def _decoded(self, order: Integers, modes: Integers) -> Planned:
        decoded = self._problem.decode(order, modes)
        return Planned(
            self._tables,
            order,
            modes,
            decoded.actions,
            makespan=decoded.makespan,
            penalty=decoded.penalty,
        )
