"""Check that names fit FlexBE, stand once and mean one thing; that extensions can be lowered."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.error_routes import codes_of_routes, is_named
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Chart,
    Container,
    ContainerKind,
    Element,
    Input,
    Output,
    State,
    walk_nodes,
)
from flexbe_synthesizer.core.chart.names import ERROR_CODE, FAILED
from flexbe_synthesizer.core.chart.problem import Problem, ProblemKind
from flexbe_synthesizer.core.library.data_flow import DataFlow, label
from flexbe_synthesizer.core.library.resolve import ResolvedChart, ResolvedNode
from flexbe_synthesizer.core.library.signature import TYPES, StateClass, is_type
from flexbe_synthesizer.core.machine.lower import added_labels


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


# Warn of what is said and not used, and of what may not mean what it seems to


def check_use(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Yield the warnings about inputs, outputs and abilities."""
    yield from _check_abilities(resolved)
    if any(entry.use.signature is None for entry in resolved.nodes):
        return  # who reads what is not known
    read = {*flow.read, *(output.name for output in resolved.chart.outputs)}
    yield from _check_inputs(resolved, {*read, *flow.wiring.passed_through})
    yield from _check_outputs(resolved, flow, read)
    yield from _check_shadows(resolved, flow)


def _check_abilities(resolved: ResolvedChart) -> Iterator[Problem]:
    """Warn of states whose goals go on after the state was left."""
    for entry in resolved.nodes:
        declaration = entry.use.declaration
        if isinstance(declaration, StateClass) and declaration.leaves_goals:
            message = f"{label(entry.node)} sends a goal and never cancels it: when it is left by "
            message += "preemption, by a timeout or by a container's end, the ability goes on "
            message += f"moving. Cancel the goal in on_exit of {declaration.name}."
            yield Problem(entry.node.position("type"), ProblemKind.UNCANCELLED_ABILITY, message)


def _check_inputs(resolved: ResolvedChart, read: Collection[str]) -> Iterator[Problem]:
    """Warn of inputs of the chart or container that no state reads."""
    for port in resolved.chart.inputs:
        if port.name and port.name not in read:
            message = f"no state reads input '{port.name}' of {resolved.title}; delete it or "
            yield Problem(port.position(), ProblemKind.UNUSED_INPUT, message + "connect it.")


def _check_outputs(
    resolved: ResolvedChart, flow: DataFlow, read: Collection[str]
) -> Iterator[Problem]:
    """Warn of outputs that a state declares and nothing reads."""
    for node, entry in resolved.by_id.items():
        for output in entry.node.outputs:
            home = flow.outputs.get(node, {}).get(output.name)
            if home is not None and home not in read:
                message = f"nothing reads output '{output.name}' of {label(entry.node)}, which the "
                message += "chart declares; delete the <output>, or connect it."
                yield Problem(output.position(), ProblemKind.UNUSED_OUTPUT, message)


def _check_shadows(resolved: ResolvedChart, flow: DataFlow) -> Iterator[Problem]:
    """Warn of inputs that read the chart's value though a state writes another of that name."""
    shadowed = {port.name for port in resolved.chart.inputs}
    writers: dict[str, list[str]] = {}  # of a value of that name: its first two
    for node, homes in flow.outputs.items():
        for name, home in homes.items():
            if name in shadowed and home != name and len(writers.setdefault(name, [])) < 2:
                writers[name].append(node)
    if not writers:
        return
    for node, entry in resolved.by_id.items():
        for name in entry.use.inputs:
            others = [other for other in writers.get(name, ()) if other != node]
            is_connected = (node, name) in flow.wiring.into_state
            if others and not is_connected and flow.inputs[node].get(name) == name:
                message = f"input '{name}' of {label(entry.node)} reads the input of "
                message += f"{resolved.title}, though '{others[0]}' has an output of that name too;"
                message += " say with a <connection> which of them is meant."
                yield Problem(entry.node.position(), ProblemKind.SHADOWED_NAME, message)


