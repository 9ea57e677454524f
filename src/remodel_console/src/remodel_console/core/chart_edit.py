"""Changes of a chart that a person makes: of states, arrows, concurrency, inputs and outputs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, TypeVar

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.error_routes import ROUTES_RULE, parse_routes
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Autonomy,
    Chart,
    Condition,
    Connection,
    Container,
    ContainerKind,
    Input,
    Outcome,
    Output,
    Param,
    State,
    Transition,
    When,
    as_declared,
    parse_literal,
)
from flexbe_synthesizer.core.library.signature import is_type
from remodel_console.core.editing import Path, container_at, with_state_id, with_targets
from remodel_console.errors import CommandError

_ENDS = ("finished", "failed")  # outcomes of a container that is new, as in the FlexBE App


def node_at(chart: Chart, path: Path) -> AnyNode | None:
    """Return a node by its path; None if there is none."""
    try:
        scope = container_at(chart, path[:-1])
    except CommandError:
        return None
    return next((node for node in scope.nodes if path and node.id == path[-1]), None)


def unused_id(scope: Chart, wanted: str) -> str:
    """Return an id that nothing in the scope has yet."""
    taken = {node.id for node in scope.nodes} | {outcome.name for outcome in scope.outcomes}
    number, found = 2, wanted
    while found in taken:
        found, number = f"{wanted} {number}", number + 1
    return found


def new_chart(name: str, file: str) -> Chart:
    """Return a chart with nothing in it but its outcomes."""
    return Chart(name, "", tuple(map(Outcome, _ENDS)), file=file)


def new_container(node_id: str) -> Container:
    """Return a container with nothing in it but its outcomes."""
    body = Chart(node_id, "", tuple(map(Outcome, _ENDS)))
    return Container(node_id, ContainerKind.SEQUENCE.value, body=body)


def with_node(scope: Chart, node: AnyNode) -> Chart:
    """Return the scope with a node added; the first one is where it starts."""
    initial = scope.initial if scope.nodes else node.id  # what runs at once starts nowhere
    return replace(scope, nodes=(*scope.nodes, node), initial=initial)


def without_node(scope: Chart, node_id: str) -> Chart:
    """Return the scope without a node, and without what led to it or came from it."""
    nodes = tuple(
        _with_transitions(node, tuple(t for t in node.transitions if t.target != node_id))
        for node in scope.nodes
        if node.id != node_id
    )
    flows = tuple(
        c for c in scope.connections if node_id not in (c.output_state_id, c.input_state_id)
    )
    initial = scope.initial if scope.initial != node_id else next((n.id for n in nodes), "")
    conditions = tuple(
        replace(c, all_of=tuple(when for when in c.all_of if when.state != node_id))
        for c in scope.conditions
    )
    left = tuple(condition for condition in conditions if condition.all_of)
    return replace(scope, nodes=nodes, connections=flows, initial=initial, conditions=left)


def renamed(scope: Chart, old: str, new: str) -> Chart:
    """Return the scope with a node of another id, and all that names it following.

    Raises:
        CommandError: if the name cannot be used.
    """
    if old == new:
        return scope
    if not names.is_name(new):
        raise CommandError(
            f"'{new}' is no name: letters, digits, '_', '-', '.' and single blanks, "
            "starting with a letter"
        )
    if unused_id(scope, new) != new:
        raise CommandError(f"there is a state or outcome '{new}' already")

    def follow(name: str) -> str:
        return new if name == old else name

    nodes: list[AnyNode] = []
    for node in scope.nodes:
        moved = replace(with_targets(node, follow), id=follow(node.id))
        if isinstance(moved, Container) and node.id == old:
            moved = replace(moved, body=with_name(moved.body, new))
        nodes.append(moved)
    flows = with_state_id(scope.connections, old, new)
    conditions = tuple(
        replace(c, all_of=tuple(replace(when, state=follow(when.state)) for when in c.all_of))
        for c in scope.conditions
    )
    initial = follow(scope.initial)
    return replace(
        scope, nodes=tuple(nodes), connections=flows, initial=initial, conditions=conditions
    )


def with_name(body: Chart, name: str) -> Chart:
    """Return a chart or a container's content under another name, as its connections call it."""
    return replace(body, name=name, connections=with_state_id(body.connections, body.name, name))


