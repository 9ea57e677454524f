"""What the outcomes of behaviors inside a chart write: found in their own charts.

A behavior whose chart is not at hand is read back from its file. Where that is not possible, for
code of its own in it, nothing is certain: each of its outputs may be written or not.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from flexbe_synthesizer.core.fold import fold
from flexbe_synthesizer.core.library import Library
from flexbe_synthesizer.core.lookup import resolve_chart
from flexbe_synthesizer.core.machine_reader import InexpressibleError, read_machine
from flexbe_synthesizer.core.model import Behavior, Chart, walk_nodes
from flexbe_synthesizer.core.resolve import included_path
from flexbe_synthesizer.core.signature import BehaviorClass, Effect
from flexbe_synthesizer.core.written import outcome_effects


class NestedEffects:
    """The effects of behaviors, each found once.

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

    def of(self, behavior: BehaviorClass) -> tuple[Effect, ...]:
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
            self._known[one.module] = self._effects(one)
            trail.pop()
        return self._known[behavior.module]

    def _inside(self, behavior: BehaviorClass) -> Iterator[BehaviorClass]:
        """Yield the behaviors inside another one, as far as their effects matter to it."""
        chart = self._chart(behavior)
        if chart is None:
            return
        for node in walk_nodes(chart):
            if isinstance(node, Behavior):
                path = included_path(chart, node)
                found = self._library.find_behaviors(node.type) if path is None else ()
                candidates = (self._charts.get(path),) if path is not None else found
                yield from (one for one in candidates if isinstance(one, BehaviorClass))

    def _chart(self, behavior: BehaviorClass) -> Chart | None:
        """Return the chart of a behavior; None if it has no outputs, or cannot be read back."""
        if not behavior.outputs:
            return None
        if behavior.chart is not None:
            return behavior.chart
        if behavior.module not in self.read_back:
            self.read_back[behavior.module] = _read_back(behavior, self._library)
        return self.read_back[behavior.module]

    def _effects(self, behavior: BehaviorClass) -> tuple[Effect, ...]:
        chart = self._chart(behavior)
        if chart is None:
            nothing: frozenset[str] = frozenset()
            outputs = frozenset(port.name for port in behavior.outputs)
            return tuple(Effect(o, nothing, outputs) for o in behavior.outcomes if outputs)
        resolved, _problems = resolve_chart(chart, self._library, self._charts, self.of)
        return outcome_effects(resolved)


def _read_back(behavior: BehaviorClass, library: Library) -> Chart | None:
    """Return what a behavior's file says about states and values, None if that cannot be read."""
    text, file = library.text_of(behavior), behavior.module
    try:
        return fold(read_machine(text, file, library, is_outline=True), file, is_outline=True)
    except InexpressibleError:
        return None
