"""The tools above the editor: open, make, undo and save a chart, add a container."""

from __future__ import annotations

import logging
from pathlib import Path as FilePath

from nicegui import background_tasks, run, ui

from flexbe_synthesizer.core.chart.model import Chart
from flexbe_synthesizer.core.chart.names import behavior_file, is_behavior_name, is_name
from remodel_console.core.answer import DONE
from remodel_console.core.commands import Command, Verb
from remodel_console.core.editor import chart_edit
from remodel_console.core.editor.editing import container_at
from remodel_console.errors import CommandError
from remodel_console.web.editor.editing_page import EditingPage

_LOG = logging.getLogger(__name__)


class EditorTools:
    """A row of buttons."""

    def __init__(self, page: EditingPage) -> None:
        """Build the row."""
        self._page = page
        with ui.row().classes("tools"):
            self._open = ui.select(
                [], label="Open", with_input=True, on_change=lambda event: self._load(event.value)
            )
            self._open.props("outlined dense").classes("opener")
            self._open.on("focus", self._list)
            background_tasks.create(self._list())
            page.button("New", self._ask_new, icon="add", look="quiet")
            page.button("Container", self._add_container, icon="select_all", look="quiet")
            page.button("Undo", self.undo, icon="undo", look="quiet")
            page.button("Save", self.save, icon="save")
            self._saved = ui.label().classes("soft")

    def show_saved(self, chart: Chart | None, *, is_saved: bool) -> None:
        """Show whether the chart is saved."""
        state = "saved" if is_saved else "not saved yet"
        self._saved.text = f"{chart.name}: {state}" if chart else ""

    def show_other(self, chart: Chart | None) -> None:
        """Show that another chart is open."""
        name = chart.name if chart else None
        self._open.set_options([*filter(None, (name,))], value=name)
        background_tasks.create(self._list())

    async def save(self) -> None:
        """Save the chart, or show why it cannot be saved."""
        session = self._page.console.session
        command = Command("save", Verb.SAVE)
        answer = await self._page.give("save", lambda: session.carry_out(command))
        if answer.state == DONE:
            ui.notify(answer.words.partition(":")[0], type="positive")

    async def undo(self) -> None:
        """Take the last change back."""
        self._page.xml.is_typing = False
        await self._page.give("undo", self._page.console.session.undo)

    async def _list(self) -> None:
        """Offer all charts and behaviors."""
        known = await run.io_bound(self._names)
        chart = self._page.chart
        self._open.set_options(sorted({*known, *((chart.name,) if chart else ())}))

    def _names(self) -> set[str]:
        console = self._page.console
        behaviors = {one.name for one in console.catalogue.behaviors()}
        try:
            return behaviors | set(console.workspace.names())
        except CommandError:
            _LOG.exception("cannot list the charts")
            return behaviors

    async def _load(self, name: str | None) -> None:
        chart = self._page.console.session.chart
        if name and (chart is None or chart.name != name):
            await self._page.load(name)

    async def _add_container(self) -> None:
        page = self._page
        if page.chart is None:
            ui.notify("Open a behavior first.", type="warning")
            return
        path = page.scope_path
        node_id = chart_edit.unused_id(container_at(page.chart, path), "Container")
        node = chart_edit.new_container(node_id)
        what = f"add container '{node_id}'"
        if await page.change(what, path, lambda scope: chart_edit.with_node(scope, node)):
            page.select((*path, node_id))

    def _ask_new(self) -> None:
        """Ask how a new behavior is called, and where it goes."""
        folders = [str(folder) for folder in self._page.console.workspace.chart_folders]
        with self._page.dialog() as dialog:
            ui.label("New behavior").classes("title")
            name = ui.input("Name").props("outlined dense autofocus").classes("wide")
            folder = ui.select(folders, value=folders[0], label="Chart folder")
            folder.props("outlined dense").classes("wide")

            async def make() -> None:
                if await self._make(name.value or "", str(folder.value)):
                    dialog.close()

            self._page.button("Create", make)

    async def _make(self, name: str, folder: str) -> bool:
        if not (is_name(name) and is_behavior_name(name)):
            ui.notify(
                "A name has letters, digits and single blanks, of which at least the first of a-z, "
                "A-Z, 0-9 and '_' is a letter, and 200 at most.",
                type="warning",
            )
            return False
        file = FilePath(folder) / f"{behavior_file(name)}.xml"
        if file.exists():
            ui.notify(f"{file} exists already.", type="warning")
            return False
        chart = chart_edit.new_chart(name, str(file))
        session = self._page.console.session
        return (await self._page.give(f"new '{name}'", lambda: session.open(chart))).state == DONE