def led(scope: Chart, node_id: str, event: str, target: str) -> Chart:
    """Return the scope with an outcome of a node leading to a target; an empty one: nowhere."""

    def lead(node: AnyNode) -> AnyNode:
        old = next((t for t in node.transitions if t.event == event), None)
        rest = tuple(t for t in node.transitions if t.event != event)
        if not target:
            return _with_transitions(node, rest)
        if old is None:
            return _with_transitions(node, (*rest, Transition(event, target)))
        changed = tuple(replace(t, target=target) if t is old else t for t in node.transitions)
        return _with_transitions(node, changed)

    return with_changed(scope, node_id, lead)


def with_autonomy(scope: Chart, node_id: str, event: str, level: Autonomy | None) -> Chart:
    """Return the scope with another autonomy that the transition of an outcome needs."""

    def put(node: AnyNode) -> AnyNode:
        changed = (replace(t, autonomy=level) if t.event == event else t for t in node.transitions)
        return _with_transitions(node, tuple(changed))

    return with_changed(scope, node_id, put)


def with_topic(scope: Chart, node_id: str, topic: str) -> Chart:
    """Return the scope with a state that calls the action of another name; empty: its class's."""

    def put(node: AnyNode) -> AnyNode:
        return replace(node, topic=topic or None) if isinstance(node, State) else node

    return with_changed(scope, node_id, put)


def with_parameter(scope: Chart, node_id: str, name: str, text: str) -> Chart:
    """Return the scope with a node's parameter set to the literal in a text; empty: not given."""

    def put(node: AnyNode) -> AnyNode:
        known = {param.name: param for param in node.params}
        if text:
            known[name] = Param(name, parse_literal(text), text)
        else:
            known.pop(name, None)
        return replace(node, params=tuple(known.values()))

    return with_changed(scope, node_id, put)


def limited(scope: Chart, node_id: str, attempts: int | None, timeout_s: float | None) -> Chart:
    """Return the scope with a node's limits: entries in a run, time of one visit [s]."""
    return with_changed(
        scope, node_id, lambda node: replace(node, attempts=attempts, timeout_s=timeout_s)
    )


def routed(scope: Chart, node_id: str, text: str) -> Chart:
    """Return the scope with a node's failures led by their error codes, as in `ext:on_error`.

    Raises:
        CommandError: if the text is no such map.
    """
    try:
        routes = parse_routes(text) if text else ()
    except ValueError as error:
        raise CommandError(f"'{text}' is no error route; write {ROUTES_RULE}") from error
    return with_changed(scope, node_id, lambda node: replace(node, on_error=routes))


def fed(scope: Chart, node_id: str, input_name: str, source: tuple[str, str] | None) -> Chart:
    """Return the scope with an input fed by (state, output); None: by the value of its name."""
    rest = tuple(
        c for c in scope.connections if (c.input_state_id, c.input) != (node_id, input_name)
    )
    new = () if source is None else (Connection(*source, node_id, input_name),)
    return replace(scope, connections=(*rest, *new))


def feed_of(scope: Chart, node_id: str, input_name: str) -> tuple[str, str] | None:
    """Return the (state, output) that feeds an input by a connection."""
    for flow in scope.connections:
        if (flow.input_state_id, flow.input) == (node_id, input_name):
            return flow.output_state_id, flow.output
    return None


def started_at(scope: Chart, node_id: str) -> Chart:
    """Return the scope starting at another node."""
    return replace(scope, initial=node_id)


def with_outcomes(scope: Chart, wanted: tuple[str, ...]) -> Chart:
    """Return the scope with these outcomes; what led to others leads nowhere."""
    gone = {outcome.name for outcome in scope.outcomes} - set(wanted)
    nodes = tuple(
        _with_transitions(node, tuple(t for t in node.transitions if t.target not in gone))
        for node in scope.nodes
    )
    known = {outcome.name: outcome for outcome in scope.outcomes}
    outcomes = tuple(known.get(name, Outcome(name)) for name in wanted)
    return replace(scope, outcomes=outcomes, nodes=nodes)


def targets(scope: Chart) -> Iterator[str]:
    """Yield what an outcome may lead to: the nodes, then the outcomes of the scope."""
    yield from (node.id for node in scope.nodes)
    yield from (outcome.name for outcome in scope.outcomes)


def with_changed(scope: Chart, node_id: str, change: Callable[[AnyNode], AnyNode]) -> Chart:
    """Return the scope with a node changed."""
    nodes = tuple(change(node) if node.id == node_id else node for node in scope.nodes)
    return replace(scope, nodes=nodes)


def _with_transitions(node: AnyNode, transitions: tuple[Transition, ...]) -> AnyNode:
    return replace(node, transitions=transitions)


