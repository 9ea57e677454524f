"""A chart with all that its states and behaviors name: their classes, and so what they offer."""

from __future__ import annotations

import posixpath
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeVar

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Behavior,
    Chart,
    Container,
    ContainerKind,
    Input,
    Literal,
    Node,
    Output,
    State,
    as_declared,
    quick,
    walk_nodes,
)
from flexbe_synthesizer.core.chart.names import EXHAUSTED, PREEMPTED, TIMED_OUT
from flexbe_synthesizer.core.chart.problem import Problem, ProblemKind
from flexbe_synthesizer.core.library.data_flow import (
    DataFlow,
    Scope,
    Support,
    Use,
    UsedNode,
    arguments,
    bind_data,
)
from flexbe_synthesizer.core.library.definite_assignment import Values, outcome_effects
from flexbe_synthesizer.core.library.graph import Graph, chart_graph, looping_nodes
from flexbe_synthesizer.core.library.signature import (
    BehaviorClass,
    Effect,
    Library,
    Port,
    Signature,
    StateClass,
    Unreadable,
    behavior_signature,
    state_signature,
)


@quick
@dataclass(frozen=True, eq=False, slots=True)
class ResolvedNode(UsedNode):
    """A node of a chart with what it names; `body` is the content of a container."""

    body: ResolvedChart | None = None


@dataclass(frozen=True, eq=False)
class ResolvedChart(Scope):
    """A chart with all its names looked up.

    Attributes:
        error_names: error codes by the names of codes and of classes of codes.
        is_inner: it is the content of a container.
        support: the state classes that the extensions it uses are lowered to.
    """

    by_id: Mapping[str, ResolvedNode]
    nodes: tuple[ResolvedNode, ...] = ()
    support: Mapping[Support, StateClass] = field(default_factory=dict)
    error_names: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    is_inner: bool = False

    @cached_property
    def flow(self) -> DataFlow:
        """Return where each value of the chart lives."""
        return bind_data(self)

    @cached_property
    def graph(self) -> Graph:
        """Return what leads where."""
        return chart_graph(self)

    @cached_property
    def values(self) -> Values:
        """Return who writes which value, and when it is written."""
        return Values(self, self.flow, self.graph)

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """Return what each of its outcomes writes; nothing without outputs."""
        outputs = frozenset(port.name for port in self.chart.outputs if port.name)
        return outcome_effects(self, outputs, self.values) if outputs else ()

    @property
    def title(self) -> str:
        """Return what messages call it: the chart itself, or a container in it."""
        return f"container '{self.chart.name}'" if self.is_inner else "the chart"


def scopes(resolved: ResolvedChart) -> Iterator[ResolvedChart]:
    """Yield the chart and the content of each container in it, outer ones first."""
    yield resolved
    for entry in resolved.nodes:
        if entry.body is not None:
            yield from scopes(entry.body)


def given_values(entry: ResolvedNode) -> dict[str, Literal]:
    """Return the values that a node gives to its class; texts where these are declared strings."""
    values = arguments(entry.node, entry.use.is_timed)
    for param in entry.node.params:
        if param.name in entry.use.taking_text and param.spelled:
            values[param.name] = as_declared(param.spelled, "string")
    return values


def included_path(chart: Chart, node: Node) -> str | None:
    """Return the path of the chart that a behavior names, None if it names no chart."""
    if not isinstance(node, Behavior) or not node.type.endswith(".xml"):
        return None
    return posixpath.normpath(posixpath.join(posixpath.dirname(chart.file), node.type))


def named_behaviors(
    chart: Chart, library: Library, charts: Mapping[str, BehaviorClass]
) -> Iterator[BehaviorClass]:
    """Yield what the behaviors in a chart can be.

    Args:
        chart: what names them.
        library: what is on the ROS package path.
        charts: the behaviors that other charts become, by path.
    """
    for node in walk_nodes(chart):
        if isinstance(node, Behavior):
            path = included_path(chart, node)
            named = library.find_behaviors(node.type) if path is None else (charts.get(path),)
            yield from (one for one in named if isinstance(one, BehaviorClass))


# Look up what each state and behavior of a chart names, and what a container offers


_Found = TypeVar("_Found", StateClass, BehaviorClass)


def resolve_chart(
    chart: Chart,
    library: Library,
    charts: Mapping[str, BehaviorClass],
    effects_of: Callable[[BehaviorClass], tuple[Effect, ...]],
) -> tuple[ResolvedChart, tuple[Problem, ...]]:
    """Return the chart with its names looked up, and a problem for each name not found.

    Args:
        chart: what to look up.
        library: what is on the ROS package path.
        charts: the behaviors that other charts become, by path.
        effects_of: returns what the outcomes of a behavior write.
    """
    lookup = _Lookup(chart, library, charts, effects_of)
    resolved = lookup.scope(chart, ContainerKind.SEQUENCE)
    lookup.problems.extend(_check_imports(resolved))
    return resolved, tuple(lookup.problems)


