"""What was measured in a replayed run, over time; the lines are drawn once, and a mark moves."""

from __future__ import annotations

from bisect import bisect_right

from nicegui import ui

from remodel_console.core.plot import BOTTOM, LEFT, RIGHT, series_plot
from remodel_console.core.use_case.record import Record, value_words
from remodel_console.web.plot import Plot


class ValuePlots:
    """Shows each value with its line, and what it was at a moment."""

    def __init__(self) -> None:
        """Show nothing yet."""
        self._area = ui.element("div").classes("wide")
        self._area.style(f"--left: {LEFT}px; --right: {RIGHT}px; --bottom: {BOTTOM}px")
        self._length_s = 0.0
        self._values: list[tuple[ui.label, list[float], list[float]]] = []

    def open(self, record: Record) -> None:
        """Draw the values of a record."""
        self._length_s = record.length_s
        self._values.clear()
        self._area.clear()
        with self._area:
            for name in record.value_names():
                points = tuple(record.series(name))
                with ui.row().classes("plot-head"):
                    ui.label(value_words(name)).classes("soft")
                    figure = ui.label().classes("figure")
                with ui.element("div").classes("wide series"):
                    Plot(value_words(name)).show(series_plot(points, record.length_s))
                times, values = zip(*points, strict=True)
                self._values.append((figure, list(times), list(values)))

    def move(self, offset_s: float) -> None:
        """Show a time in the run [s]."""
        self._area.style(f"--now: {offset_s / (self._length_s or 1.0):.4f}")
        for figure, times_s, values in self._values:
            before = bisect_right(times_s, offset_s)
            figure.text = f"{values[before - 1]:.3g}" if before else "-"