def check_extensions(entry: ResolvedNode, resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield the problems with the limits and error routes of a node."""
    if resolved.is_concurrent:
        yield from _check_side_by_side(entry)
    elif entry.node.on_error:
        yield from _check_routes(entry, resolved)


def check_priorities(resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield a problem for each priority container inside another one, and for each with a timer."""
    for entry in resolved.nodes:
        if entry.body is not None and entry.body.runs is ContainerKind.PRIORITY:
            yield from _check_timer(entry.node)
    if resolved.runs is not ContainerKind.PRIORITY:
        return
    for node in walk_nodes(resolved.chart):
        if isinstance(node, Container) and node.runs is ContainerKind.PRIORITY:
            message = f"container '{node.id}' has priority already, since '"
            message += f"{resolved.chart.name}' around it has, and FlexBE cannot nest them; "
            message += "make it an <ext:container>."
            yield Problem(node.position(), ProblemKind.MISPLACED_ELEMENT, message)


def _check_timer(node: AnyNode) -> Iterator[Problem]:
    """Yield a problem if a priority container has a timer, which would wait while it runs."""
    if node.timeout_s is not None:
        message = f"ext:timeout_s at {label(node)}: while a priority container runs, nothing beside"
        message += " it does, and its timer is beside it. Put what is in it into an <ext:container>"
        message += " inside it, with ext:timeout_s there."
        yield Problem(node.position("timeout_s"), ProblemKind.UNKNOWN_EXTENSION, message)


def _check_side_by_side(entry: ResolvedNode) -> Iterator[Problem]:
    """Yield what cannot stand at a state that starts together with others."""
    node = entry.node
    if node.attempts is not None:
        message = f"ext:attempts at {label(node)}, which is entered with its concurrency container;"
        message += " put it at the container."
        yield Problem(node.position("attempts"), ProblemKind.UNKNOWN_EXTENSION, message)
    if node.on_error:
        message = f"ext:on_error at {label(node)}, which leads nowhere by itself; put the state "
        message += "into an <ext:container> here, with ext:on_error inside."
        yield Problem(node.position("on_error"), ProblemKind.UNKNOWN_EXTENSION, message)
    for transition in node.transitions:
        message = f"a <transition> of {label(node)} inside a concurrency container; what its "
        message += 'events lead to say <ext:condition outcome="..."> elements of the container.'
        yield Problem(transition.position(), ProblemKind.MISPLACED_ELEMENT, message)


def _check_routes(entry: ResolvedNode, resolved: ResolvedChart) -> Iterator[Problem]:
    """Yield the problems with the error routes of a node."""
    node, signature = entry.node, entry.use.signature
    position = node.position("on_error")
    if signature is not None and signature.outcomes is not None and not entry.use.has_own(FAILED):
        message = f"ext:on_error routes the outcome '{FAILED}' by code, and {signature.title} has "
        message += f"none; its outcomes: {names.quoted(signature.outcomes)}."
        yield Problem(position, ProblemKind.UNKNOWN_EVENT, message)
    found = entry.use.outputs
    if signature is not None and ERROR_CODE not in found:
        message = f"ext:on_error reads the output '{ERROR_CODE}', and {signature.title} has none; "
        yield Problem(
            position, ProblemKind.UNKNOWN_OUTPUT, f"{message}its outputs: {names.quoted(found)}."
        )
    limit = signature.effect(FAILED) if signature is not None and ERROR_CODE in found else None
    if signature is not None and limit is not None and ERROR_CODE not in limit.certain:
        message = f"ext:on_error reads the output '{ERROR_CODE}', which {signature.title} does not "
        message += f"always write when it ends with '{FAILED}'; write it on each path to "
        message += f"'{FAILED}', or drop ext:on_error."
        yield Problem(position, ProblemKind.READ_BEFORE_WRITE, message)
    yield from _check_codes(node, resolved.error_names)
    known = set(resolved.targets)
    for route in node.on_error:
        if route.target not in known:
            hint = names.allowed(route.target, resolved.targets)
            message = f"'{route.target}' is neither a state, a behavior nor an outcome; {hint}"
            yield Problem(position, ProblemKind.UNKNOWN_TARGET, message)


def _check_codes(node: AnyNode, error_names: Mapping[str, tuple[int, ...]]) -> Iterator[Problem]:
    """Yield a problem for each error route with an unknown name, or that no code can take."""
    position = node.position("on_error")
    for route, codes in zip(
        node.on_error, codes_of_routes(node.on_error, error_names), strict=True
    ):
        if is_named(route) and route.codes not in error_names:
            message = f"no error code, and no class of error codes, has the name '{route.codes}'; "
            message += names.allowed(route.codes, error_names)
            yield Problem(position, ProblemKind.UNKNOWN_ERROR_CODE, message)
        elif not codes:
            message = f"the route of '{route.codes}' is never taken: the routes before it take all "
            message += "its error codes; put it before them."
            yield Problem(position, ProblemKind.INVALID_VALUE, message)
