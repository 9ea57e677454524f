"""What the kernel's numbers say, as a plan with names."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from remodel_tasks.core.problem.problem import Action, ActionKind, End, Plan
from remodel_tasks.core.search.tables import Integers, Tables

# By the kernel's numbers (kernel/simulation.hpp).
_KINDS = (
    ActionKind.CHANGE_TOOL,
    ActionKind.PICK,
    ActionKind.LOCATE,
    ActionKind.INSERT,
    ActionKind.ROUTE,
    ActionKind.HAND_OVER,
    ActionKind.FIX,
    ActionKind.EXTRACT,
)
_HANDOVER_POINT = 2


@dataclass(frozen=True)
class Planned:
    """A list of wires with the actions that carry it out.

    The plan's objects are made when they are asked for: the search makes many lists and shows few.

    Attributes:
        order: (wires,) numbers of the wires in the list's order.
        modes: (wires,) mode number of each wire.
        actions: (n, 5) kind, arm, wire, detail, start [ticks] (kernel/simulation.hpp).
    """

    tables: Tables
    order: Integers
    modes: Integers
    actions: Integers
    makespan: int
    penalty: int

    @property
    def wires(self) -> tuple[str, ...]:
        """The wires' names in the list's order, which keeps to the problem's constraints.

        With two arms a wire may be picked before another that precedes it in the list.
        """
        return tuple(self.tables.wires[i] for i in self.order)

    @property
    def cost(self) -> int:
        """What the planner makes small."""
        return self.makespan + self.penalty

    @cached_property
    def plan(self) -> Plan:
        """The plan in names."""
        return Plan(self.tables.problem.name, tuple(map(self._action, self.actions.tolist())))

    def _action(self, row: list[int]) -> Action:
        problem = self.tables.problem
        kind, arm, wire_number, detail = _KINDS[row[0]], problem.arms[row[1]].name, row[2], row[3]
        start = row[4] + problem.start_ticks
        if kind is ActionKind.CHANGE_TOOL:
            return Action(kind, arm, start, target=problem.tools[detail])
        wire = problem.wire[self.tables.wires[wire_number]]
        if kind is ActionKind.LOCATE:
            return Action(kind, arm, start, target=wire.terminals[detail])
        if kind is ActionKind.HAND_OVER:
            return Action(kind, arm, start, wire.name, target=problem.arms[detail].name)
        if kind in (ActionKind.INSERT, ActionKind.EXTRACT):
            return Action(kind, arm, start, wire.name, end=End(detail))
        if kind is ActionKind.ROUTE:
            end = None if detail == _HANDOVER_POINT else End(detail)
            return Action(kind, arm, start, wire.name, end=end)
        return Action(kind, arm, start, wire.name)
