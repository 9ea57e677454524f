"""Values of topics that pages plot; written by one thread, read by the pages."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import Protocol

from remodel_console.core.run.topic_plot import Samples
from remodel_console.watched import Watched


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
        """Begin without plots and without viewers."""
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
