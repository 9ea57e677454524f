"""The compiled search kernel (kernel/wiring_kernel.cpp), by ctypes.

The kernel keeps pointers to arrays and objects of its own; the classes here own both sides.
"""

from __future__ import annotations

import ctypes
from ctypes import POINTER, c_double, c_int32, c_int64, c_uint64, c_void_p
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from remodel_production.errors import InstanceError
from remodel_tasks.core.problem.defects import deadlock
from remodel_tasks.core.search import Integers, Tables
from remodel_tasks.errors import KernelError


def load_library(name: str) -> ctypes.CDLL:
    """Load a library from where the workspace's setup file says libraries are.

    Raises:
        KernelError: if it is not there.
    """
    try:
        return ctypes.CDLL(name)
    except OSError as error:
        raise KernelError(
            f"{name} cannot be loaded ({error}): run `make build`, which compiles it with g++, and "
            "source devel/setup.bash"
        ) from error


def declare(library: ctypes.CDLL, *functions: tuple[str, Any, list[Any]]) -> None:
    """Set result and argument types of functions, each given as name, result and arguments."""
    for name, result, arguments in functions:
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments


_SCALARS = (
    *("wires", "components", "segments", "arms", "unders", "pins", "softs", "rankings"),
    *("openings", "speed"),
    *("locate", "change_tool", "extract", "hand_over"),
    *("colour_weight", "zone_weight", "start_weight", "tool_weight", "heavy_weight", "arm_weight"),
    *("cable_weight", "light_started"),
)
_ARRAYS = (
    *("slot", "end_position", "end_component", "tool", "colour", "cable", "zone", "heavy"),
    *(
        "pick",
        "insert",
        "fix",
        "route",
        "handover",
        "handover_route",
        "preferred_arm",
        "modes",
        "stage",
        "jammed",
    ),
    *("segment_start", "segment", "under", "pin", "soft", "rank", "rank_weight"),
    *("opening", "located"),
    *("arm_position", "arm_station", "arm_tool", "arm_colour", "arm_cable", "arm_zone"),
)
_Pointer = POINTER(c_int32)


class WiringTables(ctypes.Structure):
    """The structure of the same name in kernel/problem.hpp, field by field."""

    _fields_ = [
        *((name, c_int32) for name in _SCALARS),
        *((name, _Pointer) for name in _ARRAYS),
    ]


@dataclass(frozen=True)
class Decoded:
    """A list of wires as the kernel has simulated it.

    Attributes:
        actions: (n, 5) kind, arm, wire, detail, start [ticks] (kernel/simulation.hpp).
    """

    actions: Integers
    makespan: int
    penalty: int


# kind, arm, wire, detail, start
_ACTION_FIELDS = 5
# Of one wire: tool change of giver and receiver, pick, extract, two locates, two inserts, two
# routes, handover, fix.
_MOST_ACTIONS = 12


class Kernel:
    """The loaded library."""

    def __init__(self) -> None:
        """Load the library; KernelError if it is not there."""
        self._library = load_library("libremodel_tasks_kernel.so")
        declare(
            self._library,
            ("remodel_problem_new", c_void_p, [POINTER(WiringTables)]),
            ("remodel_problem_delete", None, [c_void_p]),
            ("remodel_follow_ranks", None, [c_void_p, c_void_p, c_int32, c_void_p, c_void_p]),
            ("remodel_decode", c_int32, [*[c_void_p] * 4, c_int32, c_void_p]),
            ("remodel_search_new", c_void_p, [c_void_p, c_uint64]),
            ("remodel_search_delete", None, [c_void_p]),
            ("remodel_search_construct", c_int32, [c_void_p]),
            ("remodel_search_adopt", c_int32, [c_void_p] * 3),
            ("remodel_search_anneal", c_int64, [c_void_p, c_int64, c_double, c_double]),
            ("remodel_search_return_to_best", None, [c_void_p]),
            ("remodel_search_best", c_int64, [c_void_p] * 3),
        )

    def load(self, tables: Tables) -> KernelProblem:
        """Load a problem into the kernel."""
        return KernelProblem(self._library, tables)


