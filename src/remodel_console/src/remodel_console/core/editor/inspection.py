"""What the checks say about the chart on the page: problems, and what each node offers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from flexbe_synthesizer.core.chart.model import AnyNode, Chart
from flexbe_synthesizer.core.chart.problem import Problem, errors_in
from flexbe_synthesizer.core.check.check import CheckedChart
from flexbe_synthesizer.core.export.certificate import Certificate, certify
from flexbe_synthesizer.core.library.resolve import ResolvedChart
from flexbe_synthesizer.core.library.use import Use


@dataclass(frozen=True)
class Inspection:
    """What the checks found.

    Attributes:
        problems: those of this file first.
        uses: what nodes name, by their paths, `Place/Insert`.
        unchecked: why it could not be checked; empty if it was.
        checked: the chart, if it was.
        package: where its behavior goes.
    """

    problems: tuple[Problem, ...] = ()
    uses: Mapping[str, Use] = field(default_factory=dict)
    unchecked: str = ""
    checked: CheckedChart | None = None
    package: str = ""

    def certify(self) -> Certificate | None:
        """Return what the behavior can do at most; None if it has errors."""
        if self.checked is None or self.error_count:
            return None
        return certify(self.checked, self.package)

    @property
    def error_count(self) -> int:
        """Return how many problems keep it from being saved."""
        return len(errors_in(self.problems))

    def events(self, path: str, node: AnyNode) -> tuple[str, ...]:
        """Return the outcomes of a node, those that only its transitions name too."""
        entry = self.uses.get(path)
        known = (entry.events or ()) if entry else ()
        return tuple(dict.fromkeys((*known, *(t.event for t in node.transitions))))

    def sources(self, scope: Chart, prefix: str) -> Iterator[tuple[str, str]]:
        """Yield the (state, output) pairs that an input in a scope may be fed by."""
        yield from ((scope.name, port.name) for port in scope.inputs)
        for node in scope.nodes:
            entry = self.uses.get(f"{prefix}{node.id}")
            for port in entry.outputs.values() if entry else ():
                yield node.id, port.name


def uses_by_path(resolved: ResolvedChart, prefix: str = "") -> dict[str, Use]:
    """Return what each node of a chart names, those inside containers too."""
    found: dict[str, Use] = {}
    for entry in resolved.nodes:
        path = f"{prefix}{entry.node.id}"
        found[path] = entry.use
        if entry.body is not None:
            found |= uses_by_path(entry.body, f"{path}/")
    return found
