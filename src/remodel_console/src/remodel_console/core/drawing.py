"""The drawing of a chart: its nodes and arrows, and which of them an active state is.

A node stands for a state, an outcome, the start of a container, or a target that does not exist.
Its id is unique even if the chart has errors; its path is that of the state, `Place/Insert`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

from flexbe_synthesizer.core.chart.error_routes import FAILED_EVENT
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Autonomy,
    Behavior,
    Chart,
    Container,
    ContainerKind,
    State,
    walk_nodes,
)
from flexbe_synthesizer.core.export.draw import is_failure_name
from flexbe_synthesizer.core.machine.lower import RUN, TIMER
from remodel_console.core.chart_edit import KIND_WORDS, feed_of
from remodel_console.core.editing import Path, node_paths
from remodel_console.core.inspection import Inspection

_DEEPEST = 4  # behaviors inside behaviors that are drawn open


def drawn_path(engine_path: str, drawn: frozenset[str]) -> str:
    """Return the path in the drawing of what is active in the engine; empty if nothing is drawn.

    What synthesis added to a state is drawn as that state, and what lies deeper than the drawing
    goes as the box around it.

    Args:
        engine_path: as the engine publishes it, `/Place/Insert_attempts`.
        drawn: paths in the drawing, `Place/Insert`.
    """
    found: list[str] = []
    for part in engine_path.strip("/").split("/"):
        names = (part, part.removesuffix("_attempts"), part.removesuffix("_error"))
        deeper = next((n for n in names if "/".join((*found, n)) in drawn), None)
        if deeper is not None:
            found.append(deeper)
        elif part not in (RUN, TIMER):  # of a container that keeps a state's time
            break
    return "/".join(found)


def engine_paths(chart: Chart, path: str) -> frozenset[str]:
    """Return the paths that the engine may have for a state in the drawing, `Place/Insert`.

    Synthesis puts what has a timeout into a container, as its state `run`, unless it keeps the
    time itself, which a chart alone does not say.
    """
    found, scope = {""}, chart
    for part in path.split("/"):
        node = next((node for node in scope.nodes if node.id == part), None)
        if node is None:
            return frozenset()
        found = {f"{above}/{part}" for above in found}
        if node.timeout_s is not None:
            found |= {f"{inside}/{RUN}" for inside in found}
        scope = node.body if isinstance(node, Container) else Chart(part, "")
    return frozenset(found)


def drawn_paths(chart: Chart) -> frozenset[str]:
    """Return the paths of all that a drawing of a chart shows."""
    return frozenset("/".join(path) for path in node_paths(chart))


def opened(chart: Chart, others: Iterable[Chart]) -> Chart:
    """Return a chart with the behaviors in it drawn open, where another chart says what they do."""
    by_name = {other.name: other for other in others}
    by_name |= {other.file.rpartition("/")[2]: other for other in by_name.values()}
    if not any(isinstance(node, Behavior) for node in walk_nodes(chart)):
        return chart

    def inside(scope: Chart, depth: int) -> Chart:
        return replace(scope, nodes=tuple(open_node(node, depth) for node in scope.nodes))

    def open_node(node: AnyNode, depth: int) -> AnyNode:
        if isinstance(node, Container):
            return replace(node, body=inside(node.body, depth))
        found = by_name.get(node.type) if isinstance(node, Behavior) else None
        if found is None or depth >= _DEEPEST:
            return node
        body = replace(inside(found, depth + 1), name=node.id)
        return Container(type="container", body=body, **_around(node))

    return inside(chart, 0)


def _around(node: AnyNode) -> dict[str, Any]:
    """Return what is drawn of a node besides its type and content."""
    names = ("id", "transitions", "attempts", "timeout_s", "on_error", "at")
    return {name: getattr(node, name) for name in names}


CLOSED = "states inside"  # with their number, the type of a container that is drawn closed
_MOST_OPEN = 40  # states and containers that are readable in one drawing


def collapsed(chart: Chart, path: Path) -> Chart:
    """Return a chart to be drawn; a large one has all containers closed that are not on a path."""
    is_small = sum(1 for _ in walk_nodes(chart)) <= _MOST_OPEN
    return chart if is_small else _closed_beside(chart, path)


def _closed_beside(scope: Chart, path: Path) -> Chart:
    return replace(scope, nodes=tuple(_closed(node, path) for node in scope.nodes))


def _closed(node: AnyNode, path: Path) -> AnyNode:
    """Return a node as it is drawn: a closed container as a state that says how large it is."""
    if not isinstance(node, Container):
        return node
    if path and node.id == path[0]:
        return replace(node, body=_closed_beside(node.body, path[1:]))
    count = sum(not isinstance(inner, Container) for inner in walk_nodes(node.body))
    return State(type=f"{count} {CLOSED}", **_around(node))


Json: TypeAlias = dict[str, Any]
_NOT_FOUND = "not found"


@dataclass(frozen=True)
class Marks:
    """What an editor shows besides the chart.

    Attributes:
        inspection: what the checks found; None for a drawing that is not edited.
        problems: numbers of errors and warnings by the path of a state.
    """

    inspection: Inspection | None = None
    problems: Mapping[str, tuple[int, int]] = field(default_factory=dict)


def chart_graph(chart: Chart, marks: Marks | None = None) -> Json:
    """Return the nodes, arrows and data flows of a chart as JSON."""
    graph = _Graph(marks or Marks())
    graph.add_scope(chart, "", None, ContainerKind.SEQUENCE)
    return {
        "name": chart.name,
        "nodes": list(graph.nodes.values()),
        "edges": graph.edges,
        "flows": graph.flows,
    }


class _Graph:
    """The parts, as they are collected."""

    def __init__(self, marks: Marks) -> None:
        self._marks = marks
        self.nodes: dict[str, Json] = {}
        self.edges: list[Json] = []
        self.flows: list[Json] = []

    def add_scope(self, scope: Chart, prefix: str, parent: str | None, kind: ContainerKind) -> None:
        """Add what is in a chart or container, whose node has the id `parent`."""
        if kind is not ContainerKind.CONCURRENCY and scope.nodes:
            pick, target = prefix.removesuffix("/"), f"n:{prefix}{scope.initial}"
            key = f"s:{prefix}"
            self._add(key, parent, kind="start", name="start", path=key, pick=pick, target=target)
        for node in scope.nodes:
            if f"n:{prefix}{node.id}" not in self.nodes:  # else an error, which the checks report
                self._add_node(node, prefix, parent)
        for outcome in scope.outcomes:
            self._add(
                f"o:{prefix}{outcome.name}",
                parent,
                kind="outcome",
                name=outcome.name,
                path=f"{prefix}{outcome.name}",
                at=outcome.at,
                failure=is_failure_name(outcome.name),
                pick=prefix.removesuffix("/"),
            )
        if kind is ContainerKind.CONCURRENCY:
            self._add_conditions(scope, prefix)
        else:
            if scope.nodes:
                first = self._target(scope, scope.initial, prefix, parent)
                self._add_edge(f"s:{prefix}", first, (), failure=False, autonomy=None)
            for node in scope.nodes:
                self._add_transitions(scope, node, prefix, parent)
        if self._marks.inspection is not None:
            self._add_flows(scope, prefix, self._marks.inspection)

    def _add(self, key: str, parent: str | None, **values: object) -> None:
        given = {name: value for name, value in values.items() if value is not None}
        self.nodes[key] = {"id": key, "parent": parent, "type": "", **given}

    def _add_node(self, node: AnyNode, prefix: str, parent: str | None) -> None:
        path, inspection = f"{prefix}{node.id}", self._marks.inspection
        errors, warnings = self._marks.problems.get(path, (0, 0))
        common: Json = {
            "name": node.id,
            "path": path,
            "pick": path,
            "at": node.at,
            "errors": errors or None,
            "warnings": warnings or None,
        }
        if inspection is not None:
            targets = {t.event: t.target for t in node.transitions}
            common["events"] = [
                {"event": event, "target": targets.get(event, "")}
                for event in inspection.events(path, node)
            ]
        key = f"n:{path}"
        if isinstance(node, Container):
            words = "" if node.runs is ContainerKind.SEQUENCE else KIND_WORDS[node.runs]
            kind = node.runs.name.lower()
            self._add(key, parent, **common, kind=kind, type=words, container=True)
            self.add_scope(node.body, f"{path}/", key, node.runs)
            return
        is_closed = node.type.endswith(CLOSED)
        kind = "closed" if is_closed else "behavior" if isinstance(node, Behavior) else "state"
        name = node.type.rpartition("/")[2] if kind == "state" else node.type
        self._add(key, parent, **common, kind=kind, type=name)

    def _add_transitions(
        self, scope: Chart, node: AnyNode, prefix: str, parent: str | None
    ) -> None:
        """Add the arrows from a node: one for all events that lead alike."""
        alike: dict[tuple[str, bool, Autonomy | None], list[str]] = {}
        for transition in node.transitions:
            key = (transition.target, is_failure_name(transition.event), transition.autonomy)
            alike.setdefault(key, []).append(transition.event)
        for route in node.on_error:
            alike.setdefault((route.target, True, None), []).append(f"{FAILED_EVENT} {route.codes}")
        for (target, failure, autonomy), events in alike.items():
            to = self._target(scope, target, prefix, parent)
            source = f"n:{prefix}{node.id}"
            self._add_edge(source, to, events, failure=failure, autonomy=autonomy)

    def _target(self, scope: Chart, name: str, prefix: str, parent: str | None) -> str:
        """Return the id of what a transition leads to, which is added if it does not exist."""
        if any(node.id == name for node in scope.nodes):
            return f"n:{prefix}{name}"
        key = f"o:{prefix}{name}"
        if key not in self.nodes:
            key = f"m:{prefix}{name}"
            pick = prefix.removesuffix("/")
            self._add(key, parent, kind="missing", name=name, type=_NOT_FOUND, path=key, pick=pick)
        return key

    def _add_edge(
        self,
        source: str,
        target: str,
        events: Sequence[str],
        *,
        failure: bool,
        autonomy: Autonomy | None,
    ) -> None:
        level = autonomy.value if autonomy and autonomy is not Autonomy.OFF else ""
        label = "\n".join(events) + (f" · {level}" if level else "")
        self.edges.append(
            {
                "id": f"e{len(self.edges)}",
                "source": source,
                "target": target,
                "from": source[2:],
                "to": target[2:],
                "label": label,
                "failure": failure,
                "autonomy": level,
                "pick": source[2:] if source.startswith("n:") else "",
            }
        )

    def _add_conditions(self, scope: Chart, prefix: str) -> None:
        """Add the arrows of a concurrency container: each event of a condition to its outcome."""
        for condition in scope.conditions:
            for when in condition.all_of:
                ends = (f"n:{prefix}{when.state}", f"o:{prefix}{condition.outcome}")
                if all(end in self.nodes for end in ends):
                    failure = is_failure_name(condition.outcome)
                    self._add_edge(*ends, (when.event,), failure=failure, autonomy=None)

    def _add_flows(self, scope: Chart, prefix: str, inspection: Inspection) -> None:
        """Add the values that states get: one arrow for all from one state to another."""
        keys: dict[tuple[str, str], list[str]] = {}
        for source, key, target in _flows(scope, prefix, inspection):
            start = f"s:{prefix}" if source == scope.name else f"n:{prefix}{source}"
            ends = (start, f"n:{prefix}{target}")
            if all(end in self.nodes for end in ends):
                keys.setdefault(ends, []).append(key)
        for (source, target), names in keys.items():
            words = {"source": source, "target": target, "label": "\n".join(dict.fromkeys(names))}
            start = "the inputs" if source.startswith("s:") else source[2:]
            self.flows.append({**words, "from": start, "to": target[2:]})


def _flows(scope: Chart, prefix: str, inspection: Inspection) -> Iterator[tuple[str, str, str]]:
    """Yield source, key and target of each value that a node of a scope reads.

    An input without a connection reads the scope's input of its name, as in the synthesizer.
    """
    offered = {port.name for port in scope.inputs}
    for node in scope.nodes:
        entry = inspection.uses.get(f"{prefix}{node.id}")
        for name in entry.inputs if entry else ():
            source = feed_of(scope, node.id, name)
            if source is not None:
                yield source[0], source[1], node.id
            elif name in offered:
                yield scope.name, name, node.id