class _Lookup:
    """The search for what the nodes of one file name."""

    def __init__(
        self,
        chart: Chart,
        library: Library,
        charts: Mapping[str, BehaviorClass],
        effects_of: Callable[[BehaviorClass], tuple[Effect, ...]],
    ) -> None:
        self._chart = chart
        self._effects_of = effects_of
        self._library = library
        self._charts = charts
        self._support: dict[Support, StateClass | None] = {}
        self._uses: dict[tuple[str, bool, bool], Use] = {}
        self.problems: list[Problem] = []

    def scope(self, chart: Chart, runs: ContainerKind, is_repeated: bool = False) -> ResolvedChart:
        """Return a chart, or the content of a container, with its names looked up."""
        containers = {node.id for node in chart.nodes if isinstance(node, Container)}
        repeated = containers if is_repeated or not containers else looping_nodes(chart)
        nodes = tuple([self._node(node, node.id in repeated) for node in chart.nodes])
        by_id: dict[str, ResolvedNode] = {}
        support: dict[Support, StateClass] = {}
        for entry in nodes:
            if entry.node.id:
                by_id.setdefault(entry.node.id, entry)
            if entry.node.attempts is not None or entry.use.is_timed or entry.node.on_error:
                for wanted in _wanted_support(entry):
                    found = self._find_support(wanted, entry.node)
                    if found is not None:
                        support[wanted] = found
        is_inner = chart is not self._chart
        error_names = self._library.error_names
        return ResolvedChart(
            chart,
            by_id,
            runs=runs,
            nodes=nodes,
            support=support,
            error_names=error_names,
            is_inner=is_inner,
            is_repeated=is_repeated,
        )

    def _node(self, node: AnyNode, is_repeated: bool) -> ResolvedNode:
        if isinstance(node, Container):
            body = self.scope(node.body, node.runs, is_repeated)
            use = _use(node, None, _body_signature(node, body), is_timed=node.timeout_s is not None)
            return ResolvedNode(node, use, body)
        if not node.type:
            return ResolvedNode(node, Use())
        if isinstance(node, Behavior):
            return self._behavior(node)
        if node.inputs or node.outputs:
            return ResolvedNode(node, _use_state(node, self._library, self.problems))
        likeness = (node.type, node.timeout_s is None, node.attempts is None)
        known = self._uses.get(likeness)
        if known is not None:
            return ResolvedNode(node, known)
        use = _use_state(node, self._library, self.problems)
        if use.is_like_others:
            self._uses[likeness] = use
        return ResolvedNode(node, use)

    def _behavior(self, node: Behavior) -> ResolvedNode:
        path = included_path(self._chart, node)
        if path is not None:
            if path in self._charts:
                return self._with_behavior(node, self._charts[path])
            message = f"the chart '{node.type}' could not be read."
            self.problems.append(
                Problem(node.position("type"), ProblemKind.UNKNOWN_BEHAVIOR, message)
            )
            return ResolvedNode(node, Use())
        known = self._library.behaviors
        candidates = self._library.find_behaviors(node.type)
        behavior = _only(node, candidates, self.problems)
        if not candidates:
            hint = names.allowed(node.type, sorted({b.name for b in known}))
            message = f"no behavior '{node.type}' on the ROS package path; {hint}"
            self.problems.append(
                Problem(node.position("type"), ProblemKind.UNKNOWN_BEHAVIOR, message)
            )
            meant = names.misspelt(node.type, (b.name for b in known))
            behavior = next((b for b in known if b.name == meant), None)
        return (
            ResolvedNode(node, Use()) if behavior is None else self._with_behavior(node, behavior)
        )

    def _with_behavior(self, node: Behavior, behavior: BehaviorClass) -> ResolvedNode:
        signature = behavior_signature(behavior, self._effects_of(behavior))
        is_timed = node.timeout_s is not None
        return ResolvedNode(node, _use(node, behavior, signature, is_timed=is_timed))

    def _find_support(self, wanted: Support, node: AnyNode) -> StateClass | None:
        """Return the state class that an extension is lowered to; report once if missing."""
        if wanted in self._support:
            return self._support[wanted]
        found = self._library.find_states(f"{wanted.package}/{wanted.class_name}")
        one = found[0] if len(found) == 1 and isinstance(found[0], StateClass) else None
        self._support[wanted] = one
        if one is None:
            message = f"ext:{wanted.extension} needs the state class {wanted.class_name} of "
            message += f"package {wanted.package}, which is not on the ROS package path; build and "
            message += "source the workspace that has it."
            self.problems.append(
                Problem(node.position(wanted.extension), ProblemKind.UNKNOWN_CLASS, message)
            )
        return one


