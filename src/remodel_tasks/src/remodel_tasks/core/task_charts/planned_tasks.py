"""The tasks of a plan in their order, each decomposed as the plan does it, whole or in part."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

from flexbe_synthesizer.core.chart.model import Chart
from remodel_production.errors import InstanceError
from remodel_tasks.core.decomposition.decomposed import Decomposition, Limits, Step
from remodel_tasks.core.decomposition.preparation import Prepared
from remodel_tasks.core.plan.listing import listing_of
from remodel_tasks.core.problem.modes import Mode
from remodel_tasks.core.problem.problem import Plan
from remodel_tasks.core.task_charts.task_chart import emptying, in_turn, step_of, task_chart
from remodel_tasks.core.use_case.designs import LONGER_LEG
from remodel_tasks.core.use_case.model import Action, Macro, UseCase
from remodel_tasks.errors import UseCaseError


@dataclass(frozen=True)
class PlannedTask:
    """A task as a plan does it.

    Attributes:
        component_of: components by the names of terminals.
        arms: the one that begins, and the one that it hands over to, if it does.
        limits: what the user's requirements forbid.
    """

    use_case: UseCase
    decomposition: Decomposition
    component_of: dict[str, str]
    arms: tuple[str, ...]
    limits: Limits

    @property
    def name(self) -> str:
        """The task's name."""
        return self.decomposition.task.name

    @property
    def chart(self) -> Chart:
        """The chart of the whole task."""
        return task_chart(self.use_case, self.decomposition, self.component_of, self.arms)

    def bounds(self, state_path: str) -> dict[str, float]:
        """Return what a state's parameters must not exceed, by their names.

        That is the force that its terminal bears, and that requirements allow.
        """
        title = step_of(state_path)
        allowed, _ = self.limits.force_n.get(self.name, (math.inf, ""))
        borne = [
            step.access.force_limit_n
            for step in self.decomposition.steps
            if step.title == title and step.access.force_limit_n is not None
        ]
        limit = min([allowed, *borne])
        return {"force_limit": limit} if limit < math.inf else {}

    def rest(self, connected: Collection[str]) -> Chart:
        """Return the chart of what is left when the ends with these letters are connected."""
        return self._part(self.left(connected), " Rest")

    def clear(self) -> Chart:
        """Return the chart that lays down whatever part the hand of each arm holds.

        An arm that refuses, such as one whose hand is empty, does not keep the other from it.
        """
        charts = []
        for give_up, arm in emptying(self.use_case, self.arms):
            inputs = tuple((k, "" if value == "$task" else value) for k, value in give_up.inputs)
            action = replace(give_up, inputs=inputs)
            charts.append(replace(self, arms=(arm,))._alone(action, " Clear"))
        return charts[0] if len(charts) == 1 else in_turn(charts)

    def discard(self) -> Chart:
        """Return the chart that takes the task's part off the panel into the scrap bin.

        Raises:
            UseCaseError: if the use case has no action for it.
        """
        name = self.use_case.discard
        if not name:
            raise UseCaseError(
                f"task {self.name}: use case {self.use_case.name} states no `discard` action, so "
                "its part cannot be discarded: take it out by hand, or add the action"
            )
        return self._alone(self.use_case.actions[name], " Discard")

    def left(self, connected: Collection[str]) -> tuple[Step, ...]:
        """Return the steps that are left when the ends with these letters are connected.

        What earlier steps have revealed, and the remaining ones need, is observed again.

        Raises:
            ValueError: if only the end is connected that this task connects last, see
                `continuing_from`.
        """
        if connected and self.decomposition.first.letter not in connected:
            raise ValueError(f"task {self.name} connects {self.decomposition.first.letter} first")
        steps = self.decomposition.steps
        done = [
            number
            for number, step in enumerate(steps, 1)
            if step.macro is Macro.INSERT and step.end is not None and step.end.letter in connected
        ]
        begin = max(done, default=0)
        return (*_observations(steps[:begin], steps[begin:]), *steps[begin:])

    def _alone(self, action: Action, suffix: str) -> Chart:
        """Return the chart of one action that is about no end and no clip."""
        last = self.decomposition.steps[-1]
        return self._part((replace(last, action=action, end=None, clip=None),), suffix)

    def _part(self, steps: tuple[Step, ...], suffix: str) -> Chart:
        done = replace(self.decomposition, steps=steps)
        return task_chart(self.use_case, done, self.component_of, self.arms, suffix=suffix)


