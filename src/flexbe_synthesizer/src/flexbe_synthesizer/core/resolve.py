"""Find what each state and behavior of a chart names: its class, and so what it offers."""

from __future__ import annotations

import posixpath
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property
from typing import TypeVar

from flexbe_synthesizer.core import names
from flexbe_synthesizer.core.data_flow import DataFlow, bind_data
from flexbe_synthesizer.core.library import Library
from flexbe_synthesizer.core.literal import Literal
from flexbe_synthesizer.core.model import (
    AnyNode,
    Behavior,
    Chart,
    Container,
    ContainerKind,
    Input,
    Node,
    Output,
    State,
)
from flexbe_synthesizer.core.names import PREEMPTED
from flexbe_synthesizer.core.problem import Code, Problem
from flexbe_synthesizer.core.quick import quick
from flexbe_synthesizer.core.signature import (
    BehaviorClass,
    Port,
    Signature,
    StateClass,
    Unreadable,
    behavior_signature,
    state_signature,
)

EXHAUSTED = "exhausted"
TIMED_OUT = "timed_out"
FAILED = "failed"  # the event that ext:on_error parts by code
ERROR_CODE = "error_code"  # the output that holds the code


class Support(Enum):
    """The state classes that extensions are expanded with: package, class, extension."""

    COUNTER = ("remodel_states", "CountAttemptsState", "attempts")
    TIMER = ("flexbe_states", "WaitState", "timeout_s")
    CHOOSER = ("flexbe_states", "DecisionState", "on_error")

    def __init__(self, package: str, class_name: str, extension: str) -> None:
        """Name the parts of the value."""
        self.package = package
        self.class_name = class_name
        self.extension = extension


_Found = TypeVar("_Found", StateClass, BehaviorClass)


@dataclass(frozen=True, eq=False)
class Use:
    """What a node names, and what that offers it; nodes that are used alike share one.

    Attributes:
        declaration: class of the state or behavior; None of a container, or if it was not found.
        signature: what it offers; None if the declaration was not found.
        is_qualified: the chart names the package of the state class.
        is_timed: its timeout is kept by a timer beside it, not by its own class.
        added_events: the events that extensions add, even if the class has them already.
        inputs: by name, with the types that the chart declares for them.
        outputs: by name, with the types that the chart declares for them.
    """

    declaration: StateClass | BehaviorClass | None = None
    signature: Signature | None = None
    is_qualified: bool = False
    is_timed: bool = False
    added_events: tuple[str, ...] = ()
    inputs: Mapping[str, Port] = field(default_factory=dict)
    outputs: Mapping[str, Port] = field(default_factory=dict)

    @cached_property
    def events(self) -> tuple[str, ...] | None:
        """Return the events that need a transition, None if its outcomes are not known."""
        if self.signature is None or self.signature.outcomes is None:
            return None
        return tuple(dict.fromkeys((*self.signature.outcomes, *self.added_events)))

    @cached_property
    def is_like_others(self) -> bool:
        """Tell whether what it offers is the same whatever values its parameters have."""
        return (
            isinstance(self.declaration, StateClass)
            and not self.declaration.depends_on_values
            and not self.taking_source
        )

    @cached_property
    def taking_source(self) -> frozenset[str]:
        """Return the parameters that take Python source."""
        offered = self.signature.parameters if self.signature else ()
        return frozenset(parameter.name for parameter in offered if parameter.takes_source)

    def has_own(self, event: str) -> bool:
        """Tell whether the event is an outcome of its class."""
        return self.signature is not None and event in (self.signature.outcomes or ())


@quick
@dataclass(frozen=True, eq=False, slots=True)
class ResolvedNode:
    """A node of a chart with what it names; `body` is the content of a container."""

    node: AnyNode
    use: Use
    body: ResolvedChart | None = None


