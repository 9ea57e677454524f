"""Find what each state and behavior of a chart names: its class, and so what it offers."""

from __future__ import annotations

import posixpath
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from flexbe_synthesizer.core import names
from flexbe_synthesizer.core.library import Library
from flexbe_synthesizer.core.literal import Literal
from flexbe_synthesizer.core.model import Behavior, Chart, Node, State
from flexbe_synthesizer.core.problem import Code, Problem
from flexbe_synthesizer.core.signature import (
    BehaviorClass,
    Signature,
    StateClass,
    Unreadable,
    behavior_signature,
    state_signature,
)

EXHAUSTED = "exhausted"
TIMED_OUT = "timed_out"
_COUNTER = ("remodel_states", "CountAttemptsState")
_TIMER = ("flexbe_states", "WaitState")
_Found = TypeVar("_Found", StateClass, BehaviorClass)


@dataclass(frozen=True)
class ResolvedNode:
    """A state or behavior of a chart with what it names; both None if that was not found.

    Attributes:
        is_qualified: the chart names the package of the state class.
        is_timed: its timeout is kept by a timer beside it, not by its own class.
    """

    node: State | Behavior
    declaration: StateClass | BehaviorClass | None = None
    signature: Signature | None = None
    is_qualified: bool = False
    is_timed: bool = False

    @property
    def added_events(self) -> tuple[str, ...]:
        """Return the events that the extension adds, even if the class has them already."""
        return (TIMED_OUT,) * self.is_timed + (EXHAUSTED,) * (self.node.attempts is not None)

    @property
    def events(self) -> tuple[str, ...] | None:
        """Return the events that need a transition, None if its outcomes are not known."""
        if self.signature is None or self.signature.outcomes is None:
            return None
        return tuple(dict.fromkeys((*self.signature.outcomes, *self.added_events)))

    def has_own(self, event: str) -> bool:
        """Tell whether the event is an outcome of its class."""
        return self.signature is not None and event in (self.signature.outcomes or ())


@dataclass(frozen=True)
class ResolvedChart:
    """A chart with all its names looked up.

    Attributes:
        counter: class of the state that counts attempts, if the chart counts any.
        timer: class of the state that times others, if the chart times any.
        by_id: the nodes in document order, of two with one id the first.
    """

    chart: Chart
    nodes: tuple[ResolvedNode, ...]
    counter: StateClass | None = None
    timer: StateClass | None = None
    by_id: Mapping[str, ResolvedNode] = field(default_factory=dict)


def kind(node: Node) -> str:
    """Return the word for a node in messages."""
    return "behavior" if isinstance(node, Behavior) else "state"


def label(node: Node) -> str:
    """Return kind and id of a node for messages."""
    return f"{kind(node)} '{node.id}'"


def arguments(node: State | Behavior, is_timed: bool) -> dict[str, Literal]:
    """Return the values that a node gives to its class, by parameter name."""
    values = {param.name: param.value for param in node.params}
    if isinstance(node, State) and node.topic is not None:
        values["topic"] = node.topic
    if node.timeout_s is not None and not is_timed:
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
    problems: list[Problem] = []
    nodes = tuple(_resolve_node(chart, node, library, charts, problems) for node in chart.nodes)
    counted = next((n.node for n in nodes if n.node.attempts is not None), None)
    timed = next((n.node for n in nodes if n.is_timed), None)
    by_id: dict[str, ResolvedNode] = {}
    for entry in nodes:
        if entry.node.id:
            by_id.setdefault(entry.node.id, entry)
    resolved = ResolvedChart(
        chart,
        nodes,
        _support(library, _COUNTER, counted, "attempts", problems) if counted else None,
        _support(library, _TIMER, timed, "timeout_s", problems) if timed else None,
        by_id,
    )
    problems.extend(_check_imports(resolved))
    return resolved, tuple(problems)


def _resolve_node(
    chart: Chart,
    node: State | Behavior,
    library: Library,
    charts: Mapping[str, BehaviorClass],
    problems: list[Problem],
) -> ResolvedNode:
    if not node.type:
        return ResolvedNode(node)
    if isinstance(node, State):
        return _resolve_state(node, library, problems)
    path = included_path(chart, node)
    if path is not None:
        if path in charts:
            return _with_behavior(node, charts[path])
        message = f"the chart '{node.type}' could not be read."
        problems.append(Problem(node.position("type"), Code.UNKNOWN_BEHAVIOR, message))
        return ResolvedNode(node)
    candidates = library.find_behaviors(node.type)
    behavior = _only(node, candidates, problems)
    if not candidates:
        hint = names.allowed(node.type, sorted({b.name for b in library.behaviors}))
        message = f"no behavior '{node.type}' on the ROS package path; {hint}"
        problems.append(Problem(node.position("type"), Code.UNKNOWN_BEHAVIOR, message))
        meant = names.misspelt(node.type, (b.name for b in library.behaviors))
        behavior = next((b for b in library.behaviors if b.name == meant), None)
    return ResolvedNode(node) if behavior is None else _with_behavior(node, behavior)


def _resolve_state(node: State, library: Library, problems: list[Problem]) -> ResolvedNode:
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
        return ResolvedNode(node)
    is_timed = node.timeout_s is not None and all(p.name != "timeout_s" for p in state.parameters)
    signature = state_signature(state, arguments(node, is_timed))
    return ResolvedNode(node, state, signature, node.type != state.name, is_timed)


def _with_behavior(node: Behavior, behavior: BehaviorClass) -> ResolvedNode:
    signature = behavior_signature(behavior)
    return ResolvedNode(node, behavior, signature, is_timed=node.timeout_s is not None)


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


def _support(
    library: Library, wanted: tuple[str, str], node: Node, extension: str, problems: list[Problem]
) -> StateClass | None:
    """Return the state class that an extension is expanded with; report it if it is missing."""
    package, class_name = wanted
    found = library.find_states(f"{package}/{class_name}")
    if len(found) == 1 and isinstance(found[0], StateClass):
        return found[0]
    message = f"ext:{extension} needs the state class {class_name} of package {package}, which is "
    message += "not on the ROS package path; build and source the workspace that has it."
    problems.append(Problem(node.position(extension), Code.UNKNOWN_CLASS, message))
    return None


def _check_imports(resolved: ResolvedChart) -> Iterator[Problem]:
    """Report behaviors that cannot be used side by side, since their classes have one name."""
    chart = resolved.chart
    users = {names.behavior_class(chart.name): chart.name}
    for entry in resolved.nodes:
        if isinstance(entry.declaration, BehaviorClass):
            class_name, name = entry.declaration.class_name, entry.declaration.name
            if users.setdefault(class_name, name) != name:
                message = f"behavior '{entry.node.type}' and another behavior in or around this "
                message += f"chart both have the class {class_name}; rename one of them."
                position = entry.node.position("type")
                yield Problem(position, Code.DUPLICATE_BEHAVIOR, message)
