"""Make an order ready for planning: decompose it under the requirements, apply preferences.

The decomposed tasks become the problem that core/problem states. The search decides the order of
tasks, their arms, first ends and handovers; how long each macro operation takes comes from the
decomposition.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from remodel_production.errors import InstanceError, blamed
from remodel_tasks.core.condition import Value
from remodel_tasks.core.decomposition.decomposed import Decomposition, Limits
from remodel_tasks.core.decomposition.decomposition import Decomposer
from remodel_tasks.core.orders.work_order import Task, WorkOrder
from remodel_tasks.core.problem.defects import require_sound
from remodel_tasks.core.problem.part import part_of
from remodel_tasks.core.problem.preferences import (
    FORMAT,
    Preferred,
    apply_documents,
    choose,
    document_fields,
    requirements,
)
from remodel_tasks.core.problem.problem import (
    TICKS_PER_S,
    Durations,
    End,
    Handling,
    Handover,
    Mode,
    PlannedWire,
    Problem,
    Weights,
)
from remodel_tasks.core.use_case.model import Characteristic, Expectations, Macro, UseCase

_ZONES = 4
_NO_WEIGHTS = Weights(0, 0, 0, 0, heavy=0, arm=0)


@dataclass(frozen=True)
class TaskPlan:
    """A task's decomposition, and the one with a handover where there may be one."""

    alone: Decomposition
    handed_over: Decomposition | None


def decompose_order(
    order: WorkOrder,
    use_case: UseCase,
    limits: Limits | None = None,
    expectations: Expectations | None = None,
) -> tuple[TaskPlan, ...]:
    """Return the decompositions of all tasks, in the order's order.

    Raises:
        InstanceError: naming a task that no method does, or says what the use case does not know.
    """
    _require_characteristics(order, use_case)
    decomposer = decomposer_of(order, use_case, expectations)
    return tuple(decompose_task(task, decomposer, limits) for task in order.tasks)


def decompose_task(task: Task, decomposer: Decomposer, limits: Limits | None = None) -> TaskPlan:
    """Return the decompositions of a task.

    Raises:
        InstanceError: if no method does it, or none hands it over where it must be.
    """
    use_case = decomposer.use_case
    first = End.A if task.first is None else task.first
    alone = decomposer.decompose(task, first, limits)
    if task.meeting_mm is None:
        return TaskPlan(alone, None)
    if Macro.HAND_OVER.value not in use_case.methods:
        raise InstanceError(
            f"task {task.name}: has a meeting point, and use case {use_case.name} has no method "
            "for hand_over"
        )
    return TaskPlan(alone, decomposer.decompose(task, first, limits, hands_over=True))


def decomposer_of(
    order: WorkOrder, use_case: UseCase, expectations: Expectations | None = None
) -> Decomposer:
    """Return the decomposer for the tasks of an order.

    Raises:
        InstanceError: if a terminal or a component that is referred to is missing.
    """
    component_of = {terminal.name: terminal.component for terminal in order.terminals}
    for terminal, component in component_of.items():
        if component not in order.components:
            raise InstanceError(f"terminal {terminal}: component {component} is missing")
    for task in order.tasks:
        for end in End:
            if task.terminals[end] not in component_of:
                raise InstanceError(
                    f"task {task.name}, end {end.letter}: no terminal {task.terminals[end]}"
                )
    return Decomposer(use_case, order.components, component_of, expectations, access=order.access)


def wiring_problem(order: WorkOrder, use_case: UseCase, plans: Sequence[TaskPlan]) -> Problem:
    """Return the planning problem of an order whose tasks are decomposed."""
    tools = [arm.tool for arm in order.arms] + [plan.alone.tool for plan in plans]
    zones = _zones(order)
    return Problem(
        name=order.name,
        speed_mm=max(1, round(use_case.cell.speed_m_s * 1e3 / TICKS_PER_S)),
        durations=Durations(
            pick=0,
            locate=_longest(plans, Macro.LOCATE),
            fix=0,
            change_tool=_ticks(use_case.cell.change_tool_s),
            extract=_ticks(use_case.cell.extract_s),
            hand_over=_longest(plans, Macro.HAND_OVER),
        ),
        weights=_NO_WEIGHTS,
        tools=tuple(dict.fromkeys(tool for tool in tools if tool)),
        arms=order.arms,
        components=tuple(order.components),
        terminals=order.terminals,
        wires=tuple(_wire(plan, order, use_case, zones[plan.alone.task.name]) for plan in plans),
        unders=order.unders,
        soft_constraints=order.soft_constraints,
        located=frozenset(order.components) - _to_locate(order, plans),
    )


