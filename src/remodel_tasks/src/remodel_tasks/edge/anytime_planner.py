"""Plan: a first plan at once, a better one until the time is over, or an old one patched.

Several searches with their own seeds run in threads, as the kernel releases Python's lock: one for
each core, or, where the work is counted in moves, as many on any machine. After each round, those
that are behind go on from the best plan of all. They wait for each other there, so that what they
find does not depend on how fast each of them runs.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np

from remodel_production.errors import InstanceError
from remodel_tasks.core.plan.checker import check
from remodel_tasks.core.problem.problem import Problem
from remodel_tasks.core.search import (
    Integers,
    Planned,
    Slice,
    Tables,
    first_slice,
    slices,
    slices_of,
    tables_of,
)
from remodel_tasks.edge.search_kernel import Kernel, KernelProblem, KernelSearch

# Of searches by moves, for as many cores as most machines of a cell have.
_SEARCHES_BY_MOVES = 4
# Shorter searches begin and exchange plans longer than they search.
_LEAST_SHARED_S = 0.2
_LEAST_SEARCHES = 2
# Of one planner, so that no two planners of neighbouring seeds search alike.
_SEEDS = 1000


@dataclass(frozen=True)
class Limits:
    """When to stop improving.

    Attributes:
        time_s: at the latest after this time; infinite for a search by moves.
        target: once a plan costs no more than this; None: no target.
        stopped: asked again and again; true to stop now.
        moves: of each search, after which it ends whatever the time; None: as time allows.
    """

    time_s: float
    target: int | None = None
    stopped: Callable[[], bool] = lambda: False
    moves: int | None = None

    @property
    def searches(self) -> int:
        """How many searches run at the same time."""
        if self.moves is not None:
            return _SEARCHES_BY_MOVES
        cores = len(os.sched_getaffinity(0))
        return max(_LEAST_SEARCHES, cores) if self.time_s >= _LEAST_SHARED_S else _LEAST_SEARCHES

    def slices(self, wires: int, arms: int) -> Iterator[Slice]:
        """Yield what each search does."""
        if self.moves is not None:
            return slices_of(wires, arms, self.moves)
        return slices(wires, arms, self.time_s)


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

    def improved(
        self,
        limits: Limits,
        start: Planned | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> Result:
        """Return the best plan found within the limits, from a plan or from the first plan.

        The searches do all their moves in the threads, their first ones too: at the same time.

        Args:
            limits: when to stop.
            start: the plan to improve; None: the first plan.
            clock: returns the time [s]; with one that never advances, the searches do all the work
                of the time, as on an idle machine.
        """
        deadline = clock() + limits.time_s
        count = limits.searches
        with ThreadPoolExecutor(count) as pool:
            searches = list(pool.map(lambda i: self._started(i, start), range(count)))
            shown = self._shown(searches[0])
            offset = shown.cost - searches[0].best()[0]
            best = shown if start is None else start
            reached = threading.Event()

            def over(cost: int) -> bool:
                if limits.target is not None and cost + offset <= limits.target:
                    reached.set()
                return reached.is_set() or limits.stopped() or clock() >= deadline

            complete = True
            for parts in _rounds(limits.slices(self._problem.size, self._arms)):
                exchange(searches)
                work = partial(_run, parts=parts, over=over)
                complete = complete and all(list(pool.map(work, searches)))
                if not complete:
                    break
        found = min(map(self._shown, searches), key=lambda planned: planned.cost)
        return Result(min(best, found, key=lambda planned: planned.cost), complete)

    def _started(self, index: int, start: Planned | None = None) -> KernelSearch:
        search = self._problem.search(self._seed * _SEEDS + index)
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


def _rounds(parts: Iterator[Slice]) -> Iterator[list[Slice]]:
    """Yield the slices of each round."""
    together: list[Slice] = []
    for part in parts:
        if part.opens_round and together:
            yield together
            together = []
        together.append(part)
    if together:
        yield together


def _run(search: KernelSearch, parts: Sequence[Slice], over: Callable[[int], bool]) -> bool:
    """Search a round until its work is done (true) or the search is over."""
    cost = search.best()[0]
    for part in parts:
        if over(cost):
            return False
        cost = search.anneal(part.moves, part.start_temperature, part.end_temperature)
    return True


def exchange(searches: Sequence[KernelSearch]) -> None:
    """Let every search go on from the best plan of all, the first of equals."""
    costs = [search.best()[0] for search in searches]
    leader = searches[costs.index(min(costs))]
    _, order, modes = leader.best()
    for search, cost in zip(searches, costs, strict=True):
        if cost > min(costs):
            search.adopt(order, modes)
        else:
            search.return_to_best()


def plan_problem(
    problem: Problem, time_limit_s: float, clock: Callable[[], float] = time.monotonic
) -> Planned:
    """Return the best plan that is found in a time, checked; InstanceError if there is no plan."""
    planner, limits = AnytimePlanner(Kernel(), tables_of(problem)), Limits(time_limit_s)
    planned = planner.improved(limits, clock=clock).planned
    require_valid(planned)
    return planned


def replan_problem(
    problem: Problem,
    previous: Sequence[str],
    modes: Mapping[str, int],
    time_limit_s: float,
    clock: Callable[[], float] = time.monotonic,
) -> Planned:
    """Return a plan, checked, that costs no more than an earlier order of the wires.

    Args:
        problem: what is left.
        previous: names of wires in the earlier order, which is kept as far as the problem lets it;
            wires that it leaves out come last.
        modes: mode number of each wire in the earlier plan, as far as they are known.
        time_limit_s: [s] in which to search for a better order.
        clock: returns the time [s]; see AnytimePlanner.improved.

    Raises:
        InstanceError: if there is no plan.
    """
    tables = tables_of(problem)
    number = {name: i for i, name in enumerate(tables.wires)}
    order = np.array([number[name] for name in previous if name in number], np.int32)
    kept = np.array([modes.get(name, -1) for name in tables.wires], np.int32)
    planner = AnytimePlanner(Kernel(), tables)
    start = planner.patched(order, kept)
    planned = planner.improved(Limits(time_limit_s), start, clock).planned
    require_valid(planned)
    return planned


def require_valid(planned: Planned) -> None:
    """Return if the checker accepts a plan.

    Raises:
        InstanceError: if it does not, which is a defect of this planner.
    """
    verdict = check(planned.tables.problem, planned.plan)
    if not verdict.valid or verdict.cost != planned.cost:
        raise InstanceError(
            f"the checker refuses the plan, which is a defect of this planner: cost "
            f"{planned.cost} against {verdict.cost}; {'; '.join(verdict.violations[:3])}"
        )
