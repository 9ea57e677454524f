"""Draw a chart as Graphviz text: what it does at a glance, with the path that a run took.

States are yellow and behaviors purple, as in Deliverable 5.1. Transitions that look like failures
are red and dashed; those of one direction share an arrow. With a path, what was taken is thick,
solid and numbered, and the rest fades.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape

from flexbe_synthesizer.core.model import Behavior, Chart, State

_FONT = "Helvetica"
_INK, _FAINT, _FAILURE, _TAKEN = "#263238", "#b0bec5", "#c62828", "#1565c0"
_STATE = ("#fff8e1", "#f9a825")  # fill and border
_BEHAVIOR = ("#ede7f6", "#7e57c2")
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


def chart_to_dot(chart: Chart, path_taken: Sequence[tuple[str, str]] = ()) -> str:
    """Return the drawing of a chart.

    Args:
        chart: what to draw.
        path_taken: (id, event) of each state or behavior that a run left, in order.
            `expand.chart_steps` makes it from what an engine reports.
    """
    entered = _entered(chart, path_taken)
    lines = [
        "digraph chart {",
        "  graph [rankdir=TB, nodesep=0.5, ranksep=0.6, pad=0.3, bgcolor=white];",
        f'  node [fontname="{_FONT}", fontsize=12, fontcolor="{_INK}", penwidth=1.4];',
        f'  edge [fontname="{_FONT}", fontsize=10, arrowsize=0.7, penwidth=1.2];',
        f'  "start" [shape=circle, style=filled, fillcolor="{_INK}", label="", width=0.16];',
    ]
    lines += [_node(node, entered) for node in chart.nodes]
    lines.append("  { rank=sink;")
    lines += [_end(outcome.name, chart, entered) for outcome in chart.outcomes]
    lines.append("  }")
    lines.append(f'  "start" -> {_id(chart.initial)} [color="{_INK}"];')
    lines += [_edge(arrow, bool(path_taken)) for arrow in _arrows(chart, path_taken)]
    return "\n".join((*lines, "}\n"))


def _entered(chart: Chart, path_taken: Sequence[tuple[str, str]]) -> frozenset[str] | None:
    """Return the states and outcomes that a run entered, None if there is no run."""
    if not path_taken:
        return None
    targets = {(n.id, t.event): t.target for n in chart.nodes for t in n.transitions}
    ended = (targets.get(step, "") for step in path_taken)
    return frozenset((*(node_id for node_id, _event in path_taken), *ended))


def _node(node: State | Behavior, entered: frozenset[str] | None) -> str:
    """Return the box of a state or behavior: id, type, and its limits as a note."""
    fill, border = _BEHAVIOR if isinstance(node, Behavior) else _STATE
    is_faint = entered is not None and node.id not in entered
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
        f'  {_id(node.id)} [shape={shape}, style="rounded,filled", margin="0.22,0.1", '
        f'fillcolor="{"white" if is_faint else fill}", color="{_FAINT if is_faint else border}", '
        f"label=<{'<br/>'.join(rows)}>];"
    )


def _notes(node: State | Behavior) -> list[str]:
    """Return what limits a node, in words."""
    notes = []
    if node.attempts is not None:
        notes.append(f"at most {node.attempts} attempt{'s' * (node.attempts > 1)}")
    if node.timeout_s is not None:
        notes.append(f"timeout {node.timeout_s:g} s")
    return notes


def _end(name: str, chart: Chart, entered: frozenset[str] | None) -> str:
    """Return the end node of an outcome; one that only failures lead to is one itself."""
    events = [t.event for node in chart.nodes for t in node.transitions if t.target == name]
    is_failure = _is_failure(name) or (bool(events) and all(map(_is_failure, events)))
    fill, color = _FAILURE_END if is_failure else _SUCCESS_END
    is_faint = entered is not None and name not in entered
    if is_faint:
        fill, color = "white", _FAINT
    width = 2.6 if entered is not None and not is_faint else 1.4
    return (
        f'  {_id(name)} [shape=box, style="rounded,filled", margin="0.3,0.08", fillcolor="{fill}", '
        f'color="{color}", fontcolor="{color}", penwidth={width}, label=<<b>{escape(name)}</b>>];'
    )


def _arrows(chart: Chart, path_taken: Sequence[tuple[str, str]]) -> Iterable[_Arrow]:
    """Return the transitions, those between the same two nodes together."""
    steps: dict[tuple[str, str], list[int]] = {}
    for number, step in enumerate(path_taken, start=1):
        steps.setdefault(step, []).append(number)
    groups: dict[tuple[str, str, bool, bool], list[str]] = {}
    for node in chart.nodes:
        for transition in node.transitions:
            is_taken = (node.id, transition.event) in steps
            key = (node.id, transition.target, _is_failure(transition.event), is_taken)
            groups.setdefault(key, []).append(transition.event)
    order = {node.id: index for index, node in enumerate(chart.nodes)}
    for (source, target, is_failure, _is_taken), events in groups.items():
        is_forward = not is_failure and order.get(target, len(order)) > order[source]
        taken = sorted(number for event in events for number in steps.get((source, event), ()))
        yield _Arrow(source, target, is_failure, is_forward, tuple(events), tuple(taken))


def _edge(arrow: _Arrow, has_path: bool) -> str:
    """Return an arrow with its events as label."""
    color = _FAILURE if arrow.is_failure else _INK
    width, text = 1.2, "<br/>".join(map(escape, arrow.events))
    if arrow.steps:
        color, width = _FAILURE if arrow.is_failure else _TAKEN, 2.6
        text = f"<b>{', '.join(map(str, arrow.steps))}</b>  {text}"
    elif has_path:
        color = _FAINT
    style = "dashed" if arrow.is_failure and not arrow.steps else "solid"
    attributes: Mapping[str, str] = {
        "label": f'<<font color="{color}"> {text} </font>>',
        "color": f'"{color}"',
        "style": style,
        "penwidth": str(width),
        "weight": "6" if arrow.is_forward else "1",  # keeps the way to success straight
    }
    listed = ", ".join(f"{name}={value}" for name, value in attributes.items())
    return f"  {_id(arrow.source)} -> {_id(arrow.target)} [{listed}];"


def _is_failure(name: str) -> bool:
    return _FAILURE_WORDS.search(name.lower()) is not None


def _id(name: str) -> str:
    """Return a DOT id; the prefix keeps it apart from the start node."""
    escaped = name.replace("\\", "\\\\").replace('"', '\\"')
    return f'"n {escaped}"'
