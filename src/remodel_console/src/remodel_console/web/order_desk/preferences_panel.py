"""The preferences of an order's plan on a page: what a plan should do, and what it must do."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from nicegui import ui

from remodel_console.core.answer import DONE
from remodel_console.core.order_desk.preferences import (
    Document,
    entries,
    entry_words,
    read_document,
    without_entry,
    write_document,
)
from remodel_console.edge.order_desk.order_drafts import DraftState
from remodel_console.errors import CommandError
from remodel_console.web.order_desk.entry_dialog import LIST_TITLES, Change, EntryDialog
from remodel_console.web.page import Page, card
from remodel_run.findings import Plan


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
            remove = ui.button(icon="delete", color=None).props(
                f'flat dense round title="Remove {entry.get("name", "entry")}"'
            )
            remove.props["aria-label"] = f"Remove {entry.get('name', 'entry')}"
            remove.set_enabled(self._page.is_operator)
            remove.on_click(partial(self._remove, list_name, entry))

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
