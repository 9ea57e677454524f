"""Changes to the chart that is edited: values in, values out.

A path is a tuple of the ids of the containers on the way; the empty one is the chart itself.
"""

from __future__ import annotations

import posixpath
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Behavior,
    Chart,
    Connection,
    Container,
    ContainerKind,
    Input,
    Outcome,
    Transition,
)
from remodel_console.errors import CommandError

FINISHED = "finished"  # the outcome that success ends a behavior with, if it has it

Path = tuple[str, ...]


def read_path(text: str) -> Path:
    """Return the path that `/Outer/Inner` spells."""
    return tuple(part for part in text.split("/") if part)


def container_at(chart: Chart, path: Path) -> Chart:
    """Return the chart, or the content of a container in it.

    Raises:
        CommandError: if there is no such container.
    """
    for depth, part in enumerate(path):
        inner = {node.id: node.body for node in chart.nodes if isinstance(node, Container)}
        if part not in inner:
            where = "/" + "/".join(path[:depth])
            hint = names.allowed(part, inner)
            raise CommandError(f"there is no container '{part}' in {where}; {hint}")
        chart = inner[part]
    return chart


def node_paths(chart: Chart) -> tuple[Path, ...]:
    """Return the paths of all nodes of a chart, each before what is in it."""
    paths: list[Path] = []
    for node in chart.nodes:
        paths.append((node.id,))
        if isinstance(node, Container):
            paths += [(node.id, *path) for path in node_paths(node.body)]
    return tuple(paths)


def matches(chart: Chart, word: str) -> tuple[Path, ...]:
    """Return the paths of the nodes that have a word in their id, type or a parameter."""
    word = word.lower()
    found = []
    for path in node_paths(chart):
        nodes = container_at(chart, path[:-1]).nodes
        node = next(node for node in nodes if node.id == path[-1])
        texts = (node.id, node.type, *(param.text for param in node.params))
        if any(word in text.lower() for text in texts):
            found.append(path)
    return tuple(found)


def unplaced(scope: Chart) -> Chart:
    """Return a chart without the places where its parts are drawn, those in containers too."""
    nodes: list[AnyNode] = []
    for node in scope.nodes:
        bare = replace(node, at=None)
        nodes.append(
            replace(bare, body=unplaced(bare.body)) if isinstance(bare, Container) else bare
        )
    outcomes = tuple(replace(outcome, at=None) for outcome in scope.outcomes)
    return replace(scope, nodes=tuple(nodes), outcomes=outcomes)


def change_at(chart: Chart, path: Path, change: Callable[[Chart], Chart]) -> Chart:
    """Return the chart with the content of a container changed.

    What the container then needs and nothing gives it becomes an input of what is around it.

    Raises:
        CommandError: if there is no such container.
    """
    if not path:
        return change(chart)
    container_at(chart, path[:1])
    nodes: list[AnyNode] = []
    needed: tuple[Input, ...] = ()
    for node in chart.nodes:
        if isinstance(node, Container) and node.id == path[0]:
            body = change_at(node.body, path[1:], change)
            needed = tuple(port for port in body.inputs if port not in node.body.inputs)
            node = replace(
                node, body=replace(body, inputs=tuple(_without_default(p) for p in body.inputs))
            )
        nodes.append(node)
    return with_inputs(replace(chart, nodes=tuple(nodes)), needed)


def with_inputs(chart: Chart, needed: Iterable[Input]) -> Chart:
    """Return the chart with inputs added that it lacks."""
    known = {port.name for port in chart.inputs}
    new = tuple(port for port in needed if port.name not in known)
    return replace(chart, inputs=(*chart.inputs, *new))


