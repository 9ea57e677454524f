"""Labels of the states that `lower` adds, and the steps of a run as steps of the chart."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from flexbe_synthesizer.core.chart.model import Chart, Container
from flexbe_synthesizer.core.chart.names import EXHAUSTED, FAILED
from flexbe_synthesizer.core.library.resolve import ResolvedNode

OTHER = "other"  # outcome of a chooser for the codes that no route names
RUN, TIMER = "run", "timer"  # what a container for a timeout holds


def counter_label(node_id: str) -> str:
    """Return the label of the state that counts the attempts of another."""
    return f"{node_id}_attempts"


def chooser_label(node_id: str) -> str:
    """Return the label of the state that parts the failures of another by code."""
    return f"{node_id}_error"


def added_labels(entry: ResolvedNode) -> Iterator[str]:
    """Yield the labels that the states added for a node take from the chart's ids.

    The FlexBE App joins the parts of a path with `_`, so what lies inside a container takes one.
    """
    if entry.node.attempts is not None:
        yield counter_label(entry.node.id)
    if entry.node.on_error:
        yield chooser_label(entry.node.id)
    if entry.use.is_timed:
        yield f"{entry.node.id}_{RUN}"
        yield f"{entry.node.id}_{TIMER}"


def chart_steps(chart: Chart, taken: Iterable[tuple[str, str]]) -> tuple[tuple[str, str], ...]:
    """Return what an engine reports, as steps of the chart.

    Args:
        chart: the chart of the behavior that ran.
        taken: (path of the state, outcome), such as `("/Locate_attempts", "counted")`, in order.

    Returns:
        (id, event) of each node of the chart that was left; the id of one inside containers has
        theirs before it, `Place/Insert`.
    """
    names_by_path = _StepNames(chart)
    steps = []
    for path, outcome in taken:
        if path in names_by_path.counters and outcome == EXHAUSTED:
            steps.append((names_by_path.counters[path], outcome))
        elif path in names_by_path.choosers:
            event = FAILED if outcome == OTHER else outcome
            steps.append((names_by_path.choosers[path], event))
        elif path in names_by_path.nodes and (path, outcome) not in names_by_path.parted:
            steps.append((names_by_path.nodes[path], outcome))
    return tuple(steps)


class _StepNames:
    """What the states of a lowered chart are in the chart, by path."""

    def __init__(self, chart: Chart) -> None:
        self.nodes: dict[str, str] = {}
        self.counters: dict[str, str] = {}
        self.choosers: dict[str, str] = {}
        self.parted: set[tuple[str, str]] = set()  # steps that a chooser describes in more detail
        self._add(chart, "", "")

    def _add(self, chart: Chart, above: str, prefix: str) -> None:
        for node in chart.nodes:
            path, name = f"{above}/{node.id}", f"{prefix}{node.id}"
            self.nodes |= {path: name, f"{path}/{RUN}": name}
            if node.attempts is not None:
                self.counters[f"{above}/{counter_label(node.id)}"] = name
            if node.on_error:
                self.choosers[f"{above}/{chooser_label(node.id)}"] = name
                self.parted |= {(path, FAILED), (f"{path}/{RUN}", FAILED)}
            if isinstance(node, Container):
                inside = path if node.timeout_s is None else f"{path}/{RUN}"
                self._add(node.body, inside, f"{name}/")
