"""The compiled search for cable trees (kernel/cable_tree_kernel.cpp), by ctypes."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import POINTER, c_double, c_int32, c_int64, c_uint64, c_void_p
from enum import Enum
from typing import Any

import numpy as np

from remodel_cable_tree.core.problem import CableTree
from remodel_cable_tree.core.rounds import Recipe
from remodel_tasks.edge.kernel_library import declare, load_library

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
        """Free the kernel's copy."""
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
