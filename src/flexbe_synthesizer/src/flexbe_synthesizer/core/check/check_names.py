"""Check that every name can be carried by FlexBE, stands once, and means one thing."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Chart,
    Container,
    Element,
    Input,
    Output,
    State,
)
from flexbe_synthesizer.core.chart.problem import Problem, ProblemKind
from flexbe_synthesizer.core.library.resolve import ResolvedChart
from flexbe_synthesizer.core.library.signature import TYPES, is_type
from flexbe_synthesizer.core.library.use import label
from flexbe_synthesizer.core.machine.expanded_labels import added_labels


def check_names(resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield the problems with names of the chart, its data, its states and their parts."""
    chart = resolved.chart
    if not resolved.is_inner:
        yield from _check_name("the chart", chart, chart.name, "name")
        if names.is_name(chart.name) and not names.is_behavior_name(chart.name):
            message = f"the name '{names.shortened(chart.name)}' of the chart cannot name a "
            message += f"behavior; allowed: {names.BEHAVIOR_RULE}."
            yield Problem(chart.position("name"), ProblemKind.INVALID_NAME, message)
    yield from _check_outcomes(resolved)
    for ports in (chart.inputs, chart.outputs):
        yield from _check_ports(resolved.title, ports)
        for port in ports:
            if port.name and not names.is_key(port.name):
                message = f"'{port.name}' cannot name userdata; give a Python identifier that does "
                message += "not start with '_'."
                yield Problem(port.position("name"), ProblemKind.INVALID_NAME, message)
    yield from _check_ids(resolved)


def check_node_names(node: AnyNode) -> Iterator[Problem]:
    """Yield the problems with the names of a node's inputs, outputs and parameters."""
    yield from _check_ports(label(node), node.inputs)
    yield from _check_ports(label(node), node.outputs)
    yield from _check_params(node)


def _check_name(of: str, element: Element, name: str, attribute: str) -> Iterator[Problem]:
    if name and not names.is_name(name):
        message = f"the name '{name}' of {of} cannot be used; allowed: {names.NAME_RULE}."
        yield Problem(element.position(attribute), ProblemKind.INVALID_NAME, message)


def _check_outcomes(resolved: ResolvedChart) -> Iterator[Problem]:
    outcomes = resolved.chart.outcomes
    for outcome in outcomes:
        yield from _check_name("an outcome", outcome, outcome.name, "name")
        if outcome.name == names.PREEMPTED:
            message = "'preempted' is reserved: FlexBE adds it everywhere itself; delete it here."
            yield Problem(outcome.position("name"), ProblemKind.RESERVED_NAME, message)
    yield from _check_duplicates(resolved.title, outcomes, [o.name for o in outcomes])


def _check_duplicates(
    of: str, elements: Sequence[Element], found: Sequence[str]
) -> Iterator[Problem]:
    """Yield a problem for each name that stood before."""
    first: dict[str, int] = {}
    for index, (element, name) in enumerate(zip(elements, found, strict=True)):
        other = first.setdefault(name, index)
        if other != index and name:
            what = type(element).__name__.lower()
            line = elements[other].position("name").line
            message = f"{of} has a second {what} '{name}', the first is in line {line}; delete one."
            yield Problem(element.position("name"), ProblemKind.DUPLICATE_NAME, message)


def _check_ports(of: str, ports: Sequence[Input | Output]) -> Iterator[Problem]:
    yield from _check_duplicates(of, ports, [port.name for port in ports])
    for port in ports:
        if port.type and not is_type(port.type):
            hint = names.allowed(port.type, TYPES)
            message = f"type '{port.type}' is unknown; a ROS message (package/Message), or {hint}"
            yield Problem(port.position("type"), ProblemKind.UNKNOWN_TYPE, message)


def _check_ids(resolved: ResolvedChart) -> Iterator[Problem]:
    chart = resolved.chart
    outcomes = {outcome.name for outcome in chart.outcomes}
    added = {other: entry.node.id for entry in resolved.nodes for other in added_labels(entry)}
    special = {chart.name, names.PREEMPTED, *outcomes, *added}
    first: dict[str, AnyNode] = {}
    for node in chart.nodes:
        if not names.is_name(node.id):
            yield from _check_name(f"a {node.kind}", node, node.id, "id")
        other = first.setdefault(node.id, node)
        if node.id and other is not node:
            line = other.position("id").line
            message = f"the id '{node.id}' is taken by line {line}; give each its own."
            yield Problem(node.position("id"), ProblemKind.DUPLICATE_ID, message)
        for taken_by in _meanings(node.id, resolved, outcomes, added) if node.id in special else ():
            message = f"'{node.id}' is also {taken_by}; rename the {node.kind}."
            yield Problem(node.position("id"), ProblemKind.RESERVED_NAME, message)


def _meanings(
    name: str, resolved: ResolvedChart, outcomes: Iterable[str], added: dict[str, str]
) -> Iterator[str]:
    """Yield what else an id means."""
    if name and name == resolved.chart.name:
        around = "container" if resolved.is_inner else "chart"
        yield f"the {around}'s name, which stands for the {around} in connections"
    if name in outcomes:
        yield f"an outcome of {resolved.title}, and a transition could mean either"
    if name == names.PREEMPTED:
        yield "an outcome that FlexBE adds to every behavior"
    if name in added:
        yield f"the name of a state that the extension adds for '{added[name]}'"


def check_paths(resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield a problem for each path that the FlexBE App cannot distinguish from another one.

    The App joins the parts of a path with '_'. Equal ids in one place are reported as duplicates.
    """
    if not any(isinstance(node, Container) for node in resolved.chart.nodes):
        return
    first: dict[str, tuple[str, AnyNode]] = {}
    for path, node in _paths(resolved.chart, ""):
        joined = path.replace("/", "_")
        other_path, other = first.setdefault(joined, (path, node))
        if other_path != path:
            line = other.position("id").line
            message = f"the FlexBE App cannot distinguish the path '{path}' from '{other_path}' "
            message += f"in line {line}: it joins paths with '_'. Rename one of the two."
            yield Problem(node.position("id"), ProblemKind.DUPLICATE_ID, message)


def _paths(chart: Chart, above: str) -> Iterator[tuple[str, AnyNode]]:
    for node in chart.nodes:
        yield f"{above}/{node.id}", node
        if isinstance(node, Container):
            yield from _paths(node.body, f"{above}/{node.id}")


def _check_params(node: AnyNode) -> Iterator[Problem]:
    yield from _check_duplicates(label(node), node.params, [param.name for param in node.params])
    given = {"timeout_s"} if node.timeout_s is not None else set()
    if isinstance(node, State) and node.topic is not None:
        given.add("topic")
    for param in node.params:
        if param.name in given:
            message = f"{param.name} stands as an attribute of {label(node)} too; delete one."
            yield Problem(param.position("name"), ProblemKind.DUPLICATE_NAME, message)
