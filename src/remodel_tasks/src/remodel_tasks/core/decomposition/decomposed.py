"""A task taken apart: its steps, what was rejected for them, and the limits that were kept.

`outline` describes it as text.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from remodel_tasks.core.condition import Features
from remodel_tasks.core.orders.work_order import (
    Access,
    Route,
    RouteClip,
    Task,
    WorkOrder,
    plain_name,
)
from remodel_tasks.core.problem.problem import End
from remodel_tasks.core.use_case.model import Action, Expectation, Macro


@dataclass(frozen=True)
class Limits:
    """What the user's requirements forbid, each with the requirement's name.

    Attributes:
        force_n: [N] the most with which a task's ends may be pushed in.
        segments: through which nothing may be routed.
        methods: (task, method) that must not be taken, each with the reason.
    """

    force_n: dict[str, tuple[float, str]] = field(default_factory=dict)
    segments: dict[str, str] = field(default_factory=dict)
    methods: dict[tuple[str, str], str] = field(default_factory=dict)

    def __bool__(self) -> bool:
        """Return whether anything is forbidden."""
        return bool(self.force_n or self.segments or self.methods)

    def objection(self, decomposition: Decomposition) -> str:
        """Return the name of a requirement that a decomposition violates; empty if none."""
        limit, name = self.force_n.get(decomposition.task.name, (decomposition.force_n, ""))
        if decomposition.force_n > limit:
            return name
        barred = (s for s in decomposition.route.segments if s in self.segments)
        return next((self.segments[segment] for segment in barred), "")

    def and_those(self, other: Limits) -> Limits:
        """Return these limits and others; of two forces the lesser."""
        forces = dict(self.force_n)
        for task, limit in other.force_n.items():
            forces[task] = min(limit, forces.get(task, limit))
        segments = {**self.segments, **other.segments}
        return Limits(forces, segments, {**self.methods, **other.methods})


@dataclass(frozen=True)
class Step:
    """An action in its place.

    Attributes:
        end: that it is about, if one.
        clip: that it is about, if one.
        route: the part of the task's route on which it is done.
        methods: the chosen method of each task above it, from the macro operation down.
        expected: of all its attempts.
        access: to the terminal that it is about.
        features: by which its expectation was asked for.
    """

    macro: Macro
    action: Action
    end: End | None
    clip: RouteClip | None
    route: Route
    methods: tuple[tuple[str, str], ...]
    expected: Expectation
    access: Access
    features: Features = field(compare=False)

    @property
    def force_n(self) -> float:
        """The force [N] with which it pushes at most, as far as the terminal bears it."""
        limit = self.access.force_limit_n
        return self.action.force_n if limit is None else min(limit, self.action.force_n)

    @property
    def title(self) -> str:
        """Its name in the task, unique in its task but for actions done twice to one end."""
        title = self.action.title.replace("{end}", self.end.letter if self.end is not None else "")
        return f"{title} {plain_name(self.clip.name)}" if self.clip else title.strip()


@dataclass(frozen=True)
class Rejected:
    """An alternative that was not taken, and why."""

    task: str
    method: str
    reason: str


@dataclass(frozen=True)
class Decomposition:
    """What a task comes down to, from the first end to the second.

    Attributes:
        rejected: alternatives, in the order in which they were met.
    """

    task: Task
    route: Route
    first: End
    steps: tuple[Step, ...]
    cost_s: float
    rejected: tuple[Rejected, ...]

    def expected_s(self, macro: Macro, end: End | None = None) -> float:
        """Return how long a macro operation is expected to take [s]; an insertion, of one end."""
        return sum(
            step.expected.duration_s
            for step in self.steps
            if step.macro is macro and (macro is not Macro.INSERT or step.end is end)
        )

    @cached_property
    def duration_s(self) -> float:
        """How long all of it is expected to take [s]."""
        return sum(step.expected.duration_s for step in self.steps)

    @property
    def halves_s(self) -> tuple[float, float]:
        """How long routing takes before and after the task is handed over [s]."""
        given = [i for i, step in enumerate(self.steps) if step.macro is Macro.HAND_OVER]
        before, after = self.steps[: given[0]], self.steps[given[-1] :]
        routed = [
            sum(step.expected.duration_s for step in half if step.macro is Macro.ROUTE)
            for half in (before, after)
        ]
        return routed[0], routed[1]

    @property
    def tool(self) -> str:
        """The tool that its actions need; empty: any."""
        return next((step.action.tool for step in self.steps if step.action.tool), "")

    @property
    def force_n(self) -> float:
        """The greatest force [N] with which a step pushes."""
        return max((step.force_n for step in self.steps), default=0.0)


def outline_of_order(order: WorkOrder, plans: Sequence[Decomposition]) -> Iterator[str]:
    """Yield the tasks of an order, a cable as one task whose cores are its steps, line by line."""
    plan_of = {plan.task.name: plan for plan in plans}
    for task in order.whole_tasks:
        cores = [plan_of[wire] for wire in task.wires]
        if not task.is_cable:
            yield from outline(*cores)
            continue
        seconds = sum(core.duration_s for core in cores)
        yield f"{task.name}: cable of {len(cores)} cores, {seconds:.1f} s of work, one task"
        for core in cores:
            yield from (f"  {line}" for line in outline(core))


def outline(decomposition: Decomposition) -> Iterator[str]:
    """Yield a task as a tree of methods and actions, line by line."""
    task = decomposition.task
    success = math.prod(step.expected.success for step in decomposition.steps)
    yield (
        f"{task.name}: {' to '.join(task.terminals)}, {decomposition.duration_s:.1f} s of work, "
        f"succeeds in {100 * success:.0f} % of cases"
    )
    shown: tuple[tuple[str, str], ...] = ()
    end = None
    for step in decomposition.steps:
        if step.end is not end:
            shown, end = (), step.end
        for depth, (name, method) in enumerate(step.methods):
            if step.methods[: depth + 1] != shown[: depth + 1]:
                yield f"{'  ' * (depth + 1)}{name}: {method}"
        shown = step.methods
        yield (
            f"{'  ' * (len(step.methods) + 1)}{step.title} ({', '.join(step.action.abilities)}), "
            f"{step.expected.duration_s:.1f} s"
        )
    for rejected in decomposition.rejected:
        yield f"  rejected: {rejected.task}: {rejected.method}: {rejected.reason}"
