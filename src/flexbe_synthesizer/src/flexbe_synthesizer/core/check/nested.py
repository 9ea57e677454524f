"""What the outcomes of behaviors inside a chart write: found in their own charts.

A behavior whose chart is not at hand is read back from its file. Where that is not possible, for
code of its own in it, nothing is certain: each of its outputs may be written or not.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from flexbe_synthesizer.core.chart.model import Behavior, Chart, walk_nodes
from flexbe_synthesizer.core.library.library import Library
from flexbe_synthesizer.core.library.lookup import resolve_chart
from flexbe_synthesizer.core.library.resolve import ResolvedChart, included_path
from flexbe_synthesizer.core.library.signature import BehaviorClass, Effect
from flexbe_synthesizer.core.machine.lift import lift
from flexbe_synthesizer.core.machine.machine_reader import InexpressibleError, read_machine


class NestedBehaviors:
    """What the behaviors inside charts are made of and what they write, each found once.

    Attributes:
        read_back: the charts of behaviors that have none at hand, by module; None where the file
            holds more than a chart can say. They hold for as long as the library does.
    """

    def __init__(self, library: Library, charts: Mapping[str, BehaviorClass]) -> None:
        """Find behaviors in the library, and charts by their paths."""
        self._library = library
        self._charts = charts
        self.read_back: dict[str, Chart | None] = {}
        self._known: dict[str, tuple[Effect, ...]] = {}
        self._open: set[str] = set()
        self._resolved: dict[str, ResolvedChart] = {}

    def effects(self, behavior: BehaviorClass) -> tuple[Effect, ...]:
        """Return the effects of a behavior; none, which is all, while it contains itself."""
        if behavior.module in self._open:
            return self._known.get(behavior.module, ())
        trail = [behavior]
        while trail:
            one = trail[-1]
            self._open.add(one.module)
            inside = (b for b in self._inside(one) if b.module not in self._open)
            inner = next(inside, None)
            if inner is not None:
                trail.append(inner)
                continue
            self._known[one.module] = self._found(one)
            trail.pop()
        return self._known[behavior.module]

    def _inside(self, behavior: BehaviorClass) -> Iterator[BehaviorClass]:
        """Yield the behaviors inside another one, as far as their effects matter to it."""
        chart = self._chart(behavior) if behavior.outputs else None
        if chart is None:
            return
        for node in walk_nodes(chart):
            if isinstance(node, Behavior):
                path = included_path(chart, node)
                found = self._library.find_behaviors(node.type) if path is None else ()
                candidates = (self._charts.get(path),) if path is not None else found
                yield from (one for one in candidates if isinstance(one, BehaviorClass))

    def _chart(self, behavior: BehaviorClass) -> Chart | None:
        """Return the chart of a behavior, None if it cannot be read back."""
        if behavior.chart is not None:
            return behavior.chart
        if behavior.module not in self.read_back:
            self.read_back[behavior.module] = _read_back(behavior, self._library)
        return self.read_back[behavior.module]

    def _found(self, behavior: BehaviorClass) -> tuple[Effect, ...]:
        if not behavior.outputs:
            return ()
        resolved = self.resolved(behavior)
        if resolved is not None:
            return resolved.effects
        outputs = frozenset(port.name for port in behavior.outputs)
        return tuple(Effect(outcome, frozenset(), outputs) for outcome in behavior.outcomes)

    def resolved(self, behavior: BehaviorClass) -> ResolvedChart | None:
        """Return what a behavior is made of, None if its file cannot be read back."""
        chart = self._chart(behavior)
        if chart is not None and behavior.module not in self._resolved:
            found, _problems = resolve_chart(chart, self._library, self._charts, self.effects)
            self._resolved[behavior.module] = found
        return self._resolved.get(behavior.module)


def _read_back(behavior: BehaviorClass, library: Library) -> Chart | None:
    """Return what a behavior's file says about states and values, None if that cannot be read."""
    text, file = library.text_of(behavior), behavior.module
    try:
        return lift(read_machine(text, file, library, is_outline=True), file, is_outline=True)
    except InexpressibleError:
        return None
