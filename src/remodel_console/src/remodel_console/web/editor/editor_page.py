"""The editor (Deliverable 5.1, 4.1): one chart as a drawing, as properties and as XML."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial

from nicegui import background_tasks, run, ui

from remodel_console.core.editor.drawing import collapsed
from remodel_console.core.editor.editing import Path, container_at, node_paths
from remodel_console.core.editor.fixes import counts, located
from remodel_console.core.editor.graph import Marks, chart_graph
from remodel_console.core.world import World
from remodel_console.edge.inspect_chart import inspect_text
from remodel_console.web.canvas import Canvas
from remodel_console.web.editor.certificate_panel import CertificatePanel
from remodel_console.web.editor.changes_panel import ChangesPanel
from remodel_console.web.editor.drawing_editor import Clipboard, DrawingEditor
from remodel_console.web.editor.editing_page import EditingPage
from remodel_console.web.editor.editor_tools import EditorTools
from remodel_console.web.editor.library_panel import LibraryPanel
from remodel_console.web.editor.problem_list import ProblemList
from remodel_console.web.editor.properties_panel import PropertiesPanel
from remodel_console.web.editor.xml_pane import XmlPane

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
                editor = DrawingEditor(self, self._library.add)
                may_edit = editor if self.is_operator else None
                self._canvas = Canvas("Edited state machine", editor, may_edit)
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
