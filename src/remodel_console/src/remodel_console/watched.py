"""What pages watch: pictures, the scene, values and plots, fetched only while a page looks."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Protocol

from flexbe_core.engine.visit import Known, VisitText
from remodel_console.core.cell import CellState, Row, StateValues, values_around
from remodel_console.core.plots import Samples


class Watched:
    """Counts those who watch; pages begin and end on different threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._viewers = 0

    @property
    def is_wanted(self) -> bool:
        """Return whether a page or a recorder watches."""
        return self._viewers > 0

    def add_viewer(self, change: int) -> None:
        """Count those who watch: 1 more, or -1."""
        with self._lock:
            self._viewers += change


class Viewer:
    """One who watches, or just now does not."""

    def __init__(self, watched: Watched) -> None:
        self._watched = watched
        self._is_counted = False

    def watch(self, is_watching: bool) -> None:
        """Begin to watch, or cease to."""
        if is_watching != self._is_counted:
            self._is_counted = is_watching
            self._watched.add_viewer(1 if is_watching else -1)


@dataclass(frozen=True)
class Picture:
    """A picture as JPEG; `number` counts those of its camera."""

    number: int
    jpeg: bytes


class Pictures(Watched):
    """Holds the pictures, and knows whether a page shows them."""

    def __init__(self) -> None:
        super().__init__()
        self._newest: dict[str, Picture] = {}
        self._wake: Callable[[], None] = lambda: None

    def on_change(self, wake: Callable[[], None]) -> None:
        """Have a function called, on any thread, after each new picture."""
        self._wake = wake

    def take(self, camera: str, jpeg: bytes) -> None:
        """Take in a picture."""
        with self._lock:
            before = self._newest.get(camera)
            self._newest[camera] = Picture(before.number + 1 if before else 1, jpeg)
        self._wake()

    def newest(self, camera: str) -> Picture | None:
        """Return the newest picture of a camera; None before the first."""
        return self._newest.get(camera)


class Scene(Watched):
    """Holds the newest state, and knows how many pages and recorders want it."""

    def __init__(self) -> None:
        super().__init__()
        self.now = CellState()


class Meshes:
    """Numbers the files of meshes, by which pages request them; no other file is given away."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._files: list[str] = []

    def number(self, file: str) -> int:
        """Return the number of a file that a robot's description names."""
        with self._lock:
            if file not in self._files:
                self._files.append(file)
            return self._files.index(file)

    def file(self, number: int) -> str | None:
        """Return the file of a number; None if there is none."""
        return self._files[number] if 0 <= number < len(self._files) else None


_MOST_FOUND = 1000  # states whose values are kept until they are recorded


class RunValues:
    """The values of the run that goes on, or of the last one.

    Attributes:
        found: what states found, since it was emptied last.
    """

    def __init__(self) -> None:
        self.found: deque[StateValues] = deque(maxlen=_MOST_FOUND)
        self._lock = threading.Lock()
        self._known = Known()
        self._run = 0
        self._rows: dict[str, tuple[Row, ...]] = {}

    def take(self, visit: VisitText) -> bool:
        """Take in that a state was entered or left; return whether all values are known."""
        with self._lock:
            is_known = self._known.take(visit)
            if is_known:
                self._take(visit)
            return is_known

    def rows(self, *paths: str) -> tuple[Row, ...]:
        """Return the values of a state's last visit, or those in a container; of the first path."""
        with self._lock:
            found = (self._rows.get(path) or self._inside(path) for path in paths)
            return next(filter(None, found), ())

    def _inside(self, container: str) -> tuple[Row, ...]:
        values = self._known.values.items()
        return tuple(Row(key, text) for (where, key), (_, text) in values if where == container)

    def _take(self, visit: VisitText) -> None:
        if visit.run != self._run:
            self._run, self._rows = visit.run, {}
        values = self._known.values
        texts = {key: values[place][1] for key, place in visit.keys.items() if place in values}
        if visit.has_left:
            rows = {row.key: row for row in self._rows.get(visit.path, ())}
            rows |= {k: Row(k, rows[k].found if k in rows else "", t) for k, t in texts.items()}
            self._rows[visit.path] = tuple(rows.values())
            return
        self._rows[visit.path] = tuple(Row(key, text) for key, text in texts.items())
        around = values_around(visit.path, values)
        self.found.append(StateValues(visit.time_s, visit.path, around))


class TopicSource(Protocol):
    """The topics of the running system; each call raises CommandError if there is no such topic."""

    def topics(self) -> dict[str, str]:
        """Return the message types of all topics that a node publishes, by their names."""

    def fields(self, topic: str) -> tuple[str, ...]:
        """Return the fields of a topic that are numbers."""

    def check(self, plot: str) -> None:
        """Refuse what cannot be plotted."""


class TopicPlots(Watched):
    """Holds the last minute of each plot, while a page shows it.

    Attributes:
        source: None until ROS is running.
    """

    def __init__(self) -> None:
        self.source: TopicSource | None = None
        super().__init__()
        self._samples: dict[str, Samples] = {}
        self._problems: dict[str, str] = {}

    def keep(self, plots: Iterable[str]) -> None:
        """Keep values of these plots only."""
        with self._lock:
            self._samples = {plot: self._samples.get(plot, Samples()) for plot in plots}
            self._problems = {p: t for p, t in self._problems.items() if p in self._samples}

    def add(self, plot: str, value: float) -> None:
        """Take in a value that has just come."""
        with self._lock:
            if plot in self._samples:
                self._samples[plot].add(time.monotonic(), value)
                self._problems.pop(plot, None)

    def report(self, plot: str, problem: str) -> None:
        """Take in why there is no value."""
        with self._lock:
            self._problems[plot] = problem

    def points(self, plot: str) -> list[tuple[float, float]]:
        """Return (seconds before now, at most 0; value) of the last minute."""
        with self._lock:
            samples = self._samples.get(plot)
            return samples.points(time.monotonic()) if samples else []

    def problem(self, plot: str) -> str:
        """Return why there is no value; empty if there is one, or it is waited for."""
        with self._lock:
            return self._problems.get(plot, "")
