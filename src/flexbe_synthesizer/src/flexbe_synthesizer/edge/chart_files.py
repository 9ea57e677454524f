"""Read chart files, and the charts that they name in turn."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias

from flexbe_synthesizer.core.chart.chart_reader import read_chart, read_chart_name
from flexbe_synthesizer.core.chart.model import Chart, walk_nodes
from flexbe_synthesizer.core.chart.problem import Problem, ProblemKind
from flexbe_synthesizer.core.library.resolve import included_path
from flexbe_synthesizer.edge.regular_file import read_regular
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
