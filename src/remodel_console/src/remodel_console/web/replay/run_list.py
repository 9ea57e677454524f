"""The runs that can be replayed, as a list to choose from."""

from __future__ import annotations

import time
from collections.abc import Awaitable, Callable
from functools import partial

from nicegui import run, ui

from remodel_console.console import Console
from remodel_console.core.use_case.record import Summary
from remodel_console.core.use_case.use_case import duration_words
from remodel_console.errors import CommandError
from remodel_run.progress import sums_words

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
        with ui.element("aside").classes("runs").props('tabindex="0" aria-label="Runs"'):
            with ui.row().classes("runs-head"):
                ui.label("Runs").classes("title")
                again = ui.button(icon="refresh", on_click=self.list, color=None)
                again.props('flat dense round title="Reload" aria-label="Reload"')
            with ui.element("div").classes("wide") as self._area:
                ui.label(_UNKNOWN).classes("soft")

    async def list(self) -> tuple[Summary, ...]:
        """Request the runs, show and return them; none if no supervisor is running."""
        recorder = self._console.recorder
        self._area.clear()
        try:
            if recorder is None:
                raise CommandError("ROS is not running; records cannot be requested.")
            runs = await run.io_bound(recorder.runs)
        except CommandError as error:
            with self._area:
                ui.label(str(error)).classes("ending bad")
            return ()
        self._on_list(runs)
        self._area.clear()
        with self._area:
            if not runs:
                ui.label(_NONE).classes("soft")
            for summary in runs:
                self._show(summary)
        return runs

    def mark(self, number: int) -> None:
        """Mark the run that is open."""
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
