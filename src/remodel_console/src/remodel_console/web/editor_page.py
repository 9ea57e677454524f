"""The editor (Deliverable 5.1, 4.1): one chart as a drawing, as properties and as XML."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from dataclasses import replace
from functools import partial
from typing import TypeAlias

from nicegui import background_tasks, run, ui

from flexbe_synthesizer.core.chart.model import AnyNode, Behavior, Chart, Point, State
from flexbe_synthesizer.core.library.signature import StateClass
from remodel_console.core import chart_edit
from remodel_console.core.copying import Copied, copied, pasted
from remodel_console.core.drawing import Marks, chart_graph, collapsed
from remodel_console.core.editing import Path, container_at, node_paths, read_path
from remodel_console.core.inspection import counts, located
from remodel_console.core.world import World
from remodel_console.edge.workspace import GENERATED, inspect_text
from remodel_console.web.canvas import Canvas
from remodel_console.web.editing_page import (
    CertificatePanel,
    ChangesPanel,
    EditingPage,
    ProblemList,
    XmlPane,
)
from remodel_console.web.editor_tools import EditorTools
from remodel_console.web.properties_panel import PropertiesPanel


class Clipboard:
    """The states that were copied last on a page."""

    def __init__(self, page: EditingPage) -> None:
        self._page = page
        self._copied = Copied()

    def copy(self) -> None:
        """Copy the selected states."""
        page = self._page
        if page.chart is None or not page.selection:
            ui.notify("Select the states to copy first.", type="warning")
            return
        self._copied = copied(page.chart, page.selection)
        ui.notify(f"Copied {_names(self._copied)}.")

    async def cut(self) -> None:
        """Copy the selected states, and delete them."""
        self.copy()
        await self._page.delete()

    async def paste(self) -> None:
        """Add the copied states to the selected container, or to that of the selected state."""
        page = self._page
        if page.chart is None or not self._copied.nodes:
            ui.notify("Copy states first.", type="warning")
            return
        path, ids = page.paste_path(self._copied), []

        def change(scope: Chart) -> Chart:
            changed, new = pasted(scope, self._copied)
            ids[:] = new
            return changed

        if await page.change(f"paste {_names(self._copied)}", path, change):
            page.select(*((*path, node_id) for node_id in ids))


def _names(what: Copied) -> str:
    return ", ".join(f"'{node.id}'" for node in what.nodes)


Add: TypeAlias = Callable[[str, Path, Point | None], Awaitable[None]]


Places: TypeAlias = dict[str, list[int]]


class DrawingEditor:
    """Takes what the drawing reports.

    Attributes:
        canvas: the drawing.
    """

    def __init__(self, page: EditingPage, add: Add) -> None:
        """Change the chart of a page; `add` adds an entry of the library to a container."""
        self._page = page
        self._add = add
        self.canvas = Canvas("Edited state machine", self.pick, is_editable=page.is_operator)
        if page.is_operator:
            self.canvas.on("connect", lambda event: self.connect(**event.args))
            self.canvas.on("moved", lambda event: self.move(**event.args))
            self.canvas.on("dropped", lambda event: self.drop(**event.args))

    def pick(self, paths: tuple[str, ...]) -> None:
        """Select what was clicked; a start or an end selects what is around it."""
        page = self._page
        chosen: list[Path] = []
        for text in paths:
            path = read_path(text)
            while path and page.chart and chart_edit.node_at(page.chart, path) is None:
                path = path[:-1]
            chosen.append(path)
        page.select(*filter(None, chosen))

    async def connect(self, path: str, event: str, target: str) -> None:
        """Lead an outcome of a state to a target beside it."""
        *around, node_id = read_path(path)
        change = partial(chart_edit.led, node_id=node_id, event=event, target=target)
        await self._page.change(f"{node_id}: '{event}' leads to '{target}'", tuple(around), change)

    async def move(self, scope: str, states: Places, outcomes: Places) -> None:
        """Keep where what is in a container was put."""
        change = partial(_placed, states=states, outcomes=outcomes)
        await self._page.change(f"place what is in /{scope}", read_path(scope), change)

    async def drop(self, what: str, scope: str, at: list[int] | None) -> None:
        """Add an entry of the library to a container."""
        await self._add(what, read_path(scope), None if at is None else (at[0], at[1]))


def _placed(scope: Chart, states: Places, outcomes: Places) -> Chart:
    """Return the scope with its parts drawn at these places."""

    def place(places: Places, name: str, before: tuple[int, int] | None) -> tuple[int, int] | None:
        found = places.get(name)
        return before if found is None else (int(found[0]), int(found[1]))

    return replace(
        scope,
        nodes=tuple(replace(n, at=place(states, n.id, n.at)) for n in scope.nodes),
        outcomes=tuple(replace(o, at=place(outcomes, o.name, o.at)) for o in scope.outcomes),
    )


_OWN, _GENERATED = "Behaviors", "Behaviors that the supervisor has made"
_NODE_TYPE = "application/x-remodel-node"  # as static/canvas.js takes it


class LibraryPanel:
    """Lists what is installed; a click shows what it does and offers to add it."""

    def __init__(self, page: EditingPage) -> None:
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


_SCRIPT = """<script>document.addEventListener("keydown", (event) => {
  const isIn = (selector) => event.target.closest(selector);
  const ours = isIn(".cm-editor") ? "s" : isIn("input, textarea") ? "sf" : "sfayg";
  if (!event.ctrlKey || !ours.includes(event.key)) return;
  event.preventDefault();
  if (event.key === "f") document.querySelector(".finder input").focus();
});
addEventListener("beforeunload", () => emitEvent("editor-left"));</script>"""


class EditorPage(EditingPage):
    """The page of a chart that is edited, with a session of its own."""

    KEYS = (
        ("Ctrl+S", "save"),
        ("Ctrl+Z  Ctrl+Y", "undo, redo"),
        ("B  N", "select the previous or the next state"),
        ("Del", "delete the selected states"),
        ("Ctrl+C  Ctrl+X  Ctrl+V", "copy, cut and paste states"),
        ("Shift+click, Shift+drag", "select several states"),
        ("Ctrl+A  Ctrl+F", "select all states of the container, find a state"),
        ("Ctrl+G", "put the selected states into a container"),
        ("Esc", "clear the selection"),
    )

    def build(self) -> None:
        """Build the tools, the library, the drawing, and the panel beside it."""
        ui.add_head_html(_SCRIPT)
        super().build()
        self._open_path: Path = ()
        self.clipboard = Clipboard(self)
        with ui.element("div").classes("editor"):
            self._tools = EditorTools(self)
            self._library = LibraryPanel(self)
            with ui.element("section").classes("stage"):
                self._canvas = DrawingEditor(self, self._library.add).canvas
                self._empty = ui.label("Open a behavior, or create a new one.").classes("empty")
            with ui.element("aside").classes("panel side"):
                with ui.tabs().props("no-caps dense align=left").classes("wide") as tabs:
                    ui.tab("Properties")
                    ui.tab("XML")
                    ui.tab("Changes")
                    ui.tab("Certificate")
                panels = ui.tab_panels(tabs, value="Properties", on_change=self._certify)
                with panels.classes("wide panes") as self._tabs:
                    with ui.tab_panel("Properties"):
                        self._properties = PropertiesPanel(self)
                    with ui.tab_panel("XML").classes("xml-pane"):
                        self.xml = XmlPane(self._take_typed, is_dark=self.is_dark)
                    with ui.tab_panel("Changes"):
                        self._changes = ChangesPanel(self)
                    with ui.tab_panel("Certificate"):
                        self._certificate = CertificatePanel()
                self._problems = ProblemList(self, self._reveal)

    def show(self, world: World) -> None:
        """Show the chart if it has changed."""
        session = self.session
        chart = session.chart
        self._tools.show_saved(session)
        if chart is self.chart:
            self._properties.show()
            return
        is_other = self.chart is None or chart is None or chart.file != self.chart.file
        self.chart = chart
        if is_other:
            self.selected, self.selection = (), ()
            self.xml.is_typing = False
            self._tools.show_other(chart)
        background_tasks.create(self._refresh(is_other))

    def press(self, key: str, *, ctrl: bool) -> None:
        """Do what a key means on this page."""
        moves = {"b": -1, "n": 1}
        if key.lower() in moves and not ctrl:
            self._step(moves[key.lower()])
            return
        deeds: dict[tuple[str, bool], Callable[[], object]] = {
            ("s", True): self._tools.save,
            ("z", True): self._tools.undo,
            ("y", True): self._tools.redo,
            ("Z", True): self._tools.redo,
            ("Delete", False): self.delete,
            ("Escape", False): partial(self.select, ()),
            ("c", True): self.clipboard.copy,
            ("x", True): self.clipboard.cut,
            ("v", True): self.clipboard.paste,
            ("a", True): self._select_all,
            ("g", True): self._tools.group,
        }
        deed = deeds.get((key, ctrl))
        if deed is not None and self.is_operator:
            with self._dialogs:
                made = deed()
                if asyncio.iscoroutine(made):
                    background_tasks.create(made)

    def select(self, *paths: Path) -> None:
        """Select nodes, or the chart; the properties are those of the first."""
        self.selection = paths if paths and paths[0] else ()
        path = self.selection[0] if self.selection else ()
        self.selected = path
        is_open = self._open_path[: len(self.scope_path)] == self.scope_path
        if self.chart is not None and not is_open and collapsed(self.chart, ()) is not self.chart:
            background_tasks.create(self._draw(True))
        self._canvas.select(["/".join(one) for one in self.selection])
        self._properties.show()

    # The chart, shown

    async def _refresh(self, is_other: bool) -> None:
        """Show all of the chart."""
        self._empty.set_visibility(self.chart is None)
        if self.chart is None:
            return
        self.xml.show(self.session.text)
        await self._inspect()
        await self._draw(is_other)

    async def _inspect(self) -> None:
        chart = self.chart
        if chart is None:
            return
        _, self.inspection = await run.io_bound(
            inspect_text, self.console.workspace, self.xml.text, chart.file
        )
        self.inspected = chart
        self._show_problems()
        self._changes.show()
        self._properties.show()

    async def _draw(self, is_other: bool) -> None:
        chart = self.chart
        if chart is None:
            return
        self._open_path = self.scope_path
        part = collapsed(chart, self._open_path)
        marks = Marks(self.inspection, counts(self.found))
        graph = await run.io_bound(chart_graph, part, marks)
        if chart is self.chart:
            self._canvas.draw(graph, keeps_view=not is_other)
            self._canvas.select(["/".join(path) for path in self.selection])

    def _show_problems(self) -> None:
        own = self.chart.file if self.chart else ""
        self.found = located(self.inspection)
        self._problems.show(self.inspection, own, self.found)
        self.xml.mark(self.inspection, own)
        self._certify()

    def _certify(self) -> None:
        """Show the certificate, if its tab is open."""
        if self._tabs.value == "Certificate":
            background_tasks.create(self._certificate.show(self.inspection))

    def _reveal(self, line: int) -> None:
        self._tabs.value = "XML"
        self.xml.reveal(line)

    async def _take_typed(self, text: str) -> None:
        """Take in the text that was typed: the chart if it has the form of one, else its errors."""
        old = self.chart
        if old is None or not self.is_operator:
            return
        self.xml.text, self.xml.is_typing = text, True
        chart, self.inspection = await run.io_bound(
            inspect_text, self.console.workspace, text, old.file
        )
        if chart is not None:
            await self.give("edit: the XML", lambda: self.session.retype(text))
        self._show_problems()

    def _select_all(self) -> None:
        """Select all states of the container that is selected, or around the selected state."""
        if self.chart is not None:
            path = self.scope_path
            nodes = container_at(self.chart, path).nodes
            self.select(*((*path, node.id) for node in nodes))

    def _step(self, step: int) -> None:
        """Select the next state or container, or the one before; of none, the first or last."""
        paths = node_paths(self.chart) if self.chart else ()
        if not paths:
            return
        if self.selected in paths:
            self.select(paths[(paths.index(self.selected) + step) % len(paths)])
        else:
            self.select(paths[0 if step > 0 else -1])
