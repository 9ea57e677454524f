"""States of a chart copied, pasted, deleted, and put into a container."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace

from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Chart,
    Connection,
    Container,
    ContainerKind,
    Input,
    Outcome,
    Output,
    Point,
    Transition,
)
from flexbe_synthesizer.core.chart.names import snake_case, take_unused
from remodel_console.core.chart_edit import node_at, renamed, unused_id, with_node
from remodel_console.core.editing import Path, container_at, with_targets
from remodel_console.errors import CommandError


@dataclass(frozen=True)
class Copied:
    """States that were copied out of one container, and the data flow between them."""

    nodes: tuple[AnyNode, ...] = ()
    connections: tuple[Connection, ...] = ()


def outermost(paths: Iterable[Path]) -> tuple[Path, ...]:
    """Return the paths that lie in none of the others, in order."""
    given = tuple(dict.fromkeys(path for path in paths if path))
    return tuple(
        path
        for path in given
        if not any(path != other and path[: len(other)] == other for other in given)
    )


def copied(chart: Chart, paths: Iterable[Path]) -> Copied:
    """Return copies of the nodes of these paths that are in the container of the first."""
    wanted = outermost(paths)
    if not wanted:
        return Copied()
    beside = [path for path in wanted if path[:-1] == wanted[0][:-1]]
    nodes = tuple(node for path in beside if (node := node_at(chart, path)) is not None)
    ids = {node.id for node in nodes}
    flows = container_at(chart, wanted[0][:-1]).connections
    inside = (flow for flow in flows if {flow.output_state_id, flow.input_state_id} <= ids)
    return Copied(nodes, tuple(inside))


def pasted(scope: Chart, what: Copied) -> tuple[Chart, tuple[str, ...]]:
    """Return the scope with copies added, and their ids.

    A transition to what is neither copied with it nor in the scope leads nowhere in the copy.
    """
    part = Chart("", "", nodes=what.nodes, connections=what.connections)
    for node in what.nodes:
        taken = Chart("", "", (*scope.outcomes,), (*scope.nodes, *part.nodes))
        if unused_id(scope, node.id) != node.id:
            part = renamed(part, node.id, unused_id(taken, node.id))
    ids = tuple(node.id for node in part.nodes)
    targets = {*ids, *(node.id for node in scope.nodes), *(o.name for o in scope.outcomes)}
    for node in part.nodes:
        led = tuple(t for t in node.transitions if t.target in targets)
        routes = tuple(route for route in node.on_error if route.target in targets)
        scope = with_node(scope, replace(node, transitions=led, on_error=routes, at=None))
    return replace(scope, connections=(*scope.connections, *part.connections)), ids


Keys = Mapping[str, Iterable[str]]


def grouped(scope: Chart, ids: Collection[str], node_id: str, reads: Keys, writes: Keys) -> Chart:
    """Return the scope with some of its nodes in a new container.

    What a node leads to outside becomes an outcome of the container, values that come in or go out
    become its inputs and outputs.

    Args:
        scope: a chart, or the content of a container that runs one state after the other.
        ids: of the nodes.
        node_id: of the container, which nothing in the scope has yet.
        reads: inputs of the nodes by id.
        writes: their outputs by id.

    Raises:
        CommandError: if the nodes cannot be one container.
    """
    inside = [node for node in scope.nodes if node.id in ids]
    if not inside:
        raise CommandError("select the states to group first")
    if scope.conditions:
        raise CommandError("states of a concurrency container run at once; they cannot be grouped")
    initial = _entry(scope, ids, inside)
    ends = _Ends({node.id for node in inside})
    nodes = tuple(ends.led(node) for node in inside)
    flow = _flow(scope, ids, node_id, reads, writes)
    corner = _corner(inside)
    body = Chart(
        node_id,
        initial,
        tuple(map(Outcome, ends.names.values())),
        tuple(_shifted(node, corner) for node in nodes),
        tuple(Input(name) for name in flow.inputs),
        tuple(Output(name) for name in flow.outputs),
        tuple(flow.inner),
    )
    led = tuple(Transition(name, target) for target, name in ends.names.items())
    container = Container(
        node_id, ContainerKind.SEQUENCE.value, transitions=led, at=corner, body=body
    )
    first = scope.nodes.index(inside[0])
    kept: list[AnyNode] = [_entering(n, ids, node_id) for n in scope.nodes if n.id not in ids]
    place = sum(1 for node in scope.nodes[:first] if node.id not in ids)
    kept.insert(place, container)
    begin = node_id if scope.initial in ids else scope.initial
    return replace(scope, nodes=tuple(kept), connections=tuple(flow.outer), initial=begin)


def _entry(scope: Chart, ids: Collection[str], inside: list[AnyNode]) -> str:
    """Return the one node that is entered from outside; without one, the first."""
    around = [node for node in scope.nodes if node.id not in ids]
    led = [t.target for node in around for t in node.transitions]
    led += [route.target for node in around for route in node.on_error]
    entered = dict.fromkeys(target for target in (scope.initial, *led) if target in ids)
    if len(entered) > 1:
        names = ", ".join(f"'{name}'" for name in entered)
        raise CommandError(
            f"{names} are entered from outside; a container begins with one state. Select the "
            "states between them too, or lead there through one of them"
        )
    return next(iter(entered), inside[0].id)


class _Ends:
    """The outcomes of the container: one for each target outside.

    Attributes:
        names: of the outcomes, by target.
    """

    def __init__(self, inside: set[str]) -> None:
        self.names: dict[str, str] = {}
        self._inside = inside

    def led(self, node: AnyNode) -> AnyNode:
        """Return a node that leads to outcomes of the container in place of what is outside."""
        return with_targets(node, self._end)

    def _end(self, target: str) -> str:
        if target in self._inside:
            return target
        if target not in self.names:
            taken = {*self._inside, *self.names.values()}
            self.names[target] = take_unused(snake_case(target), taken)
        return self.names[target]


@dataclass
class _Flow:
    """The data flow through the container."""

    inputs: list[str] = field(default_factory=list)
    outputs: list[str] = field(default_factory=list)
    inner: list[Connection] = field(default_factory=list)
    outer: list[Connection] = field(default_factory=list)


def _flow(scope: Chart, ids: Collection[str], node_id: str, reads: Keys, writes: Keys) -> _Flow:
    flow, ports = _Flow(), dict[tuple[str, str, bool], str]()

    def port(state: str, key: str, *, is_input: bool) -> str:
        known = ports.get((state, key, is_input))
        if known is None:
            known = take_unused(key, {*flow.inputs, *flow.outputs})
            ports[state, key, is_input] = known
            (flow.inputs if is_input else flow.outputs).append(known)
        return known

    for one in scope.connections:
        is_from, is_to = one.output_state_id in ids, one.input_state_id in ids
        if is_from and is_to:
            flow.inner.append(one)
        elif is_to:
            is_new = (one.output_state_id, one.output, True) not in ports
            name = port(one.output_state_id, one.output, is_input=True)
            flow.inner.append(Connection(node_id, name, one.input_state_id, one.input))
            if is_new:
                flow.outer.append(replace(one, input_state_id=node_id, input=name))
        elif is_from:
            is_new = (one.output_state_id, one.output, False) not in ports
            name = port(one.output_state_id, one.output, is_input=False)
            if is_new:
                flow.inner.append(Connection(one.output_state_id, one.output, node_id, name))
            flow.outer.append(replace(one, output_state_id=node_id, output=name))
        else:
            flow.outer.append(one)
    _add_by_name(scope, ids, flow, reads, writes)
    return flow


def _add_by_name(
    scope: Chart, ids: Collection[str], flow: _Flow, reads: Keys, writes: Keys
) -> None:
    """Add what states read and write by the names of the scope's values, without a connection."""
    fed = {(one.input_state_id, one.input) for one in scope.connections}
    for port in scope.inputs:
        by_name = any(port.name in reads.get(i, ()) and (i, port.name) not in fed for i in ids)
        if by_name and port.name not in flow.inputs:
            flow.inputs.append(port.name)
    for out in scope.outputs:
        is_fed = any(one.input_state_id == scope.name and one.input == out.name
                     for one in scope.connections)  # fmt: skip
        if not is_fed and any(out.name in writes.get(i, ()) for i in ids):
            flow.outputs += [out.name] if out.name not in flow.outputs else []


def _entering(node: AnyNode, ids: Collection[str], node_id: str) -> AnyNode:
    """Return a node that leads to the container in place of what is in it."""
    return with_targets(node, lambda target: node_id if target in ids else target)


def _corner(nodes: Iterable[AnyNode]) -> Point | None:
    placed = [node.at for node in nodes if node.at is not None]
    return (min(x for x, _ in placed), min(y for _, y in placed)) if placed else None


def _shifted(node: AnyNode, corner: Point | None) -> AnyNode:
    if node.at is None or corner is None:
        return node
    return replace(node, at=(node.at[0] - corner[0], node.at[1] - corner[1]))
