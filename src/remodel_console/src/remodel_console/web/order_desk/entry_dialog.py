"""Asks for an entry of the preferences: its kind, its fields, and wires by clicks on the board."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from functools import partial

from nicegui import ui

from remodel_console.core.answer import DONE, CommandResult
from remodel_console.core.order_desk.preferences import (
    FIELD_HINTS,
    KINDS,
    WIRE_FIELDS,
    Document,
    chosen_wires,
    new_entry,
    with_clicked,
    with_entry,
)
from remodel_console.errors import CommandError
from remodel_console.web.order_desk.clicked_board import ClickedBoard
from remodel_console.web.page import Page

Change = Callable[[str, Callable[[Document], Document]], Awaitable[CommandResult]]
LIST_TITLES = {"require": "Required", "prefer": "Preferred"}
_HINT = "Click wires, or terminals for all their wires, to fill in '{}'; click again to remove."


class EntryDialog:
    """Asks for one entry; clicks on the board go to the field of wires that had the focus last."""

    def __init__(self, page: Page, change: Change, board: str, by_hand: Mapping[str, str]) -> None:
        """Open it.

        Args:
            page: that it is on.
            change: changes the preferences.
            board: address of the drawing; empty if there is none.
            by_hand: why no robot places a wire: it has no place in a plan.
        """
        self._change = change
        self._by_hand = by_hand
        self._inputs: dict[str, ui.input] = {}
        self._aimed = ""
        self._board: ClickedBoard | None = None
        with page.dialog("New entry") as self._dialog:
            ui.label("New entry").classes("title")
            with ui.element("div").classes("entry-parts wide"):
                with ui.element("div").classes("fields"):
                    self._add_fields()
                with ui.element("div") as self._beside:
                    if board:
                        self._hint = ui.label().classes("soft").props('role="status"')
                        self._board = ClickedBoard(board, self._click)
            self._show_kind()
            self._problem = ui.label().classes("bad-count").props('role="alert"')
            with ui.row():
                ui.button("Add", on_click=self._add).props("no-caps unelevated")
                ui.button("Cancel", on_click=self._dialog.close).props("no-caps flat")

    def _add_fields(self) -> None:
        words = {
            number: f"{LIST_TITLES[kind.list_name]}: {kind.meaning}"
            for number, kind in enumerate(KINDS)
        }
        self._kind = ui.select(words, value=0, label="What").props("outlined dense").classes("wide")
        self._kind.on_value_change(self._show_kind)
        self._name = ui.input("Name").props("outlined dense").classes("wide")
        self._fields = ui.element("div").classes("fields wide")

    def _show_kind(self) -> None:
        """Show the fields of the chosen kind."""
        self._fields.clear()
        self._inputs.clear()
        with self._fields:
            for field in KINDS[self._kind.value].fields:
                entry = ui.input(field).classes("wide").props("outlined dense stack-label")
                ui.label(FIELD_HINTS[field]).classes("soft")
                self._inputs[field] = entry
                if field in WIRE_FIELDS:
                    entry.on("focus", partial(self._aim, field))
                    entry.on_value_change(self._highlight)
        of_wires = [field for field in self._inputs if field in WIRE_FIELDS]
        self._beside.set_visibility(bool(of_wires) and self._board is not None)
        if of_wires:
            self._aim(of_wires[0])

    def _aim(self, field: str) -> None:
        """Have clicks on the board fill in a field."""
        self._aimed = field
        if self._board is None:
            return
        self._hint.text = _HINT.format(field)
        for entry in self._inputs.values():
            entry.classes(remove="aimed")
        self._inputs[field].classes("aimed")
        self._highlight()

    def _highlight(self) -> None:
        if self._board is not None:
            self._board.highlight(chosen_wires(self._inputs[self._aimed].value or "") or ())

    def _click(self, wires: Sequence[str]) -> None:
        entry = self._inputs.get(self._aimed)
        if entry is None:  # a click that was under way when another kind was chosen
            return
        placed = [wire for wire in wires if wire not in self._by_hand]
        self._problem.text = self._hand_words(wires)
        if not placed:
            return
        try:
            entry.value = with_clicked(entry.value or "", placed)
        except CommandError as error:
            self._problem.text = f"{self._aimed}: {error}"

    def _hand_words(self, wires: Iterable[str]) -> str:
        """Return why wires have no place in a plan; empty if all have one."""
        found = [
            f"{wire} is by hand: {self._by_hand[wire]}" for wire in wires if wire in self._by_hand
        ]
        return "; ".join(found)

    async def _add(self) -> None:
        kind = KINDS[self._kind.value]
        try:
            texts = {field: each.value or "" for field, each in self._inputs.items()}
            entry = new_entry(kind, self._name.value or "", texts)
        except CommandError as error:
            self._problem.text = str(error)
            return
        named = [wire for field in WIRE_FIELDS for wire in chosen_wires(texts.get(field, "")) or ()]
        by_hand = self._hand_words(named)
        if by_hand:
            self._problem.text = by_hand
            return
        answer = await self._change(
            f"add the preference '{entry['name']}'",
            lambda document: with_entry(document, kind.list_name, entry),
        )
        if answer.state == DONE:
            self._dialog.close()
