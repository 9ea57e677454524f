"""Read chart files, and the charts that they name in turn."""

from __future__ import annotations

import os
import threading
from collections import OrderedDict, deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias

from flexbe_synthesizer.core.chart.chart_reader import read_chart, read_chart_name
from flexbe_synthesizer.core.chart.model import Chart, walk_nodes
from flexbe_synthesizer.core.chart.problem import Problem, ProblemKind
from flexbe_synthesizer.core.check.check import CheckedChart, NestedBehaviors, check_chart
from flexbe_synthesizer.core.library.resolve import included_path, named_behaviors
from flexbe_synthesizer.core.library.signature import BehaviorClass, Library
from flexbe_synthesizer.edge.files import read_regular
from flexbe_synthesizer.errors import ChartFileError, ChartRefusedError

Read: TypeAlias = Callable[[bytes, str], tuple[Chart | None, tuple[Problem, ...]]]

LARGEST_FILE = 4 * 2**20  # of a chart [bytes]; ten thousand states take less than 3 MiB


@dataclass(frozen=True)
class ChartFiles:
    """Charts by path, those asked for first, and what is wrong with the form of their files."""

    charts: tuple[Chart, ...]
    problems: tuple[Problem, ...]


def read_charts(
    paths: Iterable[str],
    locate: Callable[[str], Path] = Path,
    drafts: Mapping[str, bytes] = MappingProxyType({}),
    read: Read = read_chart,
) -> ChartFiles:
    """Return the charts of the paths and of all charts that they name.

    Args:
        paths: what to read; a path is also the name of the file in messages.
        locate: returns the file to read for a path, or raises ChartFileError to refuse it.
        drafts: contents that stand for those of the files, by path.
        read: returns the chart in a content and what is wrong with its form, given its path.

    Raises:
        ChartFileError: if one of the paths cannot be read. A chart named by another one that
            cannot be read is a problem of that other chart.
    """
    charts: dict[str, Chart] = {}
    problems: list[Problem] = []
    waiting = list(dict.fromkeys(os.path.normpath(path) for path in paths))

    def content(path: str) -> bytes:
        if path not in drafts:
            return read_chart_file(locate(path))
        if len(drafts[path]) > LARGEST_FILE:
            raise ChartFileError(f"{path} would be larger than {LARGEST_FILE >> 20} MiB")
        return drafts[path]

    sources = {path: content(path) for path in waiting}
    seen = set(waiting)
    while waiting:
        path = waiting.pop(0)
        chart, found = read(sources.pop(path), path)
        problems.extend(found)
        if chart is None:
            continue
        charts[path] = chart
        for node in walk_nodes(chart):
            included = included_path(chart, node)
            if included is None or included in seen:
                continue
            try:
                sources[included] = content(included)
            except ChartFileError as error:
                message = f"the chart '{node.type}' cannot be used: {error}."
                problems.append(
                    Problem(node.position("type"), ProblemKind.UNKNOWN_BEHAVIOR, message)
                )
            else:
                seen.add(included)
                waiting.append(included)
    return ChartFiles(tuple(charts.values()), tuple(problems))


def read_chart_file(path: Path) -> bytes:
    """Return what a chart's file holds; all programs read charts by this.

    Raises:
        ChartFileError: if it is no regular file, too large, or cannot be read.
    """
    try:
        return read_regular(path, LARGEST_FILE)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ChartFileError(f"{path} cannot be read: {reason}") from error


def confined_to(folders: Iterable[Path]) -> Callable[[str], Path]:
    """Return a `locate` that refuses whatever leads out of the folders, by links too."""
    homes = tuple(folder.resolve() for folder in folders)

    def locate(path: str) -> Path:
        try:
            real = Path(path).resolve()
        except (OSError, ValueError, RuntimeError) as error:  # a NUL, or links in a circle
            raise ChartRefusedError(f"{path!r} is no path: {error}") from error
        if not any(real.is_relative_to(home) for home in homes):
            allowed = ", ".join(map(str, homes)) or "none"
            raise ChartRefusedError(f"{path} lies outside the chart folders; allowed: {allowed}")
        return real

    return locate


def chart_names(
    folders: Iterable[Path], expect_time: Callable[[], None] = lambda: None
) -> Iterator[tuple[str, Path]]:
    """Yield name and file of each chart in the folders; what cannot be read is no chart.

    Args:
        folders: where to look, in this order.
        expect_time: called before each file; what it raises ends the search.
    """
    homes = tuple(folders)
    locate = confined_to(homes)
    for home in homes:
        for path in sorted(home.glob("*.xml")):
            expect_time()
            try:
                name = read_chart_name(read_chart_file(locate(str(path))))
            except ChartFileError:
                continue
            if name is not None:
                yield name, path


