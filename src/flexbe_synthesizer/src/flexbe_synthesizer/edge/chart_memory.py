"""Charts as they were read and checked last: only what has changed is read and checked again."""

from __future__ import annotations

import threading
from collections import OrderedDict, deque
from collections.abc import Mapping
from dataclasses import dataclass

from flexbe_synthesizer.core.check import CheckedChart, check_chart
from flexbe_synthesizer.core.codec import read_chart
from flexbe_synthesizer.core.library import Library
from flexbe_synthesizer.core.model import Chart
from flexbe_synthesizer.core.problem import Problem
from flexbe_synthesizer.core.signature import BehaviorClass

_MOST_BYTES = 2**22  # of all texts that are remembered; what is made of them takes 20 times as much
_MOST_WORLDS = 8  # libraries and charts beside a chart, as that change while somebody works


@dataclass(frozen=True)
class _World:
    """All that the check of a chart depends on besides the chart."""

    library: Library
    charts: Mapping[str, BehaviorClass]


@dataclass
class _Known:
    """A chart that was read, and the last check of it."""

    text: bytes
    chart: Chart | None
    problems: tuple[Problem, ...]
    check: tuple[_World, CheckedChart] | None = None


class ChartMemory:
    """Reads and checks charts, and remembers the last result for each path.

    A chart is compared by its whole text, and its check holds for as long as the library and the
    interfaces of the charts checked together are equal, so that nothing outdated is returned.
    """

    def __init__(self, most_bytes: int = _MOST_BYTES) -> None:
        """Remember nothing; forget the oldest once there are more bytes of text."""
        self._most_bytes = most_bytes
        self._lock = threading.Lock()  # a console checks on several threads
        self._known: OrderedDict[str, _Known] = OrderedDict()
        self._worlds: deque[_World] = deque([_World(Library(), {})], _MOST_WORLDS)
        self._last = self._given = self._worlds[0]

    def read(self, text: bytes, path: str) -> tuple[Chart | None, tuple[Problem, ...]]:
        """Return what `codec.read_chart` does."""
        known = self._known.get(path)
        if known is None or known.text != text:
            known = _Known(text, *read_chart(text, path))
        self._keep(path, known)
        return known.chart, known.problems

    def check(
        self, chart: Chart, library: Library, charts: Mapping[str, BehaviorClass]
    ) -> CheckedChart:
        """Return what `check.check_chart` does."""
        known = self._known.get(chart.file)
        if known is None or known.chart is not chart:
            return check_chart(chart, library, charts)
        with self._lock:
            world = self._world(library, charts)
        if known.check is None or known.check[0] is not world:
            known.check = world, check_chart(chart, library, charts)
        return known.check[1]

    def _world(self, library: Library, charts: Mapping[str, BehaviorClass]) -> _World:
        """Return the one of equal worlds that stands for all; charts checked together share it."""
        if self._given.library is not library or self._given.charts is not charts:
            self._given = given = _World(library, charts)
            self._last = next((known for known in self._worlds if known == given), given)
            if self._last is given:
                self._worlds.append(given)
        return self._last

    def _keep(self, path: str, known: _Known) -> None:
        with self._lock:
            self._known[path] = known
            self._known.move_to_end(path)
            size = sum(len(one.text) for one in self._known.values())
            while size > self._most_bytes:
                _path, oldest = self._known.popitem(last=False)
                size -= len(oldest.text)