def _wanted_support(entry: ResolvedNode) -> Iterator[Support]:
    """Yield the state classes that a node's extensions need."""
    if entry.node.attempts is not None:
        yield Support.COUNTER
    if entry.use.is_timed:
        yield Support.TIMER
    if entry.node.on_error:
        yield Support.CHOOSER


def _body_signature(node: Container, body: ResolvedChart) -> Signature:
    """Return what a container offers to the chart around it: its datamodel."""
    return Signature(
        f"container '{node.id}'",
        tuple(dict.fromkeys(o.name for o in node.body.outcomes if o.name and o.name != PREEMPTED)),
        inputs=tuple(Port(port.name, port.type) for port in node.body.inputs if port.name),
        outputs=tuple(Port(port.name, port.type) for port in node.body.outputs if port.name),
        parameters=(),
        effects=body.effects,
    )


def _use_state(node: State, library: Library, problems: list[Problem]) -> Use:
    candidates = library.find_states(node.type)
    state = _only(node, candidates, problems)
    if not candidates:
        hint = names.allowed(node.type, sorted({s.name for s in library.states}))
        message = f"no state class '{node.type}' on the ROS package path; {hint}"
        problems.append(Problem(node.position("type"), ProblemKind.UNKNOWN_CLASS, message))
        # What follows is checked as if a misspelt name were mended.
        meant = names.misspelt(node.type, (s.name for s in library.states))
        state = next((s for s in library.states if s.name == meant), None)
    if state is None:
        return Use()
    is_timed = node.timeout_s is not None and all(p.name != "timeout_s" for p in state.parameters)
    signature = state_signature(state, arguments(node, is_timed))
    return _use(node, state, signature, is_timed=is_timed, is_qualified=node.type != state.name)


def _use(
    node: AnyNode,
    declaration: StateClass | BehaviorClass | None,
    signature: Signature,
    *,
    is_timed: bool,
    is_qualified: bool = False,
) -> Use:
    added = (TIMED_OUT,) * is_timed + (EXHAUSTED,) * (node.attempts is not None)
    inputs, outputs = _typed(signature.inputs, node.inputs), _typed(signature.outputs, node.outputs)
    return Use(
        declaration,
        signature,
        is_qualified=is_qualified,
        is_timed=is_timed,
        added_events=added,
        inputs=inputs,
        outputs=outputs,
    )


def _typed(offered: tuple[Port, ...], declared: Sequence[Input | Output]) -> Mapping[str, Port]:
    """Return the ports by name, with the types that the chart declares for them."""
    types = {port.name: port.type for port in declared if port.type}
    return {p.name: replace(p, type=types[p.name]) if p.name in types else p for p in offered}


def _only(
    node: Node, candidates: tuple[_Found | Unreadable, ...], problems: list[Problem]
) -> _Found | None:
    """Return the one candidate; report several, or one that cannot be used."""
    is_state = isinstance(node, State)
    if len(candidates) > 1:
        spelled = (f"{c.package}/{c.name}" for c in candidates)
        many = names.quoted(sorted(spelled))
        mend = "write package/Class" if is_state else "name its chart's path, or rename one"
        code = ProblemKind.AMBIGUOUS_CLASS if is_state else ProblemKind.AMBIGUOUS_BEHAVIOR
        message = f"'{node.type}' can be any of {many}; {mend}."
        problems.append(Problem(node.position("type"), code, message))
        return None
    found = candidates[0] if candidates else None
    if isinstance(found, Unreadable):
        code = ProblemKind.UNREADABLE_CLASS if is_state else ProblemKind.UNREADABLE_BEHAVIOR
        message = f"'{node.type}' of package {found.package} cannot be used: {found.reason}."
        problems.append(Problem(node.position("type"), code, message))
        return None
    return found


def _check_imports(resolved: ResolvedChart) -> Iterator[Problem]:
    """Report behaviors that cannot be used side by side, since their classes have one name."""
    chart = resolved.chart
    users = {names.behavior_class(chart.name): chart.name}
    for entry in (entry for scope in scopes(resolved) for entry in scope.nodes):
        if isinstance(entry.use.declaration, BehaviorClass):
            class_name, name = entry.use.declaration.class_name, entry.use.declaration.name
            if users.setdefault(class_name, name) != name:
                message = f"behavior '{entry.node.type}' and another behavior in or around this "
                message += f"chart both have the class {class_name}; rename one of them."
                position = entry.node.position("type")
                yield Problem(position, ProblemKind.DUPLICATE_BEHAVIOR, message)