def find_chart(name: str, folders: Iterable[Path]) -> str:
    """Return the path of a chart that is named relative to one of the folders, or absolutely.

    Raises:
        ChartFileError: if no folder has it; ChartRefusedError if the name leads out of them.
    """
    homes = tuple(folders)
    locate = confined_to(homes)
    if os.path.isabs(name):
        return str(locate(name))
    for home in homes:
        path = locate(os.path.join(home, name))
        if os.path.isfile(path):  # unlike Path.is_file, no error for names that are too long
            return str(path)
    searched = ", ".join(map(str, homes)) or "none"
    raise ChartFileError(f"there is no chart '{name}' in the chart folders; searched: {searched}")


# Charts as they were read and checked last: only what has changed is read and checked again


_MOST_BYTES = 2**22  # of all texts that are remembered; what is made of them takes 20 times as much
_MOST_WORLDS = 8  # libraries and charts beside a chart, as that change while a user edits


@dataclass(frozen=True)
class _World:
    """What the check of a chart depends on besides the charts: libraries, interfaces of charts.

    Attributes:
        read_back: the charts of the library's behaviors, as far as they were wanted.
    """

    library: Library
    charts: Mapping[str, BehaviorClass]
    read_back: dict[str, Chart | None] = field(default_factory=dict, compare=False)

    def is_like(self, other: _World) -> bool:
        """Return whether charts have the same problems in both; files are those of one reading."""
        return self.library.text_of is other.library.text_of and self == other


@dataclass(frozen=True)
class _Check:
    """The last check of a chart: in which world, and with which charts inside."""

    world: _World
    inside: tuple[Chart, ...]
    checked: CheckedChart


@dataclass
class _Known:
    """A chart that was read, and the last check of it."""

    text: bytes
    chart: Chart | None
    problems: tuple[Problem, ...]
    check: _Check | None = None


class ChartMemory:
    """Reads and checks charts, and remembers the last result for each path.

    A chart is compared by its whole text. Its check holds for as long as the library, the
    interfaces of the charts checked together, and the charts inside it are the same, so that
    nothing outdated is returned.
    """

    def __init__(self, most_bytes: int = _MOST_BYTES) -> None:
        """Remember nothing; forget the oldest once there are more bytes of text."""
        self._most_bytes = most_bytes
        self._lock = threading.Lock()  # a console checks on several threads
        self._known: OrderedDict[str, _Known] = OrderedDict()
        self._worlds: deque[_World] = deque([_World(Library(), {})], _MOST_WORLDS)
        self._last = self._given = self._worlds[0]

    def read(
        self, text: bytes, path: str, expect_time: Callable[[], None] = lambda: None
    ) -> tuple[Chart | None, tuple[Problem, ...]]:
        """Return what `chart_reader.read_chart` does."""
        known = self._known.get(path)
        if known is None or known.text != text:
            known = _Known(text, *read_chart(text, path, expect_time))
        self._keep(path, known)
        return known.chart, known.problems

    def check(
        self,
        chart: Chart,
        library: Library,
        charts: Mapping[str, BehaviorClass],
        nested: NestedBehaviors,
        expect_time: Callable[[], None] = lambda: None,
    ) -> CheckedChart:
        """Return what `check.check_chart` does."""
        with self._lock:
            world = self._world(library, charts)
        nested.read_back = world.read_back
        known = self._known.get(chart.file)
        if known is None or known.chart is not chart:
            return check_chart(chart, library, charts, nested, expect_time=expect_time)
        now, last = _World(library, charts, world.read_back), known.check
        if last is None or last.world is not world or last.inside != _charts_inside(chart, now):
            checked = check_chart(chart, library, charts, nested, expect_time=expect_time)
            known.check = last = _Check(world, _charts_inside(chart, now), checked)
        return last.checked

    def _world(self, library: Library, charts: Mapping[str, BehaviorClass]) -> _World:
        """Return the one of equal worlds that stands for all; charts checked together share it."""
        if self._given.library is not library or self._given.charts is not charts:
            self._given = given = _World(library, charts)
            self._last = next((known for known in self._worlds if known.is_like(given)), given)
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


def _charts_inside(chart: Chart, world: _World) -> tuple[Chart, ...]:
    """Return the charts of all behaviors in a chart, and in these."""
    found: list[Chart] = []
    waiting = [chart]
    while waiting:
        for behavior in named_behaviors(waiting.pop(), world.library, world.charts):
            inner = behavior.chart or world.read_back.get(behavior.module)
            if inner is not None and not any(inner is one for one in found):
                found.append(inner)
                waiting.append(inner)
    return tuple(found)