class KernelProblem:
    """A problem that the kernel has taken."""

    def __init__(self, library: ctypes.CDLL, tables: Tables) -> None:
        """Take the loaded library and the problem's tables."""
        self.tables = tables
        self._library = library
        fields = {name: c_int32(tables.scalars[name]) for name in _SCALARS}
        arrays = {name: tables.arrays[name].ctypes.data_as(_Pointer) for name in _ARRAYS}
        self._structure = WiringTables(**fields, **arrays)
        self._handle = library.remodel_problem_new(ctypes.byref(self._structure))
        self.size = tables.scalars["wires"]

    def __del__(self) -> None:
        """Free the kernel's copy."""
        if hasattr(self, "_handle"):
            self._library.remodel_problem_delete(self._handle)

    def follow_ranks(
        self, ranks: Integers, modes: Integers, *, opening_first: bool
    ) -> tuple[Integers, Integers]:
        """Return an order of the wires that keeps to their ranks, and modes for it.

        Args:
            ranks: (wires,) what a smaller value has comes first, where the constraints allow.
            modes: (wires,) mode numbers to keep, or -1.
            opening_first: whether what opens a plan comes first even where it need not, as a
                search wants it.
        """
        order, kept = np.empty(self.size, np.int32), modes.copy()
        self._library.remodel_follow_ranks(
            self._handle,
            ranks.ctypes.data,
            opening_first,
            order.ctypes.data,
            kept.ctypes.data,
        )
        return order, kept

    def decode(self, order: Integers, modes: Integers) -> Decoded:
        """Simulate a list of wires; InstanceError if the arms would wait for each other."""
        actions = np.empty((_MOST_ACTIONS * self.size, _ACTION_FIELDS), np.int32)
        cost = np.empty(2, np.int64)
        count = self._library.remodel_decode(
            self._handle,
            order.ctypes.data,
            modes.ctypes.data,
            actions.ctypes.data,
            len(actions),
            cost.ctypes.data,
        )
        if count < 0:
            raise InstanceError(deadlock(self.tables.problem))
        penalty = int(cost[1]) + self.tables.constant
        return Decoded(actions[:count], int(cost[0]), penalty)

    def search(self, seed: int) -> KernelSearch:
        """Return a search that has no plan yet."""
        return KernelSearch(self._library, self._handle, self, seed)


class KernelSearch:
    """A search with a current plan and a best one."""

    def __init__(
        self,
        library: ctypes.CDLL,
        handle: int,
        problem: KernelProblem,
        seed: int,
    ) -> None:
        """Take the loaded library, the kernel's problem and its owner, and the seed."""
        self._library = library
        self._problem = problem
        self._handle = library.remodel_search_new(handle, seed)

    def __del__(self) -> None:
        """Free the search."""
        if hasattr(self, "_handle"):
            self._library.remodel_search_delete(self._handle)

    def construct(self) -> None:
        """Build a first plan; InstanceError if there is none."""
        if not self._library.remodel_search_construct(self._handle):
            raise InstanceError(deadlock(self._problem.tables.problem))

    def adopt(self, order: Integers, modes: Integers) -> None:
        """Start from a list of wires that satisfies the order constraints.

        Raises:
            InstanceError: if the arms would wait for each other.
        """
        if not self._library.remodel_search_adopt(
            self._handle, order.ctypes.data, modes.ctypes.data
        ):
            raise InstanceError(deadlock(self._problem.tables.problem))

    def anneal(self, moves: int, start_temperature: float, end_temperature: float) -> int:
        """Try some moves, and return the best cost so far, up to a constant of the problem."""
        return int(
            self._library.remodel_search_anneal(
                self._handle, moves, start_temperature, end_temperature
            )
        )

    def return_to_best(self) -> None:
        """Go on from the best plan."""
        self._library.remodel_search_return_to_best(self._handle)

    def best(self) -> tuple[int, Integers, Integers]:
        """Return the best cost so far (see `anneal`), the order and the modes."""
        order: npt.NDArray[np.int32] = np.empty(self._problem.size, np.int32)
        modes: npt.NDArray[np.int32] = np.empty(self._problem.size, np.int32)
        cost = self._library.remodel_search_best(self._handle, order.ctypes.data, modes.ctypes.data)
        return int(cost), order, modes