KIND_WORDS = {
    ContainerKind.SEQUENCE: "sequential",
    ContainerKind.CONCURRENCY: "concurrent",
    ContainerKind.PRIORITY: "sequential, with priority over everything else",
}


def kind_at(chart: Chart, path: Path) -> ContainerKind:
    """Return how what is in a container runs; the chart itself runs one after another."""
    node = node_at(chart, path)
    return node.runs if isinstance(node, Container) else ContainerKind.SEQUENCE


def with_kind(scope: Chart, node_id: str, kind: ContainerKind) -> Chart:
    """Return the scope with a container that runs otherwise.

    What runs all at once has no first state and no transitions, and what does not, no conditions.
    """

    def put(node: AnyNode) -> AnyNode:
        if isinstance(node, Container):
            return replace(node, type=kind.value, body=_fitted(node.body, kind))
        return node

    return with_changed(scope, node_id, put)


def _fitted(body: Chart, kind: ContainerKind) -> Chart:
    if kind is ContainerKind.CONCURRENCY:
        nodes = tuple(replace(node, transitions=()) for node in body.nodes)
        return replace(body, initial="", nodes=nodes)
    first = body.initial or next((node.id for node in body.nodes), "")
    return replace(body, initial=first, conditions=())


def with_condition(
    body: Chart, place: int, outcome: str, pairs: tuple[tuple[str, str], ...]
) -> Chart:
    """Return a container's content with a condition changed, added or removed.

    Args:
        body: content of a container that runs all at once.
        place: index of the condition; that behind the last adds one.
        outcome: that it ends with; empty removes the condition.
        pairs: (state, event)s that all must have happened.
    """
    conditions = list(body.conditions)
    conditions[place : place + 1] = (
        [Condition(outcome, tuple(When(*pair) for pair in pairs))] if outcome else []
    )
    return replace(body, conditions=tuple(conditions))


Port = TypeVar("Port", Input, Output)


def with_input(scope: Chart, place: int, name: str, kind: str, default: str) -> Chart:
    """Return the scope with one of its inputs changed, added or removed.

    Args:
        scope: chart or content of a container.
        place: index of the input; that behind the last adds one.
        name: its key; empty removes it, and what it fed.
        kind: its type; empty: any.
        default: the literal that it is if the caller gives none; empty: it must be given.

    Raises:
        CommandError: if the name or the type cannot be used.
    """
    value = as_declared(default, kind) if default else None
    port = Input(name, kind or None, value) if name else None
    flows = _followed(scope, "output", scope.inputs[place : place + 1], port)
    return replace(scope, inputs=_put(scope.inputs, place, port), connections=flows)


def with_output(scope: Chart, place: int, name: str, kind: str) -> Chart:
    """Return the scope with one of its outputs changed, added or removed; see `with_input`."""
    port = Output(name, kind or None) if name else None
    flows = _followed(scope, "input", scope.outputs[place : place + 1], port)
    return replace(scope, outputs=_put(scope.outputs, place, port), connections=flows)


def _put(ports: tuple[Port, ...], place: int, port: Port | None) -> tuple[Port, ...]:
    """Return the ports with another one at a place, or none."""
    if port is not None:
        _expect_usable(port, {other.name for i, other in enumerate(ports) if i != place})
    changed = list(ports)
    changed[place : place + 1] = [] if port is None else [port]
    return tuple(changed)


def _expect_usable(port: Input | Output, taken: set[str]) -> None:
    if not names.is_key(port.name):
        raise CommandError(f"'{port.name}' is no key: letters, digits and '_', no digit first")
    if port.name in taken:
        raise CommandError(f"there is a value '{port.name}' already")
    if port.type is not None and not is_type(port.type):
        raise CommandError(
            f"'{port.type}' is no type; there are bool, int, float, string, list, dict, and ROS "
            "messages such as geometry_msgs/PoseStamped"
        )


def _followed(
    scope: Chart, side: str, old: tuple[Input | Output, ...], port: Input | Output | None
) -> tuple[Connection, ...]:
    """Return the connections of a scope that follow a port's new name, or go with it.

    `side` of a connection is that of the port: "output" of an input, whose value flows inside.
    """
    found = []
    for flow in scope.connections:
        end = (getattr(flow, f"{side}_state_id"), getattr(flow, side))
        if not old or end != (scope.name, old[0].name):
            found.append(flow)
        elif port is not None:
            new: dict[str, Any] = {side: port.name}
            found.append(replace(flow, **new))
    return tuple(found)
