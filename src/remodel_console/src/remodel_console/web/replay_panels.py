"""Panels of Replay: the list of runs, the control of time, two runs side by side."""

from __future__ import annotations

import time
from bisect import bisect_right
from collections.abc import Awaitable, Callable
from functools import partial

from nicegui import run, ui

from remodel_console.console import Console
from remodel_console.core.plots import BOTTOM, LEFT, RIGHT, series_plot
from remodel_console.core.record import (
    REASONS,
    Comparison,
    Record,
    Step,
    Summary,
    compare,
    value_words,
)
from remodel_console.core.use_case import duration_words
from remodel_console.errors import CommandError
from remodel_console.web.elements import Plot, icon_button, text_in
from remodel_run.progress import sums_words
from remodel_run.record import Kind


class ValuePlots:
    """Shows each value with its line, and what it was at a moment."""

    def __init__(self) -> None:
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
        options = {0: "no run"} | names
        if options != self._choice.options:  # else it stays: an operator may be choosing from it
            self._choice.set_options(options, value=self._other)

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
                    text_in("th", text)
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
        text_in("td", f"{step.offset_s:.1f}" if step else "", "when")
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


_UNKNOWN = "Runs are listed here once the supervisor is running."
_NONE = "No run is recorded yet. Each order that is started becomes one."

Open = Callable[[Summary], Awaitable[None]]


class RunList:
    """Shows the runs that the supervisor knows."""

    def __init__(
        self, console: Console, open_run: Open, on_list: Callable[[tuple[Summary, ...]], None]
    ) -> None:
        """Build an empty list.

        Args:
            console: gives access to the runs.
            open_run: is called with the run that is chosen.
            on_list: is called with all runs when they are listed.
        """
        self._on_list = on_list
        self._console = console
        self._open = open_run
        self._listed: tuple[Summary, ...] | None = None
        self._marked = 0
        with ui.element("aside").classes("runs").props('tabindex="0" aria-label="Runs"'):
            with ui.row().classes("runs-head"):
                ui.label("Runs").classes("title")
                icon_button("refresh", "Reload", self.list)
            with ui.element("div").classes("wide") as self._area:
                ui.label(_UNKNOWN).classes("soft")

    async def list(self) -> tuple[Summary, ...]:
        """Request the runs, show and return them; none if no supervisor is running.

        Buttons of a list that is as before stay: one may be pressed just now.
        """
        recorder = self._console.recorder
        try:
            if recorder is None:
                raise CommandError("ROS is not running; records cannot be requested.")
            runs = await run.io_bound(recorder.runs)
        except CommandError as error:
            self._listed = None
            self._area.clear()
            with self._area:
                ui.label(str(error)).classes("ending bad")
            return ()
        self._on_list(runs)
        if runs != self._listed:
            self._listed = runs
            self._area.clear()
            with self._area:
                if not runs:
                    ui.label(_NONE).classes("soft")
                for summary in runs:
                    self._show(summary)
            self.mark(self._marked)
        return runs

    def mark(self, number: int) -> None:
        """Mark the run that is open; 0: none is."""
        self._marked = number
        for button in self._area.default_slot.children:
            is_open = button.props.get("data-run") == str(number)
            button.classes(add="here" if is_open else None, remove=None if is_open else "here")

    def _show(self, summary: Summary) -> None:
        button = ui.element("button").classes("run").on("click", partial(self._open, summary))
        button.props(f'data-run="{summary.run}"')
        with button:
            ui.label(f"{summary.run}  {summary.order}").classes("what")
            begun = time.strftime("%Y-%m-%d %H:%M", time.localtime(summary.started_s))
            ui.label(f"{begun}, {duration_words(summary.sums.taken_s)}, {summary.cell}").classes(
                "soft"
            )
            words = sums_words(summary.sums)
            if not summary.has_ended:
                words += ", not finished"
            ui.label(words).classes("good" if summary.is_success else "soft")


_FRAME_S = 0.25  # between two moments while it plays
_STEP_S = 0.1  # of the slider
_SPEEDS = {1: "1 x", 5: "5 x", 20: "20 x"}


