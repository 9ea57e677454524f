"""Find the order of insertions of a cable tree by the compiled search.

Searches with their own seeds run in threads, one for each core, since the kernel releases Python's
lock.
"""

from __future__ import annotations

import ctypes
import os
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from ctypes import POINTER, c_double, c_int32, c_int64, c_uint64, c_void_p
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from remodel_cable_tree.problem import (
    CableTree,
    Constraint,
    Recipe,
    Round,
    constraints_of,
    cost_of,
    rounds,
    with_constraints,
)
from remodel_tasks.core.problem.conflict import smallest_conflict
from remodel_tasks.edge.search_kernel import declare, load_library

_COUNTS = ("ends", "cables", "atomics", "disjunctives", "softs", "directs")
_ARRAYS = ("atomic", "disjunctive", "soft", "direct")
_Pointer = POINTER(c_int32)


class CableTreeTables(ctypes.Structure):
    """The structure of the same name in kernel/cable_tree.hpp, field by field."""

    _fields_ = [
        *((name, c_int32) for name in _COUNTS),
        *((name, _Pointer) for name in _ARRAYS),
    ]


class Feasibility(Enum):
    """Whether any order satisfies the constraints."""

    NONE = 0
    FOUND = 1
    UNDECIDED = 2


class KernelCableTree:
    """A cable tree in the kernel, with one search on it. Ends count from 1, as everywhere."""

    def __init__(self, tree: CableTree) -> None:
        """Load the tree into the kernel, which propagates its constraints at once.

        Raises:
            KernelError: if the kernel is not there.
        """
        self._library = load_library("libremodel_cable_tree_kernel.so")
        declare(
            self._library,
            ("remodel_cable_tree_new", c_void_p, [POINTER(CableTreeTables)]),
            ("remodel_cable_tree_delete", None, [c_void_p]),
            ("remodel_cable_tree_find", c_int32, [c_void_p, c_int64, c_void_p]),
            ("remodel_cable_tree_gather", c_int32, [c_void_p, c_int64, c_uint64, c_void_p]),
            ("remodel_cable_tree_adopt", None, [c_void_p, c_void_p, c_uint64]),
            (
                "remodel_cable_tree_anneal",
                c_int64,
                [c_void_p, c_int64, c_double, c_double, c_void_p],
            ),
            ("remodel_cable_tree_best", c_int64, [c_void_p, c_void_p]),
        )
        rows = (tree.atomic, tree.disjunctive, tree.soft, tree.direct)
        self._arrays = [np.array(row, np.int32).ravel() - 1 for row in rows]
        self._structure = CableTreeTables(
            tree.ends,
            tree.cables,
            *map(len, rows),
            *(array.ctypes.data_as(_Pointer) for array in self._arrays),
        )
        self._ends = tree.ends
        self._handle = self._library.remodel_cable_tree_new(ctypes.byref(self._structure))

    def __del__(self) -> None:
        if hasattr(self, "_handle"):
            self._library.remodel_cable_tree_delete(self._handle)

    def find(self, most_nodes: int) -> tuple[Feasibility, tuple[int, ...]]:
        """Search an order that satisfies the constraints, in so many nodes."""
        order = np.empty(self._ends, np.int32)
        found = self._library.remodel_cable_tree_find(self._handle, most_nodes, order.ctypes.data)
        feasibility = Feasibility(found)
        return feasibility, _from_1(order) if feasibility is Feasibility.FOUND else ()

    def gather(self, most_nodes: int, seed: int) -> tuple[int, ...] | None:
        """Return an order with many cables whose ends follow each other, None if it finds none."""
        order = np.empty(self._ends, np.int32)
        if not self._library.remodel_cable_tree_gather(
            self._handle, most_nodes, seed, order.ctypes.data
        ):
            return None
        return _from_1(order)

    def adopt(self, order: Sequence[int], seed: int) -> None:
        """Begin a search from an order that satisfies the constraints."""
        array = np.array(order, np.int32) - 1
        self._library.remodel_cable_tree_adopt(self._handle, array.ctypes.data, seed)

    def anneal(self, recipe: Recipe, moves: int, share: tuple[float, float]) -> int:
        """Do a part of a recipe's annealing, and return the best cost so far.

        Args:
            recipe: temperatures and weights.
            moves: to try.
            share: the part, such as (0.0, 0.5) for the first half.
        """
        ratio = recipe.end_temperature / recipe.start_temperature
        start, end = (recipe.start_temperature * ratio**part for part in share)
        weights = (c_double * len(recipe.weights))(*recipe.weights)
        return int(
            self._library.remodel_cable_tree_anneal(self._handle, moves, start, end, weights)
        )

    def best(self) -> tuple[int, tuple[int, ...]]:
        """Return the best cost and order of the search."""
        order = np.empty(self._ends, np.int32)
        cost = int(self._library.remodel_cable_tree_best(self._handle, order.ctypes.data))
        return cost, _from_1(order)


def _from_1(order: np.ndarray[Any, np.dtype[np.int32]]) -> tuple[int, ...]:
    return tuple((order + 1).tolist())


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
