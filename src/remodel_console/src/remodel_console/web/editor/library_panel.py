"""The library on the editor's page: the states and behaviors that a chart can use."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from nicegui import background_tasks, run, ui

from flexbe_synthesizer.core.chart.model import AnyNode, Behavior, Point, State
from flexbe_synthesizer.core.library.signature import StateClass
from remodel_console.core.editor import chart_edit
from remodel_console.core.editor.editing import Path, container_at
from remodel_console.edge.workspace import GENERATED
from remodel_console.web.editor.editing_page import EditingPage

_OWN, _GENERATED = "Behaviors", "Behaviors that the supervisor has made"
_NODE_TYPE = "application/x-remodel-node"  # as static/canvas.js takes it


class LibraryPanel:
    """Lists what is installed; a click shows what it does and offers to add it."""

    def __init__(self, page: EditingPage) -> None:
        """Build the panel."""
        self._page = page
        self._known: object = None
        self._entries: list[tuple[str, ui.element]] = []
        with ui.element("aside").classes("library").props('aria-label="Library"'):
            self._search = ui.input(placeholder="Find a state", on_change=self._filter)
            self._search.props('outlined dense clearable aria-label="Find a state"')
            self._search.on("focus", self._list_again)
            self._list = ui.element("div").classes("library-list")
        background_tasks.create(self._list_again())

    async def _list_again(self) -> None:
        """List what is installed, if that has changed."""
        catalogue = self._page.console.catalogue
        states = await run.io_bound(catalogue.states)
        behaviors: dict[str, list[str]] = {_OWN: [], _GENERATED: []}
        for one in await run.io_bound(catalogue.behaviors):
            is_generated = one.behavior.package == GENERATED
            behaviors[_GENERATED if is_generated else _OWN].append(one.name)
        if (states, behaviors) == self._known or self._list.is_deleted:
            return
        self._known = (states, behaviors)
        self._list.clear()
        self._entries.clear()
        with self._list:
            for package in dict.fromkeys(state.package for state in states):
                own = [state for state in states if state.package == package]
                self._add_group(package, " ".join(state.name for state in own))
                for state in own:
                    label = state.name.removesuffix("State")
                    entry = _entry(
                        label, f"state {package}/{state.name}", partial(self._show_state, state)
                    )
                    self._entries.append((f"{package} {state.name}", entry))
            for group, names in behaviors.items():
                if names or group == _OWN:
                    self._add_group(group, " ".join(names))
                for name in names:
                    entry = _entry(
                        name, f"behavior {name}", partial(self._add, Behavior(name, name), name)
                    )
                    self._entries.append((name, entry))
        self._filter()

    def _add_group(self, name: str, inside: str) -> None:
        """Add a heading, which is shown if anything in its group is."""
        self._entries.append((f"{name} {inside}", ui.label(name).classes("group")))

    def _filter(self) -> None:
        """Show what fits the search; no element is rebuilt, so that no click is lost."""
        word = (self._search.value or "").lower()
        for words, entry in self._entries:
            entry.set_visibility(word in words.lower())

    def _show_state(self, state: StateClass) -> None:
        """Show what a state does, and offer to add it."""
        with self._page.dialog() as dialog:
            ui.label(state.name).classes("title")
            ui.label(f"of {state.package}").classes("soft")
            ui.label(self._page.console.catalogue.documentation(state)).classes("documentation")

            async def add() -> None:
                dialog.close()
                name = state.name.removesuffix("State")
                await self._add(State(name, f"{state.package}/{state.name}"), name)

            self._page.button(f"Add {state.name.removesuffix('State')}", add, icon="add")

    async def add(self, what: str, path: Path, at: Point | None = None) -> None:
        """Add an entry to a container.

        Args:
            what: `state PACKAGE/CLASS` or `behavior NAME`.
            path: of the container.
            at: where it is drawn.
        """
        kind, _, name = what.partition(" ")
        if kind == "behavior":
            await self._add(Behavior(name, name, at=at), name, path)
        else:
            wanted = name.rpartition("/")[2].removesuffix("State")
            await self._add(State(wanted, name, at=at), wanted, path)

    async def _add(self, node: AnyNode, wanted: str, path: Path | None = None) -> None:
        """Add a node to a container, else to the one that is selected, or to the chart."""
        page = self._page
        if page.chart is None:
            ui.notify("Open a behavior first.", type="warning")
            return
        path = page.scope_path if path is None else path
        node_id = chart_edit.unused_id(container_at(page.chart, path), wanted)
        named = replace(node, id=node_id)
        what = f"add '{node_id}' to /{'/'.join(path)}"
        page.wants_value = True  # before the checks have shown what it needs
        if await page.change(what, path, lambda scope: chart_edit.with_node(scope, named)):
            page.select((*path, node_id))
        else:
            page.wants_value = False


def _entry(text: str, what: str, deed: Callable[[], object]) -> ui.element:
    """Return an entry that can be clicked, and dragged into the drawing."""
    with ui.element("button").classes("entry").on("click", deed) as entry:
        ui.label(text)
    drag = f"(event) => event.dataTransfer.setData('{_NODE_TYPE}', {json.dumps(what)})"
    return entry.props("draggable=true").on("dragstart", js_handler=drag)
