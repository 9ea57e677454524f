"""The tasks of a plan in their order, each decomposed as the plan does it, whole or in part.

And what their charts leave to the supervisor (`escalating`) and demand of a cell (`demands_of`), so
that it can refuse an order before it moves.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from flexbe_synthesizer.core.chart.error_routes import ABOVE_BEHAVIOR, SERIOUS
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Chart,
    Connection,
    ErrorRoute,
    State,
    Transition,
    walk_nodes,
)
from remodel_production.errors import InstanceError
from remodel_states.core.contract import ROBOT_FIELDS
from remodel_tasks.core.decomposition.decomposed import Decomposition, Limits, Step
from remodel_tasks.core.decomposition.preparation import Prepared
from remodel_tasks.core.plan.explanation import listing_of
from remodel_tasks.core.problem.problem import Mode, Plan
from remodel_tasks.core.task_charts.task_chart import emptying, in_turn, marked, step_of, task_chart
from remodel_tasks.core.use_case.model import LONGER_LEG, Action, Macro, UseCase
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
    """Return a task that connects first the ends that are connected, such as by another plan.

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
    """Return a task whose other end comes first; None if its use case does not let it."""
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
    """Return a task with another method for the step that failed; None if there is none."""
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


_FAILED, _REFUSED = "failed", "command_error"


def escalating(chart: Chart) -> Chart:
    """Return a task's chart in which what a supervisor handles first is not tried again.

    Such failures lead to where the state is given up: to where a goal leads that is refused. Where
    a failure is undone before the state is tried again, such as an insertion by an extraction, it
    is undone before the state is given up as well: a wire that is jammed in its terminal cannot be
    carried away. What is serious is left as it is: the arm may be blocked, or its server
    unreliable.
    """
    nodes = {node.id: node for node in chart.nodes}
    leaving: list[AnyNode] = []
    last: dict[str, State] = {}
    for node in chart.nodes:
        undoing = _undoing(node, nodes)
        if undoing is not None:
            last[undoing.id] = _at_last(undoing)
        leaving.append(_leaving(node, last[undoing.id].id if undoing else ""))
    connections = tuple(
        Connection(each.output_state_id, each.output, last[each.input_state_id].id, each.input)
        for each in chart.connections
        if each.input_state_id in last
    )
    return marked(
        replace(
            chart,
            nodes=(*leaving, *last.values()),
            connections=(*chart.connections, *connections),
        )
    )


def _undoing(node: AnyNode, nodes: dict[str, AnyNode]) -> State | None:
    """Return the state that undoes the failure of a state before it is tried again, if any.

    It stands beside the sequence: it has no outputs, and is given up where the failed one is.
    """
    if not isinstance(node, State):
        return None
    targets = _targets(node)
    undoing = nodes.get(targets.get(_FAILED, ""))
    if not isinstance(undoing, State) or undoing.outputs:
        return None
    up = targets.get(_REFUSED)
    goes_on = set(_targets(undoing).values()) - {up}
    return undoing if goes_on and _targets(undoing).get(_FAILED) == up else None


def _at_last(undoing: State) -> State:
    """Return a state that undoes a failure, after which the task is given up."""
    up = _targets(undoing)[_FAILED]
    transitions = tuple(Transition(each.event, up) for each in undoing.transitions)
    return replace(undoing, id=f"{undoing.id} and give up", transitions=transitions)


def _leaving(node: AnyNode, undo: str) -> AnyNode:
    """Return a node that is left with such codes; through the node `undo` if there is one."""
    if not isinstance(node, State) or node.on_error:
        return node
    targets = _targets(node)
    up = targets.get(_REFUSED)
    if up is None or _FAILED not in targets or targets[_FAILED] == up:
        return node
    if not undo:
        return replace(node, on_error=(ErrorRoute(ABOVE_BEHAVIOR, up),))
    routes = (ErrorRoute(SERIOUS, up), ErrorRoute(ABOVE_BEHAVIOR, undo))
    return replace(node, on_error=routes)


def _targets(node: State) -> dict[str, str]:
    return {transition.event: transition.target for transition in node.transitions}


# Parameter of states that limits a force.
_FORCE = "force_limit"


@dataclass(frozen=True)
class Demands:
    """What goals of an order ask for.

    Attributes:
        robots: names, sorted.
        forces_n: abilities with the greatest `force_limit` [N] of their goals, sorted by name.
    """

    robots: tuple[str, ...] = ()
    forces_n: tuple[tuple[str, float], ...] = ()


def demands_of(charts: Iterable[Chart]) -> Demands:
    """Return what the states of charts demand, as far as the charts themselves state it."""
    robots: set[str] = set()
    forces_n: dict[str, float] = {}
    for chart in charts:
        for node in walk_nodes(chart):
            if not isinstance(node, State):
                continue
            ability = node.type.removesuffix("State")
            for param in node.params:
                if param.name in ROBOT_FIELDS:
                    robots.add(str(param.value))
                elif param.name == _FORCE and isinstance(param.value, int | float):
                    forces_n[ability] = max(forces_n.get(ability, 0.0), float(param.value))
    return Demands(tuple(sorted(robots)), tuple(sorted(forces_n.items())))