@dataclass(frozen=True, eq=False)
class ResolvedChart:
    """A chart with all its names looked up.

    Attributes:
        runs: how it runs what is in it; the chart of a file is a sequence.
        is_inner: it is the content of a container.
        support: the state classes that the extensions it uses are expanded with.
        by_id: the nodes in document order, of two with one id the first.
    """

    chart: Chart
    nodes: tuple[ResolvedNode, ...]
    runs: ContainerKind = ContainerKind.SEQUENCE
    support: Mapping[Support, StateClass] = field(default_factory=dict)
    by_id: Mapping[str, ResolvedNode] = field(default_factory=dict)
    is_inner: bool = False

    @cached_property
    def flow(self) -> DataFlow:
        """Return where each value of the chart lives."""
        return bind_data(self)

    @cached_property
    def ids(self) -> names.Vocabulary:
        """Return the ids of the nodes."""
        return names.Vocabulary(self.by_id)

    @cached_property
    def targets(self) -> names.Vocabulary:
        """Return what transitions can lead to."""
        outcomes = (outcome.name for outcome in self.chart.outcomes)
        return names.Vocabulary(dict.fromkeys((*self.by_id, *outcomes)))

    @cached_property
    def connectable(self) -> names.Vocabulary:
        """Return what connections can come from and lead to."""
        return names.Vocabulary((*self.by_id, self.chart.name))

    @property
    def title(self) -> str:
        """Return what messages call it: the chart itself, or a container in it."""
        return f"container '{self.chart.name}'" if self.is_inner else "the chart"

    @property
    def is_concurrent(self) -> bool:
        """Tell whether all that is in it runs at the same time."""
        return self.runs is ContainerKind.CONCURRENCY


def scopes(resolved: ResolvedChart) -> Iterator[ResolvedChart]:
    """Yield the chart and the content of each container in it, outer ones first."""
    yield resolved
    for entry in resolved.nodes:
        if entry.body is not None:
            yield from scopes(entry.body)


def label(node: Node) -> str:
    """Return kind and id of a node for messages."""
    return f"{node.kind} '{node.id}'"


def arguments(node: AnyNode, is_timed: bool) -> dict[str, Literal]:
    """Return the values that a node gives to its class, by parameter name."""
    values = {param.name: param.value for param in node.params}
    if isinstance(node, State) and node.topic is not None:
        values["topic"] = node.topic
    if isinstance(node, State) and node.timeout_s is not None and not is_timed:
        values["timeout_s"] = node.timeout_s
    return values


def included_path(chart: Chart, node: Node) -> str | None:
    """Return the path of the chart that a behavior names, None if it names no chart."""
    if not isinstance(node, Behavior) or not node.type.endswith(".xml"):
        return None
    return posixpath.normpath(posixpath.join(posixpath.dirname(chart.file), node.type))


def resolve_chart(
    chart: Chart, library: Library, charts: Mapping[str, BehaviorClass]
) -> tuple[ResolvedChart, tuple[Problem, ...]]:
    """Return the chart with its names looked up, and a problem for each name not found.

    Args:
        chart: what to look up.
        library: what is on the ROS package path.
        charts: the behaviors that other charts become, by path.
    """
    lookup = _Lookup(chart, library, charts)
    resolved = lookup.scope(chart, ContainerKind.SEQUENCE)
    lookup.problems.extend(_check_imports(resolved))
    return resolved, tuple(lookup.problems)


