"""The line below the bar: what runs, what does not, and what to do about it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager

from nicegui import ui

from remodel_console.core.world import Notice, Part, World, notices

_NO_DATABASE = "orders cannot be stored; start the console with database:=URL"
_NAMES = {Part.ENGINE: "Engine", Part.SUPERVISOR: "Supervisor", Part.CELL: "Cell"}


class StatusLine:
    """Built once for each page."""

    def __init__(
        self,
        parts: Sequence[Part],
        database: Callable[[], str],
        dialog: Callable[[str], AbstractContextManager[ui.dialog]],
    ) -> None:
        """Build the line.

        Args:
            parts: what the page needs to be running.
            database: returns that orders are stored in, as it is shown; empty without one.
            dialog: opens a dialog of a name.
        """
        self._parts = parts
        self._dialog = dialog
        self._database = database
        self._shown: object = None
        self._found: tuple[Notice, ...] = ()
        with ui.row().classes("status-line").props('role="status"'):
            self._ros = ui.label()
            self._chips = {part: ui.label() for part in _NAMES}
            self._database_chip = ui.label()
            self._more = ui.button("What to do", on_click=self._explain)
            self._more.props("flat dense no-caps color=primary")

    def show(self, world: World) -> None:
        """Show what runs."""
        self._found = tuple(notices(world, self._parts))
        runs = {part: world.has(part) for part in self._chips}
        database = self._database()
        shown = (self._found, world.has_master, world.servers, world.cell_kind, runs, database)
        if shown == self._shown:
            return
        self._shown = shown
        missing = {notice.part: notice.what for notice in self._found}
        _show(self._ros, "ROS", missing.get(None), runs=world.has_master)
        for part, chip in self._chips.items():
            what = missing.get(part)
            if part is Part.ENGINE:
                what = what or missing.get(Part.MIRROR)
            _show(chip, _words(part, world), what, runs=runs[part])
        _show(
            self._database_chip,
            "Database" if database else "No database",
            None,
            runs=bool(database),
        )
        self._database_chip.props["title"] = database or _NO_DATABASE
        self._more.set_visibility(bool(self._found))

    def _explain(self) -> None:
        with self._dialog("What to do"):
            for notice in self._found:
                ui.label(notice.what).classes("title")
                ui.label(f"{notice.meaning[:1].upper()}{notice.meaning[1:]}. In a terminal:")
                ui.label(notice.remedy).classes("code")


def _words(part: Part, world: World) -> str:
    if part is not Part.CELL or world.cell_kind is None:
        return _NAMES[part]
    ending = "y" if world.servers == 1 else "ies"
    return f"Cell: {world.cell_kind.value}, {world.servers} abilit{ending}"


def _show(chip: ui.label, words: str, missing: str | None, *, runs: bool) -> None:
    """Show a chip: green, red if the page misses it, hollow if it does not."""
    chip.text = missing or words
    look = "gone notice" if missing else "there" if runs else "absent"
    chip.classes(replace=f"presence {look}")
