"""The chart that is edited: its text as a draft, its undo, and changes as values.

A path is a tuple of the ids of the containers on the way; the empty one is the chart itself.
"""

from __future__ import annotations

import posixpath
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.chart_reader import read_chart
from flexbe_synthesizer.core.chart.chart_rewriter import RewriteError, rewrite_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
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
from flexbe_synthesizer.core.chart.problem import ChartError, errors_in
from flexbe_synthesizer.core.chart.xml_tree import decoded, encoded
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


def walk_paths(chart: Chart) -> Iterator[tuple[Path, AnyNode]]:
    """Yield all nodes of a chart with their paths, each before what is in it."""
    for node in chart.nodes:
        yield (node.id,), node
        if isinstance(node, Container):
            yield from (((node.id, *path), inner) for path, inner in walk_paths(node.body))


def node_paths(chart: Chart) -> tuple[Path, ...]:
    """Return the paths of all nodes of a chart, each before what is in it."""
    return tuple(path for path, _ in walk_paths(chart))


def matches(chart: Chart, word: str) -> tuple[Path, ...]:
    """Return the paths of the nodes that have a word in their id, type or a parameter."""

    def has_word(node: AnyNode) -> bool:
        texts = (node.id, node.type, *(param.text for param in node.params))
        return any(word.lower() in text.lower() for text in texts)

    return tuple(path for path, node in walk_paths(chart) if has_word(node))


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
        connections=with_state_id(chart.connections, chart.name, node_id),
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


def with_state_id(flows: Iterable[Connection], old: str, new: str) -> tuple[Connection, ...]:
    """Return connections in which a state, or the chart around them, has another name."""
    return tuple(
        replace(
            flow,
            output_state_id=new if flow.output_state_id == old else flow.output_state_id,
            input_state_id=new if flow.input_state_id == old else flow.input_state_id,
        )
        for flow in flows
    )


def with_targets(node: AnyNode, follow: Callable[[str], str]) -> AnyNode:
    """Return a node whose transitions and error routes lead to what a function makes of targets."""
    transitions = tuple(replace(t, target=follow(t.target)) for t in node.transitions)
    routes = tuple(replace(route, target=follow(route.target)) for route in node.on_error)
    return replace(node, transitions=transitions, on_error=routes)


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


@dataclass(frozen=True)
class Draft:
    """A version of the chart that is edited.

    Attributes:
        chart: what the text says.
        text: the XML, comments and layout included.
        origin: the file as it was when it was read or written; None: there was none.
    """

    chart: Chart
    text: str
    origin: bytes | None = None

    @property
    def content(self) -> bytes:
        """Return the text as its file holds it, in the encoding of the file that was read.

        Raises:
            CommandError: if the text declares an encoding that is not known.
        """
        if self.origin is not None and decoded(self.origin, self.chart.file) == self.text:
            return self.origin
        try:
            return encoded(self.text, self.chart.file, self.origin or b"")
        except ChartError as error:
            raise CommandError(str(error)) from error

    def changed(self, chart: Chart) -> Draft:
        """Return the draft of another chart: the text with no more changed than that takes.

        Raises:
            CommandError: if the text cannot be changed so.
        """
        try:
            return Draft(chart, rewrite_chart(self.text, chart), self.origin)
        except RewriteError as error:
            raise CommandError(f"the chart cannot be changed: {error}") from error

    def retyped(self, typed: str) -> Draft:
        """Return the draft of a text that was typed.

        Raises:
            CommandError: if it does not have the form of a chart.
        """
        text = with_line_ends(typed, self.text)
        chart, problems = read_chart(text, self.chart.file)
        if chart is None or errors_in(problems):
            raise CommandError("\n".join(map(str, problems)))
        return Draft(chart, text, self.origin)


def new_draft(chart: Chart) -> Draft:
    """Return the draft of a chart that has no file yet.

    Raises:
        CommandError: if it cannot be written as XML.
    """
    try:
        return Draft(chart, write_chart(chart))
    except ValueError as error:
        raise CommandError(f"the chart cannot be written: {error}") from error


def read_draft(content: bytes, file: str) -> Draft:
    """Return the draft of a chart's file.

    Raises:
        CommandError: if it does not hold what can be read as a chart.
    """
    chart, problems = read_chart(content, file)
    if chart is None:
        raise CommandError("\n".join(map(str, problems)))
    return Draft(chart, decoded(content, file), content)


def with_line_ends(typed: str, before: str) -> str:
    """Return a text that was typed, with the line ends that the text before it has.

    A page knows one kind only. Lines that did not change keep theirs, others get the first one's.
    """
    old = before.splitlines(keepends=True)
    new = typed.splitlines(keepends=True)
    end = "\r\n" if old and old[0].endswith("\r\n") else "\n"
    head = _same(old, new)
    rest = min(len(old), len(new)) - head
    tail = min(_same(old[::-1], new[::-1]), rest)
    middle = [line.rstrip("\r\n") + end * line.endswith("\n") for line in new[head:]]
    middle = middle[: len(middle) - tail]
    return "".join((*old[:head], *middle, *old[len(old) - tail :]))


def _same(old: list[str], new: list[str]) -> int:
    """Return how many lines are the same at the beginning, but for their ends."""
    count = 0
    for one, other in zip(old, new, strict=False):
        if one.rstrip("\r\n") != other.rstrip("\r\n") or one[-1:] != other[-1:]:
            return count
        count += 1
    return count
