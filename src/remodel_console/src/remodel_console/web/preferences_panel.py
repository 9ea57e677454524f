"""The preferences of an order's plan on a page, and the dialog that asks for one."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

from nicegui import ui
from nicegui.element import Element

from remodel_console.core.commands import DONE, CommandResult
from remodel_console.core.order_desk import (
    FIELD_HINTS,
    KINDS,
    WIRE_FIELDS,
    Document,
    chosen_wires,
    entries,
    entry_words,
    new_entry,
    read_document,
    with_clicked,
    with_entry,
    without_entry,
    write_document,
)
from remodel_console.edge.order_drafts import DraftState
from remodel_console.errors import CommandError
from remodel_console.web.elements import card, icon_button
from remodel_console.web.page import Page
from remodel_run.findings import Plan


class ClickedBoard(Element, component="static/board.js"):
    """Shows a drawing, in which wires are highlighted, and reports clicks on wires."""

    def __init__(self, address: str, clicked: Callable[[Sequence[str]], object]) -> None:
        """Show the drawing of an address.

        Args:
            address: of the SVG of `remodel layout`.
            clicked: gets the name of a wire, or the names of all wires of a terminal.
        """
        super().__init__()
        self._props["address"] = address
        self._props["chosen"] = []
        self.on("clicked", lambda event: clicked([str(name) for name in event.args]))

    def highlight(self, wires: Sequence[str]) -> None:
        """Highlight these wires, and no others."""
        self._props["chosen"] = list(wires)


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


class PreferencesPanel:
    """Shows the entries, and changes them."""

    def __init__(self, page: Page, change: Change, replan: Callable[[], object]) -> None:
        """Take the page, and what changes the draft; `replan` plans it again."""
        self._page = page
        self._change = change
        self._replan = replan

    def show(self, now: DraftState, board: str) -> None:
        """Add the card; `board` is the address of the drawing, empty if there is none."""
        if now.imported is None:
            return
        hint = "Requirements bind every plan; a plan may violate a preference, and pays for it."
        conflicts = now.no_plan.conflicts if now.no_plan else ()
        conflict = [each.entry for requirements in conflicts for each in requirements]
        with card("Preferences", hint):
            for list_name, title in LIST_TITLES.items():
                found = entries(now.preferences, list_name)
                if found:
                    ui.label(title).classes("heading")
                for entry in found:
                    is_in_conflict = list_name == "require" and entry in conflict
                    self._show_entry(list_name, entry, is_in_conflict=is_in_conflict)
                    if now.is_planned and now.plan is not None:
                        _show_violated(now.plan, str(entry.get("name", "")))
            others = sorted(set(now.preferences) - {"format", *LIST_TITLES})
            if others:
                ui.label(f"Also: {', '.join(others)} (Edit all as YAML shows them)").classes("soft")
            with ui.row().classes("controls"):
                by_hand = now.imported.triage.hand_reasons if now.imported.triage else {}
                ask = partial(EntryDialog, self._page, self._change, board, by_hand)
                self._page.button("Add an entry", ask, icon="add", look="quiet")
                edit = partial(self._ask_document, now.preferences)
                self._page.button("Edit all as YAML", edit, icon="edit", look="quiet")
                if not now.is_planned and now.imported.triage:
                    words = "Plan again" if now.plan or now.no_plan else "Plan"
                    self._page.button(words, self._replan, icon="refresh")

    def _show_entry(
        self, list_name: str, entry: Mapping[str, Any], *, is_in_conflict: bool
    ) -> None:
        style = "preference conflict" if is_in_conflict else "preference"
        with ui.element("div").classes(style):
            with ui.element("div").classes("preference-words"):
                ui.label(str(entry.get("name", "without a name"))).classes("name")
                ui.label(entry_words(entry)).classes("code")
            title = f"Remove {entry.get('name', 'entry')}"
            remove = icon_button("delete", title, partial(self._remove, list_name, entry))
            remove.set_enabled(self._page.is_operator)

    async def _remove(self, list_name: str, entry: Mapping[str, Any]) -> None:
        await self._change(
            f"remove the preference '{entry.get('name', '')}'",
            lambda document: without_entry(document, list_name, entry),
        )

    def _ask_document(self, document: Document) -> None:
        """Have all edited as text."""
        with self._page.dialog("Preferences") as dialog:
            ui.label("Preferences as YAML").classes("title")
            ui.label("docs/planning.md describes zones, weights, prefer and require.").classes(
                "soft"
            )
            text = ui.textarea("YAML", value=write_document(document))
            text.props("outlined autogrow input-class=code-text").classes("wide yaml")
            problem = ui.label().classes("bad-count").props('role="alert"')

            async def save() -> None:
                try:
                    changed = read_document(text.value or "")
                except CommandError as error:
                    problem.text = str(error)
                    return

                def change(now: Document) -> Document:
                    if now != document:
                        raise CommandError(
                            "another person has changed the preferences meanwhile; copy your text, "
                            "close the dialog and open it again"
                        )
                    return changed

                answer = await self._change("edit the preferences", change)
                if answer.state == DONE:
                    dialog.close()

            with ui.row():
                ui.button("Save", on_click=save).props("no-caps unelevated")
                ui.button("Cancel", on_click=dialog.close).props("no-caps flat")


def _show_violated(plan: Plan, name: str) -> None:
    """Add on which wires a plan violates a preference, if it does."""
    words = [each.words for each in plan.violations if each.reason == name]
    if words:
        more = f", and {len(words) - 1} more" if len(words) > 1 else ""
        ui.label(f"Violated: {words[0]}{more}").classes("violated")
