"""Plan an order that is ready: one call from its problem to a plan that the checker accepts."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from remodel_production.errors import InstanceError
from remodel_tasks.core.plan.checker import check
from remodel_tasks.core.problem.problem import Problem
from remodel_tasks.core.search.planned import Planned
from remodel_tasks.core.search.tables import tables_of
from remodel_tasks.edge.anytime_planner import AnytimePlanner, Limits
from remodel_tasks.edge.search_kernel import Kernel


def plan_problem(
    problem: Problem, time_limit_s: float, clock: Callable[[], float] = time.monotonic
) -> Planned:
    """Return the best plan that is found in a time, checked.

    Args:
        problem: what is to be done.
        time_limit_s: [s] in which to search.
        clock: returns the time [s]; see AnytimePlanner.improved.

    Raises:
        InstanceError: if there is no plan.
    """
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
