"""What must come first when arms hold wires already.

An arm that holds a wire can do no other before it. A wire that the held one has to wait for must
then be done by the other arm, without a handover. So held wires, and the unfinished wires that they
wait for, open the plan in a fixed order; or the arms deadlock.
"""

from __future__ import annotations

from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter

from remodel_production.errors import InfeasibleError
from remodel_tasks.core.problem.modes import Mode, possible_modes
from remodel_tasks.core.problem.order import wire_order
from remodel_tasks.core.problem.problem import Problem


@dataclass(frozen=True)
class Opening:
    """The wires that open every plan, in order, and the modes left to each wire."""

    wires: tuple[str, ...]
    modes: dict[str, tuple[Mode, ...]]


def opening_of(problem: Problem) -> Opening:
    """Return the opening of a problem whose order constraints have no cycle.

    Raises:
        InfeasibleError: if the arms would wait for each other.
    """
    modes = possible_modes(problem)
    holders = {arm.holding: i for i, arm in enumerate(problem.arms) if arm.holding is not None}
    before: dict[str, set[str]] = {}
    for first, second in wire_order(problem):
        before.setdefault(second, set()).add(first)
    graph: dict[str, set[str]] = {}
    for held, arm in holders.items():
        for wire in _ancestors(held, before) - {held}:
            modes[wire] = tuple(mode for mode in modes[wire] if arm not in _arms(mode))
            graph.setdefault(wire, set())
        graph.setdefault(held, set())
    for wire, earlier in graph.items():
        earlier |= before.get(wire, set())
        earlier |= {
            held
            for held, arm in holders.items()
            if held != wire and any(arm in _arms(mode) for mode in modes[wire])
        }
    try:
        order = tuple(TopologicalSorter(graph).static_order())
    except CycleError as error:
        raise InfeasibleError(deadlock(problem)) from error
    if not all(modes[wire] for wire in order):
        raise InfeasibleError(deadlock(problem))
    return Opening(order, modes)


def _ancestors(wire: str, before: dict[str, set[str]]) -> set[str]:
    found, frontier = set(), [wire]
    while frontier:
        name = frontier.pop()
        if name not in found:
            found.add(name)
            frontier.extend(sorted(before.get(name, ())))
    return found


def _arms(mode: Mode) -> tuple[int, ...]:
    return (0, 1) if mode.hands_over else (mode.arm,)


def deadlock(problem: Problem) -> str:
    """Return the message for a problem in which the arms would deadlock."""
    held = ", ".join(f"{arm.name} {arm.holding}" for arm in problem.arms if arm.holding)
    return (
        f"{problem.name}: no plan, since the arms would wait for each other with the wires that "
        f"they hold ({held}): take one out by hand, and plan again"
    )
