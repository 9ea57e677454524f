"""Make an order ready for planning: decompose it under the requirements, apply preferences."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from remodel_production.errors import blamed
from remodel_tasks.core.decomposition.decomposed import Decomposition, Limits
from remodel_tasks.core.decomposition.decomposition import Decomposer
from remodel_tasks.core.decomposition.wiring_problem import (
    TaskPlan,
    decompose_order,
    decomposer_of,
    problem_left,
    wiring_problem,
)
from remodel_tasks.core.orders.work_order import WorkOrder
from remodel_tasks.core.problem.choices import choose
from remodel_tasks.core.problem.defects import require_sound
from remodel_tasks.core.problem.modes import Mode
from remodel_tasks.core.problem.part import part_of
from remodel_tasks.core.problem.preferences import (
    FORMAT,
    Preferred,
    apply_preferences,
    document_fields,
    requirements,
)
from remodel_tasks.core.problem.problem import Problem
from remodel_tasks.core.use_case.expectation import Expectations
from remodel_tasks.core.use_case.model import UseCase


def limits_of(problem: Problem, document: object, situations: frozenset[str]) -> Limits:
    """Return the limits that a preferences document sets, in the present situations.

    Args:
        problem: of the tasks decomposed without limits, by which wires are chosen.
        document: parsed.
        situations: in which requirements with a `while` count.

    Raises:
        InstanceError: naming the first entry that is malformed or speaks of what is not there.
    """
    force_n: dict[str, tuple[float, str]] = {}
    segments: dict[str, str] = {}
    for item in requirements(document_fields(document)):
        if item.has("while") and item.text("while") not in situations:
            continue
        if item.has("force_n"):
            limit = (float(item.number("force_n", least=1)), item.text("name"))
            for wire in choose(problem, item, "insert"):
                force_n[wire.name] = min(limit, force_n.get(wire.name, limit))
        elif item.has("avoid_segment"):
            segments[item.text("avoid_segment")] = item.text("name")
    return Limits(force_n, segments)


@dataclass(frozen=True)
class Prepared:
    """An order with its tasks decomposed, and the problem that is left to plan."""

    order: WorkOrder
    use_case: UseCase
    limits: Limits
    expectations: Expectations | None
    plans: tuple[TaskPlan, ...]
    preferred: Preferred

    @cached_property
    def plan_of(self) -> dict[str, TaskPlan]:
        """The tasks' decompositions, by name."""
        return {plan.alone.task.name: plan for plan in self.plans}

    @cached_property
    def component_of(self) -> dict[str, str]:
        """Components by the names of terminals."""
        return {terminal.name: terminal.component for terminal in self.order.terminals}

    @cached_property
    def decomposer(self) -> Decomposer:
        """The decomposer of the order's tasks."""
        return decomposer_of(self.order, self.use_case, self.expectations)

    def decomposition(self, name: str, mode: Mode) -> Decomposition:
        """Return the decomposition of a task with a handover or without, whichever end is first."""
        plan = self.plan_of[name]
        return plan.handed_over if mode.hands_over and plan.handed_over else plan.alone

    def only(self, names: Collection[str]) -> Prepared:
        """Return what is left of the preparation when only these of its tasks are to be done.

        Nothing is decomposed or checked again, and expectations count as they were. A preference
        whose tasks are all done is no error.
        """
        left = set(names)
        plans = tuple(plan for plan in self.plans if plan.alone.task.name in left)
        tasks = tuple(task for task in self.order.tasks if task.name in left)
        order = replace(self.order, tasks=tasks)
        problem = problem_left(part_of(self.preferred.problem, left), order, plans)
        return replace(
            self, order=order, plans=plans, preferred=replace(self.preferred, problem=problem)
        )


def prepare(
    order: WorkOrder,
    use_case: UseCase,
    documents: Sequence[tuple[str, object]] = (),
    situations: frozenset[str] = frozenset(),
    expectations: Expectations | None = None,
) -> Prepared:
    """Make an order ready. Preferences do not count for one without tasks, all by hand.

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
    documents = documents if order.tasks else ()
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
    return Prepared(order, use_case, limits, expectations, plans=plans, preferred=preferred)
