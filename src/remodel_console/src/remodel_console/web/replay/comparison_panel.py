"""Two runs side by side on Replay, and the values over time."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from functools import partial

from nicegui import run, ui

from remodel_console.console import Console
from remodel_console.core.plot import BOTTOM, LEFT, RIGHT, series_plot
from remodel_console.core.use_case.comparison import Comparison, Step, compare
from remodel_console.core.use_case.record import Record, Summary, value_words
from remodel_console.errors import CommandError
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


_BEFORE, _AFTER = 30, 120  # rows around the first difference that are shown


class ComparisonPanel:
    """Compares the run that is open with another one."""

    def __init__(self, console: Console, go: Callable[[int], None]) -> None:
        """Build it; `go` gets the index of an entry of the open run to go to."""
        self._console = console
        self._go = go
        self._record = Record(())
        self._open: Summary | None = None
        self._runs: dict[int, Summary] = {}
        self._other = 0
        with ui.row().classes("compare-head"):
            self._choice = ui.select({0: "no run"}, value=0, label="Compare with")
            self._choice.props("outlined dense").on_value_change(self._choose)
            self._words = ui.label().classes("soft").props('role="status"')
            self._jump = ui.button("Go to the first difference", color=None)
            self._jump.props("no-caps flat dense").set_visibility(False)
            self._jump.on_click(self._go_to_first)
        self._area = ui.element("div").classes("compare")
        self._area.props('tabindex="0" role="region" aria-label="Two runs"')
        self._area.set_visibility(False)
        self._first: int | None = None

    def offer(self, runs: tuple[Summary, ...]) -> None:
        """Offer runs to compare with."""
        self._runs = {one.run: one for one in runs}
        self._list()

    async def open(self, summary: Summary, record: Record) -> None:
        """Compare another run with the one that was chosen before, if any."""
        self._open, self._record = summary, record
        if self._other == summary.run:
            self._other = 0
        self._list()
        await self._compare()

    def _list(self) -> None:
        own = self._open.run if self._open else 0
        names = {n: f"{n}  {one.order}" for n, one in self._runs.items() if n != own}
        self._other = self._other if self._other in names else 0
        self._choice.set_options({0: "no run"} | names, value=self._other)

    async def _choose(self) -> None:
        if self._choice.value != self._other:
            self._other = int(self._choice.value or 0)
            await self._compare()

    async def _compare(self) -> None:
        self._first = None
        self._area.clear()
        other, opened = self._other, self._open
        is_chosen = bool(other) and opened is not None
        self._area.set_visibility(is_chosen)
        self._jump.set_visibility(False)
        self._words.text = ""
        if not is_chosen or opened is None:
            return
        try:
            record = await run.io_bound(self._console.record, other)
        except CommandError as error:
            self._words.text = str(error)
            return
        found = await run.io_bound(compare, self._record, record)
        if (other, opened) == (self._other, self._open):
            self._show(found, opened.run, other)

    def _show(self, found: Comparison, ours: int, theirs: int) -> None:
        count = sum(not row.is_same for row in found.rows)
        self._words.text = (
            f"{count} of {len(found.rows)} steps differ." if count else "Both took the same steps."
        )
        first = found.first or 0
        begin, end = max(0, first - _BEFORE), first + _AFTER
        with self._area, ui.element("table").classes("plain compare-table"):
            with ui.element("tr"):
                for text in ("[s]", f"Run {ours}", "[s]", f"Run {theirs}"):
                    with ui.element("th"):
                        ui.label(text)
            self._note(begin, "before are the same")
            for place, row in enumerate(found.rows[begin:end], start=begin):
                is_first = place == found.first
                style = "first" if is_first else "" if row.is_same else "differs"
                with ui.element("tr").classes(style):
                    self._cells(row.left, is_ours=True)
                    self._cells(row.right, is_ours=False)
                    if is_first:
                        self._first = row.left.index if row.left else self._before(found, place)
            self._note(len(found.rows) - end, "follow")
        self._jump.set_visibility(self._first is not None)

    @staticmethod
    def _before(found: Comparison, place: int) -> int | None:
        """Return the entry of the open run after which only the other one has a step."""
        steps = (row.left for row in reversed(found.rows[:place]) if row.left is not None)
        return next((step.index for step in steps), None)

    def _note(self, count: int, what: str) -> None:
        if count > 0:
            with ui.element("tr"), ui.element("td").props('colspan="4"'):
                ui.label(f"{count} more steps {what}.").classes("soft")

    def _cells(self, step: Step | None, *, is_ours: bool) -> None:
        with ui.element("td").classes("when"):
            ui.label(f"{step.offset_s:.1f}" if step else "")
        with ui.element("td"):
            if step is not None and is_ours:
                go = partial(self._go, step.index)
                with ui.element("button").classes("step").on("click", go):
                    ui.label(step.words)
            else:
                ui.label(step.words if step else "no such step").classes("" if step else "soft")

    def _go_to_first(self) -> None:
        if self._first is not None:
            self._go(self._first)
