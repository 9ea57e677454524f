"""The head of the overview while no supervisor says how the order is."""

from __future__ import annotations

import time

from nicegui import ui

from remodel_console.core.use_case.use_case import UseCase
from remodel_run.progress import sums_words


class LastHead:
    """Shows why nothing can be started or commanded, and what was known last, without a button."""

    def __init__(self) -> None:
        """Build it."""
        with ui.element("div").classes("ending bad").props('role="alert"'):
            self._words = ui.label()
        with ui.element("div").classes("outdated wide") as self._run:
            with ui.row().classes("headline"):
                self._title = ui.label().classes("title")
                self._phase = ui.label().classes("state away")
                self._serial = ui.label().classes("soft")
            self._progress = ui.label().classes("soft")
            self._message = ui.label()

    def show(self, last: UseCase, words: str) -> None:
        """Show what was known last, and why that is all."""
        self._words.text = words
        self._run.set_visibility(last.run > 0)
        self._title.text, self._serial.text = last.order, last.serial
        self._phase.text = f"was: {last.phase.words}"
        self._progress.text = sums_words(last.sums)
        self._message.text = last.message


def time_words(wall_s: float) -> str:
    """Return the time of day of a wall time [s]."""
    return time.strftime("%H:%M:%S", time.localtime(wall_s))
