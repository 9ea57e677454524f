"""Make an order ready for planning: decompose it under the requirements, apply preferences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from remodel_planner.core.planning.defects import require_sound
from remodel_planner.core.planning.preferences import FORMAT, Preferred, apply_preferences
from remodel_planner.core.use_case.decomposed import Limits
from remodel_planner.core.use_case.expectation import Expectations
from remodel_planner.core.use_case.model import UseCase
from remodel_planner.core.use_case.requirements import limits_of
from remodel_planner.core.use_case.wiring_problem import (
    TaskPlan,
    decompose_order,
    wiring_problem,
)
from remodel_planner.core.use_case.work_order import WorkOrder
from remodel_planner.errors import blamed


@dataclass(frozen=True)
class Prepared:
    """An order with its tasks decomposed, and the problem that is left to plan."""

    order: WorkOrder
    use_case: UseCase
    limits: Limits
    expectations: Expectations | None
    plans: tuple[TaskPlan, ...]
    preferred: Preferred


def prepare(
    order: WorkOrder,
    use_case: UseCase,
    documents: Sequence[tuple[str, object]] = (),
    situations: frozenset[str] = frozenset(),
    expectations: Expectations | None = None,
) -> Prepared:
    """Make an order ready.

    Args:
        order: what is to be done.
        use_case: how such work is done.
        documents: preferences, parsed, with what to call them in errors; they come after those of
            the use case.
        situations: that are present.
        expectations: of abilities; None: those that the use case states.

    Raises:
        InstanceError: naming what is malformed, missing or impossible.
    """
    own = {"format": FORMAT, **use_case.preferences}
    documents = ((f"preferences of use case {use_case.name}", own), *documents)
    plans = decompose_order(order, use_case, None, expectations)
    problem = wiring_problem(order, use_case, plans)
    require_sound(problem)
    limits = Limits()
    for name, document in documents:
        with blamed(name):
            limits = limits.and_those(limits_of(problem, document, situations))
    yielding: dict[str, str] = {}
    if limits:
        yielding = {p.alone.task.name: why for p in plans if (why := limits.objection(p.alone))}
        plans = decompose_order(order, use_case, limits, expectations)
        problem = wiring_problem(order, use_case, plans)
    preferred = Preferred(problem, detours=yielding)
    for name, document in documents:
        with blamed(name):
            preferred = apply_preferences(preferred, document, situations)
            require_sound(preferred.problem)
    return Prepared(order, use_case, limits, expectations, plans, preferred)
