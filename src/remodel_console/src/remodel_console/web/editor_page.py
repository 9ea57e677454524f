"""The editor (Deliverable 5.1, 4.1): one chart as a drawing, as properties and as XML."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from pathlib import Path as FilePath

from nicegui import background_tasks, run, ui

from flexbe_synthesizer.core.codec import write_chart
from flexbe_synthesizer.core.model import Chart
from flexbe_synthesizer.core.names import behavior_file, is_name
from flexbe_synthesizer.core.problem import Problem, Severity
from remodel_console.core import chart_edit
from remodel_console.core.answer import DONE
from remodel_console.core.commands import Command, Verb
from remodel_console.core.editing import Path, change_at, container_at
from remodel_console.core.folding import folded
from remodel_console.core.inspection import Inspection
from remodel_console.core.world import World
from remodel_console.edge.inspect_chart import inspect_text
from remodel_console.edge.picture import picture
from remodel_console.errors import CommandError
from remodel_console.web.canvas import Canvas
from remodel_console.web.library_panel import LibraryPanel
from remodel_console.web.page import Page
from remodel_console.web.properties_panel import PropertiesPanel

_ROOM = (640.0, 620.0)  # for the drawing on a common screen [pixels]
# What is typed into the XML means nothing else; but saving does, and is not the browser's.
_KEEP_KEYS = "(event) => { if (!(event.ctrlKey && event.key === 's')) event.stopPropagation(); }"
_OWN_SAVE = """<script>document.addEventListener("keydown", (event) => {
  if (event.ctrlKey && event.key === "s") event.preventDefault();
});</script>"""
_TYPED_S = 0.4  # without a key pressed, after which typed XML is taken in


class EditorPage(Page):
    """The page of the chart that is edited; all pages and /flexbe/uicommand share it."""

    KEYS = (
        ("Ctrl+S", "save"),
        ("Ctrl+Z", "undo"),
        ("Del", "delete what is selected"),
        ("Esc", "select nothing"),
    )

    def build(self) -> None:
        """Build the tools, the library, the drawing, and the panel beside it."""
        ui.add_head_html(_OWN_SAVE)
        self.chart: Chart | None = None
        self.inspection = Inspection()
        self.inspected: Chart | None = None
        self.selected: Path = ()
        self._open_path: Path = ()
        self._text = ""
        self._is_typing = False
        with ui.element("div").classes("editor"):
            self._build_tools()
            self._library = LibraryPanel(self)
            with ui.element("section").classes("stage"):
                self._canvas = Canvas("State machine that is edited", self._pick)
                self._empty = ui.label("Open a behavior, or make a new one.").classes("empty")
            with ui.element("aside").classes("panel side"):
                with ui.tabs().props("no-caps dense align=left").classes("wide") as tabs:
                    ui.tab("Properties")
                    ui.tab("XML")
                with ui.tab_panels(tabs, value="Properties").classes("wide panes") as self._tabs:
                    with ui.tab_panel("Properties"):
                        self._properties = PropertiesPanel(self)
                    with ui.tab_panel("XML").classes("xml-pane"):
                        self._xml = ui.codemirror(
                            language="XML", on_change=self._on_typed, theme=self._theme()
                        ).classes("xml")
                        self._xml.on("keydown", js_handler=_KEEP_KEYS)
                self._problems = ui.element("div").classes("problems").props('role="status"')
        self._typed = ui.timer(_TYPED_S, self._take_typed, active=False, once=False)

    def show(self, world: World) -> None:
        """Show the chart if it has changed, whoever has changed it."""
        chart = self.console.session.chart
        self._saved.text = _saved_words(chart, self.console.session.is_saved)
        if chart is self.chart:
            self._properties.show()
            return
        is_other = self.chart is None or chart is None or chart.file != self.chart.file
        self.chart = chart
        if is_other:
            self.selected = ()
            self._is_typing = False
            self._list_behaviors()
            self._open.value = chart.name if chart else None
        background_tasks.create(self._refresh(is_other))

    def press(self, key: str, *, ctrl: bool) -> None:
        """Do what a key means on this page."""
        deeds: dict[tuple[str, bool], Callable[[], object]] = {
            ("s", True): self._save,
            ("z", True): self._undo,
            ("Delete", False): self.delete,
            ("Escape", False): partial(self._pick, ""),
        }
        deed = deeds.get((key, ctrl))
        if deed is not None and self.is_operator:
            with self._dialogs:
                made = deed()
                if asyncio.iscoroutine(made):
                    background_tasks.create(made)

    # What panels use

    @property
    def scope_path(self) -> Path:
        """Return the container that new things go into: the selected one, or that around."""
        node = chart_edit.node_at(self.chart, self.selected) if self.chart else None
        return self.selected if hasattr(node, "body") else self.selected[:-1]

    def scope_of(self, path: Path) -> Chart:
        """Return the chart or container that a node is in."""
        if self.chart is None:
            raise CommandError("no behavior is open")
        return container_at(self.chart, path[:-1])

    async def change(self, what: str, path: Path, change: Callable[[Chart], Chart]) -> bool:
        """Change the container at a path; tell whether it could be."""
        session = self.console.session

        def deed() -> None:
            session.change(lambda chart: change_at(chart, path, change))

        self._is_typing = False
        return (await self.give(f"edit: {what}", deed)).state == DONE

    def select(self, path: Path) -> None:
        """Select a node, or nothing."""
        self.selected = path
        is_open = self._open_path[: len(self.scope_path)] == self.scope_path
        if self.chart is not None and not is_open and folded(self.chart, ()) is not self.chart:
            background_tasks.create(self._draw(True))
        self._canvas.select("/".join(path))
        self._properties.show()

    async def delete(self) -> None:
        """Delete what is selected."""
        if not self.selected:
            return
        path, (*_, node_id) = self.selected[:-1], self.selected
        what = f"delete '{'/'.join(self.selected)}'"
        if await self.change(what, path, lambda scope: chart_edit.without_node(scope, node_id)):
            self.select(())

    async def synthesize(self, path: Path, initial: str, goal: str) -> None:
        """Fill a container with the chart of a file, or show what is wrong with that."""
        session = self.console.session
        self._is_typing = False
        answer = await run.io_bound(
            self.console.desk.give,
            self.actor,
            f"synthesize {'/'.join(path)} i: {initial or 'start'} g: {goal}",
            lambda: session.synthesize(path[:-1], path[-1], initial, goal),
        )
        if answer.state == DONE:
            ui.notify(f"'{path[-1]}' is filled from {goal}", type="positive")
        else:
            self._show_refusal(goal, answer.words)

    # The chart, shown

    async def _refresh(self, is_other: bool) -> None:
        """Write the chart as XML, unless it is just being typed, and show all of it."""
        self._empty.set_visibility(self.chart is None)
        if self.chart is None:
            return
        if not self._is_typing:
            self._text = write_chart(self.chart)
            self._xml.set_value(self._text)
        await self._inspect()
        await self._draw(is_other)

    async def _inspect(self) -> None:
        chart = self.chart
        if chart is None:
            return
        _, self.inspection = await run.io_bound(
            inspect_text, self.console.workspace, self._text, chart.file
        )
        self.inspected = chart
        self._show_problems()
        self._properties.show()

    async def _draw(self, is_other: bool) -> None:
        chart = self.chart
        if chart is None:
            return
        self._open_path = self.scope_path
        try:
            svg = await run.io_bound(picture, folded(chart, self._open_path), _ROOM)
        except CommandError as error:
            ui.notify(str(error), type="negative")
            return
        if chart is self.chart:
            self._canvas.draw(svg, keeps_view=not is_other)
            self._canvas.select("/".join(self.selected))

    def _show_problems(self) -> None:
        """Show what is wrong, each a button that leads to its line."""
        problems = self.inspection.problems
        own = self.chart.file if self.chart else ""
        self._problems.clear()
        with self._problems:
            count = self.inspection.error_count
            words = "No errors." if not count else f"{count} error{'s' * (count > 1)}"
            ui.label(words).classes("soft" if not count else "bad-count")
            for problem in problems:
                _problem_line(problem, own, self._reveal)
        self._xml.decorations = [
            {"kind": "line", "line": p.position.line, "class": f"xml-{p.code.severity.value}"}
            for p in problems
            if p.position.file == own and p.position.line > 0
        ]

    def _reveal(self, line: int) -> None:
        self._tabs.value = "XML"
        self._xml.reveal_line(line)

    def _show_refusal(self, goal: str, words: str) -> None:
        """Show the errors of a chart that cannot be used, beside its lines."""
        text = self.console.workspace.text_of(goal)
        with self.dialog() as dialog:
            ui.label(f"{goal} cannot be used").classes("title")
            with ui.element("div").classes("refusal"):
                lines = _error_lines(words)
                with ui.element("pre").classes("source"):
                    for number, line in enumerate(text.splitlines(), start=1):
                        row = ui.label(f"{number:4}  {line}")
                        if number in lines:
                            row.classes("xml-error")
                with ui.element("div").classes("errors"):
                    for line in words.splitlines():
                        ui.label(_without_file(line))
            ui.button("Close", on_click=dialog.close).props("no-caps flat autofocus")

    # XML that is typed

    def _on_typed(self) -> None:
        if (self._xml.value or "") != self._text:
            self._typed.deactivate()
            self._typed.activate()

    async def _take_typed(self) -> None:
        """Take in the text that was typed: the chart if it has the form of one, else its errors."""
        self._typed.deactivate()
        text, old = self._xml.value or "", self.chart
        if text == self._text or old is None or not self.is_operator:
            return
        self._text, self._is_typing = text, True
        chart, self.inspection = await run.io_bound(
            inspect_text, self.console.workspace, text, old.file
        )
        if chart is not None and chart != old:
            await self.give("edit: the XML", lambda: self.console.session.change(lambda _: chart))
        self._show_problems()

    # Tools

    def _build_tools(self) -> None:
        with ui.row().classes("tools"):
            self._open = ui.select(
                [], label="Open", with_input=True, on_change=lambda event: self._load(event.value)
            )
            self._open.props("outlined dense").classes("opener")
            self._open.on("focus", self._list_behaviors)
            self._list_behaviors()
            self.button("New", self._ask_new, icon="add", look="quiet")
            self.button("Container", self._add_container, icon="select_all", look="quiet")
            self.button("Undo", self._undo, icon="undo", look="quiet")
            self.button("Save", self._save, icon="save")
            self._saved = ui.label().classes("soft")

    def _list_behaviors(self) -> None:
        charts = {chart.name for chart in self.console.workspace.charts()}
        known = charts | {one.name for one in self.console.catalogue.behaviors()}
        known |= {self.chart.name} if self.chart else set()
        self._open.set_options(sorted(known))

    async def _load(self, name: str | None) -> None:
        session = self.console.session
        if not name or (session.chart is not None and session.chart.name == name):
            return
        command = Command(f"load {name}", Verb.LOAD, {"name": name})

        async def do() -> None:
            await self.give(command.text, lambda: session.carry_out(command))

        if session.is_saved or session.chart is None:
            await do()
        else:
            question = f"'{session.chart.name}' has changes that are not saved."
            self.ask(question, "Open, and lose them", do)

    async def _save(self) -> None:
        command = Command("save", Verb.SAVE)
        answer = await self.give("save", lambda: self.console.session.carry_out(command))
        if answer.state == DONE:
            ui.notify(answer.words.partition(":")[0], type="positive")

    async def _undo(self) -> None:
        self._is_typing = False
        await self.give("undo", self.console.session.undo)

    async def _add_container(self) -> None:
        path = self.scope_path
        if self.chart is None:
            ui.notify("Open a behavior first.", type="warning")
            return
        node_id = chart_edit.unused_id(container_at(self.chart, path), "Container")
        node = chart_edit.new_container(node_id)
        what = f"add container '{node_id}'"
        if await self.change(what, path, lambda scope: chart_edit.with_node(scope, node)):
            self.select((*path, node_id))

    def _ask_new(self) -> None:
        """Ask how a new behavior is called, and where it goes."""
        folders = [str(folder) for folder in self.console.workspace.chart_folders]
        with self.dialog() as dialog:
            ui.label("A new behavior").classes("title")
            name = ui.input("Name").props("outlined dense autofocus").classes("wide")
            folder = ui.select(folders, value=folders[0], label="Folder of its chart")
            folder.props("outlined dense").classes("wide")

            async def make() -> None:
                if await self._make(name.value or "", str(folder.value)):
                    dialog.close()

            self.button("Make", make)

    async def _make(self, name: str, folder: str) -> bool:
        if not is_name(name):
            ui.notify("A name has letters, digits and single blanks.", type="warning")
            return False
        file = FilePath(folder) / f"{behavior_file(name)}.xml"
        if file.exists():
            ui.notify(f"{file} is there already.", type="warning")
            return False
        chart = chart_edit.new_chart(name, str(file))
        answer = await self.give(f"new '{name}'", lambda: self.console.session.open(chart))
        return answer.state == DONE

    def _pick(self, text: str) -> None:
        """Select what was clicked in the drawing; a start or an end selects what is around it."""
        path = tuple(filter(None, text.split("/")))
        while path and self.chart and chart_edit.node_at(self.chart, path) is None:
            path = path[:-1]
        self.select(path)

    def _theme(self) -> str:
        return "githubDark" if self._dark.value else "githubLight"


def _saved_words(chart: Chart | None, is_saved: bool) -> str:
    if chart is None:
        return ""
    return f"{chart.name}: {'saved' if is_saved else 'not saved yet'}"


def _problem_line(problem: Problem, own: str, reveal: Callable[[int], None]) -> None:
    """Add a problem as a button."""
    file, line, _ = problem.position
    where = f"line {line}" if file == own else f"{FilePath(file).name}, line {line}"
    style = "warning" if problem.code.severity is Severity.WARNING else "error"
    with ui.element("button").classes(f"problem {style}").on("click", lambda: reveal(line)):
        ui.label(where).classes("place")
        ui.label(problem.message)


def _without_file(line: str) -> str:
    """Return a line of an answer without the file, which stands above it."""
    parts = line.split(":", 3)
    return f"Line {parts[1]}:{parts[3]}" if len(parts) > 3 and parts[1].isdigit() else line


def _error_lines(words: str) -> frozenset[int]:
    """Return the lines that an answer of the checks names, `file:line:column: [code] message`."""
    parts = (line.split(":") for line in words.splitlines())
    return frozenset(int(p[1]) for p in parts if len(p) > 3 and p[1].isdigit())