class Scrubber:
    """Moves through a record."""

    def __init__(self, show: Callable[[int], None], move: Callable[[float], None]) -> None:
        """Build it without a record.

        Args:
            show: gets the index of each entry that is gone to.
            move: gets each time in the run that is gone to [s].
        """
        self._show = show
        self._move = move
        self._record = Record(())
        self._index = 0
        with ui.element("section").classes("scrub"):
            with ui.row().classes("controls scrub-row"):
                icon_button("skip_previous", "Previous reason (B)", partial(self.step_reason, -1))
                icon_button("chevron_left", "Previous entry (,)", partial(self.step, -1))
                self._play = icon_button("play_arrow", "Play (P)", self.toggle)
                icon_button("chevron_right", "Next entry (.)", partial(self.step, 1))
                icon_button("skip_next", "Next reason (N)", partial(self.step_reason, 1))
                self._speed = ui.select(_SPEEDS, value=5).props('dense outlined aria-label="Speed"')
                self._clock = ui.label().classes("clock")
            with ui.element("div").classes("track"):
                self._slider = ui.slider(min=0, max=1, step=_STEP_S, value=0)
                self._slider.on("update:model-value", lambda event: self._seek(float(event.args)))
                self._slider.props('aria-label="Time in the run"').set_enabled(False)
                self._marks = ui.html("", sanitize=False).classes("marks")
        self._player = ui.timer(_FRAME_S, self._play_on, active=False)

    def open(self, record: Record) -> None:
        """Begin at the start of a record."""
        self._hold()
        self._record = record
        self._slider.props(f"max={record.length_s:.3f}")
        self._slider.set_enabled(bool(record.entries))
        self._marks.set_content(_marks(record))
        if record.entries:
            self.go(0)
        else:
            self._clock.text = "This run has no recorded entries."

    def step(self, step: int) -> None:
        """Go to the next entry, or the one before."""
        self.go(self._index + step)

    def step_reason(self, step: int) -> None:
        """Go to the next failure, decision or answer, or the one before."""
        self.go(self._record.next_reason(self._index, step))

    def toggle(self) -> None:
        """Play or pause."""
        if self._player.active:
            self._hold()
        elif self._record.entries:
            self._play.props("icon=pause")
            self._player.activate()

    def _hold(self) -> None:
        self._player.deactivate()
        self._play.props("icon=play_arrow")

    def _play_on(self) -> None:
        offset_s = float(self._slider.value) + _FRAME_S * int(self._speed.value)
        self._slider.value = min(offset_s, self._record.length_s)
        self._seek(offset_s)
        if offset_s >= self._record.length_s:
            self._hold()

    def _seek(self, offset_s: float) -> None:
        """Show the moment of a time in the run [s]."""
        self._move(offset_s)
        index = self._record.at(offset_s)
        if index != self._index:
            self._select(index)

    def go(self, index: int) -> None:
        """Go to the entry of an index."""
        if self._record.entries:
            index = min(max(0, index), len(self._record.entries) - 1)
            offset_s = self._record.offset_s(self._record.entries[index])
            self._slider.value = offset_s
            self._move(offset_s)
            self._select(index)

    def _select(self, index: int) -> None:
        self._index, record = index, self._record
        self._clock.text = (
            f"{record.offsets_s[index]:.1f} s of {record.length_s:.1f} s, "
            f"entry {index + 1} of {len(record.entries)}"
        )
        self._show(index)


def _marks(record: Record) -> str:
    """Return the failures, decisions and answers as marks on the track of time."""
    if not record.entries or not record.length_s:
        return ""
    reasons = (entry for entry in record.entries if entry.kind in REASONS)
    places = (
        (100 * record.offset_s(entry) / record.length_s, entry.kind.value)
        for entry in sorted(reasons, key=lambda entry: entry.kind is Kind.FAILURE)  # on top
    )
    return "".join(
        f'<i class="{kind}-mark" style="left:{place:.2f}%"></i>' for place, kind in places
    )
