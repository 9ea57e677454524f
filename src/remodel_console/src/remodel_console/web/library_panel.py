"""The library on the editor's page: the states and behaviors that a chart can use."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from nicegui import ui

from flexbe_synthesizer.core.model import AnyNode, Behavior, State
from flexbe_synthesizer.core.signature import StateClass
from remodel_console.core import chart_edit
from remodel_console.core.editing import container_at

if TYPE_CHECKING:
    from remodel_console.web.editor_page import EditorPage


class LibraryPanel:
    """Lists what is installed; a click tells what it does and offers to add it."""

    def __init__(self, page: EditorPage) -> None:
        """Build the panel."""
        self._page = page
        with ui.element("aside").classes("library"):
            self._search = ui.input(placeholder="Find a state", on_change=self._show)
            self._search.props('outlined dense clearable aria-label="Find a state"')
            self._list = ui.element("div").classes("library-list")
        self._show()

    def _show(self) -> None:
        """List what fits the search."""
        word = (self._search.value or "").lower()
        catalogue = self._page.console.catalogue
        self._list.clear()
        with self._list:
            package = ""
            for state in catalogue.states():
                if word not in f"{state.package} {state.name}".lower():
                    continue
                if state.package != package:
                    package = state.package
                    ui.label(package).classes("group")
                _entry(state.name.removesuffix("State"), partial(self._show_state, state))
            found = [one.name for one in catalogue.behaviors() if word in one.name.lower()]
            if found:
                ui.label("Behaviors").classes("group")
            for name in found:
                _entry(name, partial(self._add, Behavior(name, name), name))

    def _show_state(self, state: StateClass) -> None:
        """Tell what a state does, and offer to add it."""
        with self._page.dialog() as dialog:
            ui.label(state.name).classes("title")
            ui.label(f"of {state.package}").classes("soft")
            ui.label(self._page.console.catalogue.documentation(state)).classes("documentation")

            async def add() -> None:
                dialog.close()
                name = state.name.removesuffix("State")
                await self._add(State(name, f"{state.package}/{state.name}"), name)

            self._page.button(f"Add {state.name.removesuffix('State')}", add, icon="add")

    async def _add(self, node: AnyNode, wanted: str) -> None:
        """Add a node to the container that is selected, or to the chart."""
        page = self._page
        if page.chart is None:
            ui.notify("Open a behavior first.", type="warning")
            return
        path = page.scope_path
        node_id = chart_edit.unused_id(container_at(page.chart, path), wanted)
        named = type(node)(id=node_id, type=node.type)
        what = f"add '{node_id}' to /{'/'.join(path)}"
        if await page.change(what, path, lambda scope: chart_edit.with_node(scope, named)):
            page.select((*path, node_id))


def _entry(text: str, deed: object) -> None:
    with ui.element("button").classes("entry").on("click", deed):
        ui.label(text)