def as_container(chart: Chart, node_id: str, initial: str, folder: str) -> Container:
    """Return a chart as a container of another one.

    Args:
        chart: what to put in.
        node_id: id of the container.
        initial: where it starts, empty for where the chart itself does.
        folder: folder of the chart around it, from which charts are then named.

    Raises:
        CommandError: if the chart has no such state.
    """
    ids = [node.id for node in chart.nodes]
    if initial and initial not in ids:
        raise CommandError(
            f"'{initial}' is no state of '{chart.name}'; {names.allowed(initial, ids)}"
        )
    body = replace(
        chart,
        name=node_id,
        initial=initial or chart.initial,
        nodes=tuple(_moved(node, posixpath.dirname(chart.file), folder) for node in chart.nodes),
        connections=tuple(_renamed(flow, chart.name, node_id) for flow in chart.connections),
        description="",
        file="",
    )
    return Container(node_id, ContainerKind.SEQUENCE.value, body=body)


def _without_default(port: Input) -> Input:
    return replace(port, default=None)


def _moved(node: AnyNode, old: str, new: str) -> AnyNode:
    """Return a node with the chart that it names named from another folder."""
    if isinstance(node, Container):
        inner = tuple(_moved(part, old, new) for part in node.body.nodes)
        return replace(node, body=replace(node.body, nodes=inner))
    if isinstance(node, Behavior) and node.type.endswith(".xml"):
        return replace(node, type=posixpath.relpath(posixpath.join(old, node.type), new or "."))
    return node


def _renamed(flow: Connection, old: str, new: str) -> Connection:
    """Return a connection in which the chart around it has another name."""
    return replace(
        flow,
        output_state_id=new if flow.output_state_id == old else flow.output_state_id,
        input_state_id=new if flow.input_state_id == old else flow.input_state_id,
    )


def with_container(chart: Chart, container: Container) -> Chart:
    """Return the chart with a container in place of the node of its id, or at its end.

    A container in a node's place keeps the node's transitions for the outcomes that it has too. At
    the end, all that led to success leads to the container first; its outcomes lead to those of
    their names, which the chart gets if it lacks them.
    """
    places = {node.id: index for index, node in enumerate(chart.nodes)}
    outcomes = [outcome.name for outcome in container.body.outcomes]
    needed = container.body.inputs
    container = replace(
        container,
        body=replace(container.body, inputs=tuple(_without_default(p) for p in needed)),
    )
    if container.id in places:
        old = chart.nodes[places[container.id]]
        kept = tuple(t for t in old.transitions if t.event in outcomes)
        nodes = list(chart.nodes)
        nodes[places[container.id]] = replace(container, transitions=kept)
        return connected(with_inputs(replace(chart, nodes=tuple(nodes)), needed), {})
    known = [outcome.name for outcome in chart.outcomes]
    success = FINISHED if FINISHED in known else next(iter(known), "")
    nodes = [_led_to(node, success, container.id) for node in chart.nodes]
    new = tuple(Outcome(name) for name in outcomes if name not in known)
    changed = replace(chart, nodes=(*nodes, container), outcomes=(*chart.outcomes, *new))
    return connected(with_inputs(changed, needed), {})


def _led_to(node: AnyNode, old: str, new: str) -> AnyNode:
    """Return a node with what led to one target leading to another."""
    transitions = tuple(replace(t, target=new) if t.target == old else t for t in node.transitions)
    return replace(node, transitions=transitions)


def connected(chart: Chart, events: Mapping[str, Iterable[str]]) -> Chart:
    """Return the chart with open outcomes leading to the chart's outcomes of the same names.

    Args:
        chart: what to connect.
        events: the events of states and behaviors by id; those of containers are known.
    """
    known = {outcome.name for outcome in chart.outcomes}

    def connect(node: AnyNode) -> AnyNode:
        own = (
            [outcome.name for outcome in node.body.outcomes]
            if isinstance(node, Container)
            else events.get(node.id, ())
        )
        led = {transition.event for transition in node.transitions}
        new = (Transition(e, e) for e in own if e in known and e not in led)
        return replace(node, transitions=(*node.transitions, *new))

    return replace(chart, nodes=tuple(map(connect, chart.nodes)))