class _Lookup:
    """The search for what the nodes of one file name."""

    def __init__(self, chart: Chart, library: Library, charts: Mapping[str, BehaviorClass]) -> None:
        self._chart = chart
        self._library = library
        self._charts = charts
        self._support: dict[Support, StateClass | None] = {}
        self._uses: dict[tuple[str, bool, bool], Use] = {}
        self.problems: list[Problem] = []

    def scope(self, chart: Chart, runs: ContainerKind) -> ResolvedChart:
        """Return a chart, or the content of a container, with its names looked up."""
        nodes = tuple(self._node(node) for node in chart.nodes)
        by_id: dict[str, ResolvedNode] = {}
        support: dict[Support, StateClass] = {}
        for entry in nodes:
            if entry.node.id:
                by_id.setdefault(entry.node.id, entry)
            for wanted in _wanted_support(entry):
                found = self._find_support(wanted, entry.node)
                if found is not None:
                    support[wanted] = found
        return ResolvedChart(chart, nodes, runs, support, by_id, chart is not self._chart)

    def _node(self, node: AnyNode) -> ResolvedNode:
        if isinstance(node, Container):
            body = self.scope(node.body, node.runs)
            use = _use(node, None, _body_signature(node), is_timed=node.timeout_s is not None)
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
                return _with_behavior(node, self._charts[path])
            message = f"the chart '{node.type}' could not be read."
            self.problems.append(Problem(node.position("type"), Code.UNKNOWN_BEHAVIOR, message))
            return ResolvedNode(node, Use())
        known = self._library.behaviors
        candidates = self._library.find_behaviors(node.type)
        behavior = _only(node, candidates, self.problems)
        if not candidates:
            hint = names.allowed(node.type, sorted({b.name for b in known}))
            message = f"no behavior '{node.type}' on the ROS package path; {hint}"
            self.problems.append(Problem(node.position("type"), Code.UNKNOWN_BEHAVIOR, message))
            meant = names.misspelt(node.type, (b.name for b in known))
            behavior = next((b for b in known if b.name == meant), None)
        return ResolvedNode(node, Use()) if behavior is None else _with_behavior(node, behavior)

    def _find_support(self, wanted: Support, node: AnyNode) -> StateClass | None:
        """Return the state class that an extension is expanded with; report once if missing."""
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
                Problem(node.position(wanted.extension), Code.UNKNOWN_CLASS, message)
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


def _body_signature(node: Container) -> Signature:
    """Return what a container offers to the chart around it: its datamodel."""
    return Signature(
        f"container '{node.id}'",
        tuple(dict.fromkeys(o.name for o in node.body.outcomes if o.name and o.name != PREEMPTED)),
        tuple(Port(port.name, port.type) for port in node.body.inputs if port.name),
        tuple(Port(port.name, port.type) for port in node.body.outputs if port.name),
        (),
    )


def _use_state(node: State, library: Library, problems: list[Problem]) -> Use:
    candidates = library.find_states(node.type)
    state = _only(node, candidates, problems)
    if not candidates:
        hint = names.allowed(node.type, sorted({s.name for s in library.states}))
        message = f"no state class '{node.type}' on the ROS package path; {hint}"
        problems.append(Problem(node.position("type"), Code.UNKNOWN_CLASS, message))
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
    return Use(declaration, signature, is_qualified, is_timed, added, inputs, outputs)


def _typed(offered: tuple[Port, ...], declared: Sequence[Input | Output]) -> Mapping[str, Port]:
    """Return the ports by name, with the types that the chart declares for them."""
    types = {port.name: port.type for port in declared if port.type}
    return {p.name: replace(p, type=types[p.name]) if p.name in types else p for p in offered}


def _with_behavior(node: Behavior, behavior: BehaviorClass) -> ResolvedNode:
    signature = behavior_signature(behavior)
    is_timed = node.timeout_s is not None
    return ResolvedNode(node, _use(node, behavior, signature, is_timed=is_timed))


def _only(
    node: Node, candidates: tuple[_Found | Unreadable, ...], problems: list[Problem]
) -> _Found | None:
    """Return the one candidate; report several, or one that cannot be used."""
    is_state = isinstance(node, State)
    if len(candidates) > 1:
        spelled = (f"{c.package}/{c.name}" for c in candidates)
        many = names.quoted(sorted(spelled))
        mend = "write package/Class" if is_state else "name its chart's path, or rename one"
        code = Code.AMBIGUOUS_CLASS if is_state else Code.AMBIGUOUS_BEHAVIOR
        message = f"'{node.type}' can be any of {many}; {mend}."
        problems.append(Problem(node.position("type"), code, message))
        return None
    found = candidates[0] if candidates else None
    if isinstance(found, Unreadable):
        code = Code.UNREADABLE_CLASS if is_state else Code.UNREADABLE_BEHAVIOR
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
                yield Problem(position, Code.DUPLICATE_BEHAVIOR, message)