def problem_left(problem: Problem, order: WorkOrder, plans: Sequence[TaskPlan]) -> Problem:
    """Return the problem of some of an order's tasks, with what follows from all of them."""
    durations = replace(
        problem.durations,
        locate=_longest(plans, Macro.LOCATE),
        hand_over=_longest(plans, Macro.HAND_OVER),
    )
    located = frozenset(order.components) - _to_locate(order, plans)
    return replace(problem, durations=durations, located=located)


def _zones(order: WorkOrder) -> dict[str, int]:
    """Return the quarter of the panel, from the left, in which each task's left end is."""
    x = {terminal.name: terminal.position_mm[0] for terminal in order.terminals}
    left, width = (
        min(x.values(), default=0),
        max(x.values(), default=0) - min(x.values(), default=0),
    )
    return {
        task.name: min(
            _ZONES - 1, _ZONES * (min(map(x.__getitem__, task.terminals)) - left) // max(1, width)
        )
        for task in order.tasks
    }


def _to_locate(order: WorkOrder, plans: Sequence[TaskPlan]) -> frozenset[str]:
    """Return the components that some task must locate."""
    component = {terminal.name: terminal.component for terminal in order.terminals}
    return frozenset(
        component[plan.alone.task.terminals[step.end]]
        for plan in plans
        for step in plan.alone.steps
        if step.macro is Macro.LOCATE and step.end is not None
    )


def _longest(plans: Sequence[TaskPlan], macro: Macro) -> int:
    """Return the longest time [ticks] of a macro operation that lasts as long for all tasks."""
    times = [0.0]
    for plan in plans:
        if macro is Macro.LOCATE:
            times += [step.expected.duration_s for step in plan.alone.steps if step.macro is macro]
        elif plan.handed_over is not None:
            times.append(plan.handed_over.expected_s(macro))
    return _ticks(max(times))


def _wire(plan: TaskPlan, order: WorkOrder, use_case: UseCase, zone: int) -> PlannedWire:
    alone, task = plan.alone, plan.alone.task
    stated = {c.name: c.default for c in use_case.task_characteristics.values()}
    characteristics = {**stated, **task.characteristics}
    inserts = [_ticks(alone.expected_s(Macro.INSERT, end)) for end in End]
    handover = None
    if plan.handed_over is not None and task.meeting_mm is not None:
        halves = [_ticks(half) for half in plan.handed_over.halves_s]
        of_a, of_b = halves if alone.first is End.A else halves[::-1]
        handover = Handover(task.meeting_mm, (of_a, of_b))
    return PlannedWire(
        name=task.name,
        terminals=task.terminals,
        colour=str(characteristics.get("colour", "")),
        tool=alone.tool or (order.arms[0].tool if order.arms else ""),
        heavy=bool(use_case.heavy.tests) and use_case.heavy.holds(characteristics),
        zone=zone,
        slot_mm=task.slot_mm,
        segments=alone.route.segments,
        route_ticks=_ticks(alone.expected_s(Macro.ROUTE)),
        insert_ticks=max(inserts),
        handover=handover,
        preferred_arm=task.preferred_arm,
        first=task.first,
        handling=Handling(
            _ticks(alone.expected_s(Macro.PICK)),
            (inserts[End.A], inserts[End.B]),
            _ticks(alone.expected_s(Macro.FIX)),
        ),
        insert_force_n=alone.force_n,
        characteristics=tuple(characteristics.items()),
        cable=str(characteristics.get("cable", "")),
    )


def _ticks(duration_s: float) -> int:
    return math.ceil(duration_s * TICKS_PER_S - 1e-9)


def _require_characteristics(order: WorkOrder, use_case: UseCase) -> None:
    for name, stated in order.components.items():
        _require(f"component {name}", stated, use_case.component_characteristics)
    for task in order.tasks:
        _require(f"task {task.name}", task.characteristics, use_case.task_characteristics)


def _require(
    what: str, stated: dict[str, Value], characteristics: dict[str, Characteristic]
) -> None:
    for name, value in stated.items():
        if name not in characteristics:
            known = ", ".join(sorted(characteristics)) or "none"
            raise InstanceError(f"{what}: no characteristic {name}; the use case has {known}")
        wrong = characteristics[name].objection(value)
        if wrong:
            raise InstanceError(f"{what}: {name} is {value}, and must be {wrong}")


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
    preferred = apply_documents(Preferred(problem, detours=yielding), documents, situations)
    return Prepared(order, use_case, limits, expectations, plans=plans, preferred=preferred)
