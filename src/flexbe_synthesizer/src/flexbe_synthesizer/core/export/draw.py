"""Draw a chart as Graphviz text: what it does at a glance, with the path that a run took.

States are yellow and behaviors purple, as in Deliverable 5.1. Transitions that look like failures
are red and dashed; those of one direction share an arrow. With a path, what was taken is thick,
solid and numbered, and the rest fades.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape

from flexbe_synthesizer.core.chart.error_routes import FAILED_EVENT, route_event
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Behavior,
    Chart,
    Condition,
    Container,
    ContainerKind,
    State,
)

_FONT = "Helvetica"
_INK, _FAINT, _FAILURE, _TAKEN = "#263238", "#b0bec5", "#c62828", "#1565c0"
_STATE = ("#fff8e1", "#f9a825")  # fill and border
_BEHAVIOR = ("#ede7f6", "#7e57c2")
_CONTAINER = "#607d8b"
_RUNS = {
    ContainerKind.SEQUENCE: "",
    ContainerKind.CONCURRENCY: "at the same time",
    ContainerKind.PRIORITY: "before all others",
}
_CODES_IN_LINE = 4  # of an arrow's label
_SUCCESS_END = ("#e8f5e9", "#2e7d32")
_FAILURE_END = ("#ffebee", _FAILURE)
# Parts of words that say that an event or outcome is no success; only the drawing guesses so.
_FAILURE_WORDS = re.compile(
    "abort|blocked|error|exhausted|fail|invalid|longer than|lost|missing|not_|refus|reject"
    "|timed?_?out|unavailable"
)


@dataclass(frozen=True)
class _Arrow:
    """All events that lead from one node to another and are drawn alike.

    Attributes:
        is_forward: it is no failure and leads to what stands later in the chart, or to an end.
        steps: numbers of the steps of the run that took it, from 1.
    """

    source: str
    target: str
    is_failure: bool
    is_forward: bool
    events: tuple[str, ...]
    steps: tuple[int, ...]


@dataclass(frozen=True)
class _Run:
    """The path that a run took: numbers of its steps by (path, event), and what it entered."""

    steps: Mapping[tuple[str, str], tuple[int, ...]]
    entered: frozenset[str]

    def is_faint(self, path: str) -> bool:
        """Return whether a node or outcome is off the path."""
        return bool(self.steps) and path not in self.entered


def chart_to_dot(chart: Chart, path_taken: Sequence[tuple[str, str]] = ()) -> str:
    """Return the drawing of a chart, containers as boxes around what is in them.

    Args:
        chart: what to draw.
        path_taken: (id, event) of each state or behavior that a run left, in order; the id of one
            inside containers has theirs before it, `Place/Insert`. `lower.chart_steps` makes it
            from what an engine reports.
    """
    run = _run_of(chart, path_taken)
    lines = [
        "digraph chart {",
        "  graph [rankdir=TB, nodesep=0.5, ranksep=0.6, pad=0.3, bgcolor=white, "
        f'compound=true, fontname="{_FONT}", fontsize=11];',
        f'  node [fontname="{_FONT}", fontsize=12, fontcolor="{_INK}", penwidth=1.4];',
        f'  edge [fontname="{_FONT}", fontsize=10, arrowsize=0.7, penwidth=1.2];',
        _start_point("start"),
    ]
    lines += _scope(chart, "", run)
    lines.append("  { rank=sink;")
    lines += [_end(outcome.name, chart, "", run) for outcome in chart.outcomes]
    lines.append("  }")
    if chart.initial:
        lines.append(f'  "start" -> {_entry_of(chart, "", chart.initial)} [color="{_INK}"];')
    return "\n".join((*lines, "}\n"))


def _run_of(chart: Chart, path_taken: Sequence[tuple[str, str]]) -> _Run:
    """Return the steps of a run by node, and all that it entered."""
    steps: dict[tuple[str, str], list[int]] = {}
    entered: set[str] = set()
    targets = dict(_targets(chart, ""))
    for number, step in enumerate(path_taken, start=1):
        steps.setdefault(step, []).append(number)
        path = step[0]
        above = [path[:at] for at, letter in enumerate(path) if letter == "/"]
        entered.update((path, *above, targets.get(step, path)))
    return _Run({step: tuple(numbers) for step, numbers in steps.items()}, frozenset(entered))


def _targets(chart: Chart, prefix: str) -> Iterator[tuple[tuple[str, str], str]]:
    """Yield the path of what each event of each node leads to."""
    for node in chart.nodes:
        for event, target in _leads(node):
            yield (f"{prefix}{node.id}", event), f"{prefix}{target}"
        if isinstance(node, Container):
            yield from _targets(node.body, f"{prefix}{node.id}/")


def _leads(node: AnyNode) -> Iterator[tuple[str, str]]:
    """Yield event and target of each way out of a node."""
    for transition in node.transitions:
        yield transition.event, transition.target
    for route in node.on_error:
        yield route_event(route), route.target


def _scope(chart: Chart, prefix: str, run: _Run) -> Iterator[str]:
    """Yield the nodes of a chart or container, and the arrows between them."""
    for node in chart.nodes:
        if isinstance(node, Container):
            yield from _cluster(node, prefix, run)
        else:
            yield _node(node, f"{prefix}{node.id}", run)
    yield from (_missing(target, prefix) for target in _missing_targets(chart))
    by_id = {node.id: node for node in chart.nodes}
    for arrow in _arrows(chart, prefix, run):
        yield _edge(arrow, chart, by_id[arrow.source], prefix, has_path=bool(run.steps))


def _cluster(node: Container, prefix: str, run: _Run) -> Iterator[str]:
    """Yield a container as a box with its own start and ends."""
    path = f"{prefix}{node.id}"
    body, inside = node.body, f"{path}/"
    color = _FAINT if run.is_faint(path) else _CONTAINER
    notes = [_RUNS[node.runs], *_notes(node)]
    title = f"<b>{escape(node.id)}</b>"
    if any(notes):
        title += f"  <i>{escape(' · '.join(filter(None, notes)))}</i>"
    yield f"  subgraph {_cluster_id(path)} {{"
    yield (
        f"  graph [label=<{title}>, labeljust=l, style=rounded, "
        f'color="{color}", fontcolor="{color}"];'
    )
    yield _start_point(f"start {path}")
    starts = [body.initial] if body.initial else [inner.id for inner in body.nodes]
    yield from _scope(body, inside, run)
    yield from (_end(outcome.name, body, inside, run) for outcome in body.outcomes)
    for start in starts:
        point = _escaped(f"start {path}")
        yield f'  "{point}" -> {_entry_of(body, inside, start)} [color="{color}"];'
    for number, condition in enumerate(body.conditions):
        yield from _condition(condition, number, inside, run)
    yield "  }"


def _condition(condition: Condition, number: int, prefix: str, run: _Run) -> Iterator[str]:
    """Yield the arrows of a condition; what happens together is joined in a bar."""
    end, names_together = _id(f"{prefix}{condition.outcome}"), len(condition.all_of) > 1
    if names_together:
        bar = _id(f"{prefix} and {number}")
        yield f'  {bar} [shape=box, style=filled, fillcolor="{_INK}", label="", height=0.06];'
        yield f'  {bar} -> {end} [color="{_INK}"];'
        end = bar
    for when in condition.all_of:
        color = _FAILURE if is_failure_name(when.event) else _INK
        yield (
            f"  {_id(f'{prefix}{when.state}')} -> {end} "
            f'[label=<<font color="{color}"> {escape(when.event)} </font>>, color="{color}"];'
        )


def _start_point(name: str) -> str:
    return (
        f'  "{_escaped(name)}" [shape=circle, style=filled, fillcolor="{_INK}", label="", '
        "width=0.16];"
    )


def _entry_of(chart: Chart, prefix: str, node_id: str) -> str:
    """Return the DOT id of where an arrow to a node ends: the start of a container."""
    is_container = any(isinstance(n, Container) and n.id == node_id for n in chart.nodes)
    path = f"{prefix}{node_id}"
    return f'"{_escaped(f"start {path}")}"' if is_container else _id(path)


def _node(node: State | Behavior, path: str, run: _Run) -> str:
    """Return the box of a state or behavior: id, type, and its limits as a note."""
    fill, border = _BEHAVIOR if isinstance(node, Behavior) else _STATE
    is_faint = run.is_faint(path)
    name_color, small_color = (_FAINT, _FAINT) if is_faint else (_INK, "#607d8b")
    rows = [
        f'<font color="{name_color}"><b>{escape(node.id)}</b></font>',
        f'<font point-size="9" color="{small_color}">{escape(node.type)}</font>',
    ]
    notes = _notes(node)
    if notes:
        text = " · ".join(notes)
        rows.append(f'<font point-size="9" color="{small_color}"><i>{escape(text)}</i></font>')
    shape = "box" if isinstance(node, State) else "box, peripheries=2"
    return (
        f'  {_id(path)} [shape={shape}, style="rounded,filled", margin="0.22,0.1", '
        f'fillcolor="{"white" if is_faint else fill}", color="{_FAINT if is_faint else border}", '
        f"label=<{'<br/>'.join(rows)}>];"
    )


def _missing_targets(chart: Chart) -> Iterator[str]:
    """Yield what a chart leads to and does not have, once each."""
    known = {node.id for node in chart.nodes} | {outcome.name for outcome in chart.outcomes}
    led = dict.fromkeys(target for node in chart.nodes for _, target in _leads(node))
    starts = [chart.initial] if chart.initial else []
    yield from (target for target in {**dict.fromkeys(starts), **led} if target not in known)


def _missing(name: str, prefix: str) -> str:
    """Return the node of a target that there is not."""
    return (
        f'  {_id(f"{prefix}{name}")} [shape=box, style="rounded,dashed", color="{_FAILURE}", '
        f'fontcolor="{_FAILURE}", label=<{escape(name)}?<br/><font point-size="9">not found'
        "</font>>];"
    )


def _notes(node: AnyNode) -> list[str]:
    """Return what limits a node, in words."""
    notes = []
    if node.attempts is not None:
        notes.append(f"at most {node.attempts} attempt{'s' * (node.attempts > 1)}")
    if node.timeout_s is not None:
        notes.append(f"timeout {node.timeout_s:g} s")
    return notes


def _end(name: str, chart: Chart, prefix: str, run: _Run) -> str:
    """Return the end node of an outcome; one that only failures lead to is one itself."""
    events = [event for node in chart.nodes for event, target in _leads(node) if target == name]
    events += [w.event for c in chart.conditions if c.outcome == name for w in c.all_of]
    is_failure = is_failure_name(name) or (bool(events) and all(map(is_failure_name, events)))
    fill, color = _FAILURE_END if is_failure else _SUCCESS_END
    path = f"{prefix}{name}"
    if run.is_faint(path):
        fill, color = "white", _FAINT
    width = 2.6 if path in run.entered else 1.4
    return (
        f'  {_id(path)} [shape=box, style="rounded,filled", margin="0.3,0.08", fillcolor="{fill}", '
        f'color="{color}", fontcolor="{color}", penwidth={width}, label=<<b>{escape(name)}</b>>];'
    )


def _arrows(chart: Chart, prefix: str, run: _Run) -> Iterator[_Arrow]:
    """Yield the transitions, those between the same two nodes together."""
    groups: dict[tuple[str, str, bool, bool, str], list[str]] = {}
    for node in chart.nodes:
        # An arrow out of a container starts at the end that it is for, so each has its own.
        ends = {o.name for o in node.body.outcomes} if isinstance(node, Container) else set()
        for event, target in _leads(node):
            is_taken = (f"{prefix}{node.id}", event) in run.steps
            end = event if event in ends else ""
            key = (node.id, target, is_failure_name(event), is_taken, end)
            groups.setdefault(key, []).append(event)
    order = {node.id: index for index, node in enumerate(chart.nodes)}
    for (source, target, is_failure, *_), events in groups.items():
        is_forward = not is_failure and order.get(target, len(order)) > order[source]
        path = f"{prefix}{source}"
        taken = sorted(number for e in events for number in run.steps.get((path, e), ()))
        yield _Arrow(
            source,
            target,
            is_failure=is_failure,
            is_forward=is_forward,
            events=tuple(events),
            steps=tuple(taken),
        )


def _edge(arrow: _Arrow, chart: Chart, source: AnyNode, prefix: str, has_path: bool) -> str:
    """Return an arrow with its events as label; one out of a container starts at its ends."""
    color = _FAILURE if arrow.is_failure else _INK
    width, text = 1.2, "<br/>".join(map(escape, _lines(arrow.events, source)))
    if arrow.steps:
        color, width = _FAILURE if arrow.is_failure else _TAKEN, 2.6
        text = f"<b>{', '.join(map(str, arrow.steps))}</b>  {text}"
    elif has_path:
        color = _FAINT
    style = "dashed" if arrow.is_failure and not arrow.steps else "solid"
    attributes: dict[str, str] = {
        "label": f'<<font color="{color}"> {text} </font>>',
        "color": f'"{color}"',
        "style": style,
        "penwidth": str(width),
        "weight": "6" if arrow.is_forward else "1",  # keeps the way to success straight
    }
    path, start = f"{prefix}{source.id}", _id(f"{prefix}{source.id}")
    if isinstance(source, Container):
        ends = [o.name for o in source.body.outcomes if o.name in arrow.events]
        start = _id(f"{path}/{ends[0]}") if ends else f'"{_escaped(f"start {path}")}"'
        if not ends:  # it leaves the container from wherever that is
            attributes["ltail"] = _cluster_id(path)
    listed = ", ".join(f"{name}={value}" for name, value in attributes.items())
    return f"  {start} -> {_entry_of(chart, prefix, arrow.target)} [{listed}];"


def _lines(events: Sequence[str], source: AnyNode) -> Iterator[str]:
    """Yield events line by line; routes of error codes together: `failed 3-5, 7-8`."""
    routes = {route_event(route): route.codes for route in source.on_error}
    yield from (event for event in events if event not in routes)
    codes = [routes[event] for event in events if event in routes]
    for first in range(0, len(codes), _CODES_IN_LINE):
        word = "" if first else f"{FAILED_EVENT} "
        yield word + ", ".join(codes[first : first + _CODES_IN_LINE])


def is_failure_name(name: str) -> bool:
    """Return whether the name of an event or outcome says that something failed."""
    return _FAILURE_WORDS.search(name.lower()) is not None


def _id(path: str) -> str:
    """Return a DOT id; the prefix keeps it apart from the start nodes."""
    return f'"n {_escaped(path)}"'


def _cluster_id(path: str) -> str:
    return f'"cluster {_escaped(path)}"'


def _escaped(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"')