def planned_tasks(prepared: Prepared, plan: Plan) -> Iterator[PlannedTask]:
    """Yield the tasks of a valid plan, in the order in which they are begun."""
    listing = listing_of(prepared.preferred.problem, plan)
    for name in listing.wires:
        mode = listing.modes[name]
        known = prepared.decomposition(name, mode)
        yield planned_task(prepared, name, mode, known if known.first is mode.first else None)


def planned_task(
    prepared: Prepared, name: str, mode: Mode, known: Decomposition | None = None
) -> PlannedTask:
    """Return a task as a plan does it.

    Args:
        prepared: the order that the task is of.
        name: of the task.
        mode: in which it is planned.
        known: its decomposition; None: decomposed here, by what is expected now.
    """
    task = prepared.plan_of[name].alone.task
    decomposition = known or prepared.decomposer.decompose(
        task, mode.first, prepared.limits, hands_over=mode.hands_over
    )
    names = [arm.name for arm in prepared.order.arms]
    arms = names[mode.arm : mode.arm + 1]
    if mode.hands_over:
        arms.append(names[1 - mode.arm])
    return PlannedTask(
        prepared.use_case, decomposition, prepared.component_of, tuple(arms), limits=prepared.limits
    )


def continuing_from(
    prepared: Prepared, planned: PlannedTask, connected: Collection[str]
) -> PlannedTask:
    """Return a task that connects first what is connected already, such as by another plan.

    Args:
        prepared: the order that the task is of.
        planned: the task.
        connected: letters of the ends that sit in their terminals.

    Raises:
        InstanceError: if no method of the use case begins with that end.
    """
    first = planned.decomposition.first
    if not connected or first.letter in connected:
        return planned
    hands_over = len(planned.arms) > 1
    other = prepared.decomposer.decompose(
        planned.decomposition.task, first.other, prepared.limits, hands_over=hands_over
    )
    return replace(planned, decomposition=other, arms=planned.arms[::-1])


def with_other_end(prepared: Prepared, planned: PlannedTask) -> PlannedTask | None:
    """Return a task whose other end comes first; None if its use case does not let it.

    Args:
        prepared: the order that the task is of.
        planned: the task.
    """
    designs = prepared.use_case.designs
    if designs is not None and designs.first not in (None, LONGER_LEG):
        return None
    try:
        return continuing_from(prepared, planned, planned.decomposition.first.other.letter)
    except InstanceError:
        return None


def with_other_method(
    prepared: Prepared, planned: PlannedTask, state_path: str
) -> PlannedTask | None:
    """Return a task with another method for the step that failed; None if there is none.

    Args:
        prepared: the order that the task is of.
        planned: the task.
        state_path: of the state that failed, in the task's behavior.
    """
    decomposition = planned.decomposition
    failed = step_of(state_path)
    steps = [step for step in decomposition.steps if step.title == failed]
    methods = {steps[0].methods[-1]: "it has failed"} if steps and steps[0].methods else {}
    if not methods:
        return None
    limits = prepared.limits.and_those(Limits(methods=methods))
    hands_over = len(planned.arms) > 1
    try:
        other = prepared.decomposer.decompose(
            decomposition.task, decomposition.first, limits, hands_over=hands_over
        )
    except InstanceError:
        return None
    return replace(planned, decomposition=other)


def _observations(before: Sequence[Step], left: Sequence[Step]) -> tuple[Step, ...]:
    """Return the steps before whose findings are needed, also by each other, in their order."""
    chosen: set[int] = set()
    while True:
        observations = tuple(before[number] for number in sorted(chosen))
        needed = set(_sources(before, (*observations, *left)))
        if needed <= chosen:
            return observations
        chosen |= needed


def _sources(before: Sequence[Step], steps: Sequence[Step]) -> Iterator[int]:
    """Yield which steps before reveal what some steps need and do not reveal themselves."""
    known: set[str] = set()
    for step in steps:
        for fact in {fact for fact, _ in step.action.needs} - known:
            revealing = [
                number
                for number, earlier in enumerate(before)
                if fact in (name for name, _ in earlier.action.reveals)
            ]
            yield from revealing[-1:]
        known |= {fact for fact, _ in step.action.reveals}
