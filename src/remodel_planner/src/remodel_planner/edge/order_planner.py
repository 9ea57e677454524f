"""Plan an order that is ready: one call from its problem to a plan that the checker accepts."""

from __future__ import annotations

from remodel_planner.core.planning.checker import check
from remodel_planner.core.planning.planned import Planned
from remodel_planner.core.planning.problem import Problem
from remodel_planner.core.planning.tables import tables_of
from remodel_planner.edge.anytime_planner import AnytimePlanner, Limits
from remodel_planner.edge.search_kernel import Kernel
from remodel_planner.errors import InstanceError


def plan_problem(problem: Problem, time_limit_s: float) -> Planned:
    """Return the best plan that is found in a time, checked.

    Raises:
        InstanceError: if there is no plan.
    """
    planned = AnytimePlanner(Kernel(), tables_of(problem)).improved(Limits(time_limit_s)).planned
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
