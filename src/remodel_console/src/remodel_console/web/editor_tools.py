"""The tools above the editor: open, make, undo and save a chart, add a container."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path as FilePath

from nicegui import run, ui

from flexbe_synthesizer.core.chart.model import Chart
from flexbe_synthesizer.core.chart.names import behavior_file, is_behavior_name, is_name
from remodel_console.core import chart_edit
from remodel_console.core.commands import DONE, FAILED
from remodel_console.core.copying import grouped, outermost
from remodel_console.core.editing import Path, connected, container_at, matches, unplaced
from remodel_console.errors import FileChangedError
from remodel_console.session import Left, Session
from remodel_console.web.editing_page import SESSION, EditingPage, changes_html


class EditorTools:
    """A row of buttons."""

    def __init__(self, page: EditingPage) -> None:
        self._page = page
        with ui.row().classes("tools"):
            self._open = ui.select(
                self._options(),
                label="Open",
                with_input=True,
                on_change=lambda event: self._load(event.value),
            )
            self._open.props("outlined dense").classes("opener")
            self._open.on("focus", self._list)
            page.button("New", self._new, icon="add", look="quiet")
            _small(page, "Save as", self._ask_copy, "file_copy", "Save a copy under another name")
            _small(page, "Container", self._add_container, "select_all", "Add an empty container")
            _small(page, "Group", self.group, "workspaces", "Group the selected states (Ctrl+G)")
            _small(
                page,
                "Connect",
                self._connect,
                "cable",
                "Lead unconnected outcomes to the ends of their names",
            )
            self._undo = _small(page, "Undo", self.undo, "undo", "Undo (Ctrl+Z)")
            self._redo = _small(page, "Redo", self.redo, "redo", "Redo (Ctrl+Y)")
            _small(
                page,
                "Arrange",
                self._arrange,
                "auto_fix_high",
                "Lay the states out again; places given by hand are dropped",
            )
            page.button("Save", self.save, icon="save")
            page.button("Run", self._run, icon="play_arrow", look="quiet").tooltip(
                "Save, and open Runtime control to start it"
            )
            self._find = ui.input(placeholder="Find in the chart", on_change=self._count)
            self._find.props('outlined dense clearable aria-label="Find in the chart"')
            self._find.classes("finder").on("keydown.enter", self._next)
            self._matches = ui.label().classes("matches").props('role="status"')
            self._saved = ui.label().classes("soft")
            self._others = ui.label().classes("left-unsaved").props('role="status"')
            ui.space()
            self._left = ui.element("div").classes("left-list")
        self._left_shown: tuple[Left, ...] = ()

    def _show_left(self) -> None:
        """Offer to continue what closed pages have left unsaved."""
        found = self._page.console.sessions.left_unsaved()
        if found == self._left_shown:
            return
        self._left_shown = found
        self._left.clear()
        with self._left:
            for left in found:
                with ui.row().classes("left-unsaved"):
                    ui.label(
                        f"A closed page has unsaved changes of '{left.name}', {left.changed_at}."
                    )
                    ui.link("Continue", f"/editor?{SESSION}={left.key}")
                    discard = partial(self._page.console.sessions.discard, left.key)
                    self._page.button("Discard", discard, look="quiet")

    def show_saved(self, session: Session) -> None:
        """Show whether the chart is saved, what can be undone, and who has it open, too."""
        chart = session.chart
        kept = "draft, saved" if session.is_kept else "not saved yet"
        state = "saved" if session.is_saved else kept
        self._saved.text = f"{chart.name}: {state}" if chart else ""
        is_operator = self._page.is_operator
        self._undo.set_enabled(is_operator and session.can_undo)
        self._redo.set_enabled(is_operator and session.can_redo)
        others = self._page.others
        self._others.text = f"Also open by {', '.join(others)}" if others else ""
        self._others.set_visibility(bool(others))
        self._show_left()

    def show_other(self, chart: Chart | None) -> None:
        """Show that another chart is open."""
        self._open.set_options(self._options(), value=chart.name if chart else None)

    async def save(self) -> None:
        """Save the chart; while it has errors, as a draft."""
        session = self._page.session
        theirs: list[str] = []

        def deed() -> str:
            try:
                return session.save_or_keep()
            except FileChangedError as error:
                theirs.append(error.now)
                raise

        answer = await self._page.give("save", deed, shows_error=False)
        if theirs:
            self._show_conflict(answer.words, theirs[0])
        elif answer.state == FAILED:
            self._page.show_error(answer.words)
        elif answer.state == DONE:
            is_whole = session.is_saved
            ui.notify(answer.words.partition(":")[0], type="positive" if is_whole else "info")

    def _show_conflict(self, words: str, theirs: str) -> None:
        """Show what Save would undo in the file, and offer what is possible instead."""
        page, chart = self._page, self._page.session.chart
        if chart is None:
            return
        with page.dialog("Save") as dialog:
            ui.label(f"'{chart.name}' is not saved").classes("title")
            ui.label(words)
            ui.label("In the file (-) and here (+):").classes("soft")
            ui.html(changes_html(theirs, page.session.text), sanitize=False).classes(
                "wide changes source"
            )

            async def load() -> None:
                dialog.close()
                await page.load_into(page.session, chart.name)

            def copy() -> None:
                dialog.close()
                self._ask_copy()

            with ui.row():
                page.button("Save as", copy, icon="file_copy")
                page.button("Load it again", load, icon="refresh", look="quiet")
                ui.button("Cancel", on_click=dialog.close).props("no-caps flat")

    async def _run(self) -> None:
        """Save the chart if it has changed, and open Runtime control with it."""
        page, session = self._page, self._page.session
        if session.chart is None:
            ui.notify("Open a behavior first.", type="warning")
            return
        if not session.is_saved:
            await self.save()
        if session.is_saved:
            name, shared = session.chart.name, page.console.session

            async def show() -> None:
                if (await page.load_into(shared, name)).state == DONE:
                    page.go_to("/runtime")

            if shared.is_saved or shared.chart is None:
                await show()
            else:
                question = f"Commands have left unsaved changes of '{shared.chart.name}'."
                page.ask(question, f"Discard and load '{name}'", show)

    async def _arrange(self) -> None:
        """Have everything laid out again."""
        await self._page.change("lay out again", (), unplaced)

    def _found(self) -> tuple[Path, ...]:
        chart, word = self._page.chart, (self._find.value or "").strip()
        return matches(chart, word) if chart and word else ()

    def _count(self) -> None:
        found = len(self._found())
        words = f"{found} found" if found else "nothing found"
        self._matches.text = words if (self._find.value or "").strip() else ""

    def _next(self) -> None:
        """Select the next state that fits what is to be found."""
        found, selected = self._found(), self._page.selected
        if found:
            place = (found.index(selected) + 1) % len(found) if selected in found else 0
            self._page.select(found[place])
            self._matches.text = f"{place + 1} of {len(found)}"

    async def undo(self) -> None:
        """Take the last change back."""
        self._page.xml.is_typing = False
        await self._page.give("undo", self._page.session.undo)

    async def redo(self) -> None:
        """Make the change again that was taken back last."""
        self._page.xml.is_typing = False
        await self._page.give("redo", self._page.session.redo)

    async def _list(self) -> None:
        """Offer all charts and behaviors that there are by now.

        A list that is open stays as it is if it is right: an option is chosen by its place.
        """
        await run.io_bound(self._page.console.list_names)
        options = self._options()
        if options != self._open.options:
            self._open.set_options(options)

    def _options(self) -> dict[str, str]:
        """Return what was listed last, with a chart that is not saved yet.

        Charts that programs have made stand below the others, and files that are too large last.
        """
        console, chart = self._page.console, self._page.session.chart
        names = sorted({*console.names, *((chart.name,) if chart else ())})
        generated = [name for name in names if name in console.generated]
        return {
            **{name: name for name in names if name not in console.generated},
            **{name: f"generated: {name}" for name in generated},
            **{file: f"{file}: too large" for file in sorted(console.too_large)},
        }

    async def _load(self, name: str | None) -> None:
        chart, reason = self._page.session.chart, self._page.console.too_large.get(name or "")
        if reason:
            self._page.show_error(reason)
            self._open.value = chart.name if chart else None
        elif name and (chart is None or chart.name != name):
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

    async def group(self) -> None:
        """Put the selected states into a container."""
        page = self._page
        paths = outermost(page.selection)
        if page.chart is None or not paths:
            ui.notify("Select the states to group first.", type="warning")
            return
        path = paths[0][:-1]
        ids = [one[-1] for one in paths if one[:-1] == path]
        node_id = chart_edit.unused_id(container_at(page.chart, path), "Group")
        uses = {i: page.inspection.uses.get("/".join((*path, i))) for i in ids}
        reads = {i: tuple(use.inputs) for i, use in uses.items() if use}
        writes = {i: tuple(use.outputs) for i, use in uses.items() if use}
        names = ", ".join(f"'{one}'" for one in ids)
        change = partial(grouped, ids=ids, node_id=node_id, reads=reads, writes=writes)
        if await page.change(f"group {names} as '{node_id}'", path, change):
            page.select((*path, node_id))

    async def _connect(self) -> None:
        """Lead unconnected outcomes to the ends of their names, in the container that is open."""
        page, path = self._page, self._page.scope_path
        if page.chart is None:
            ui.notify("Open a behavior first.", type="warning")
            return
        prefix = "".join(f"{part}/" for part in path)
        nodes = container_at(page.chart, path).nodes
        events = {n.id: page.inspection.events(f"{prefix}{n.id}", n) for n in nodes}
        await page.change(
            f"connect what is in /{'/'.join(path)}", path, partial(connected, events=events)
        )

    def _ask_copy(self) -> None:
        """Ask how a copy of the behavior is called."""
        page = self._page
        if page.session.chart is None:
            ui.notify("Open a behavior first.", type="warning")
            return
        with page.dialog() as dialog:
            ui.label(f"Save '{page.session.chart.name}' as").classes("title")
            ui.label("The copy lies in the same folder.").classes("soft")
            name = ui.input("Name").props("outlined dense autofocus").classes("wide")
            name.on("keydown.enter", lambda: make())

            async def make() -> None:
                wanted = (name.value or "").strip()
                if not _is_usable(wanted):
                    return
                session = page.session
                answer = await page.give(f"copy as '{wanted}'", lambda: session.copy_as(wanted))
                if answer.state == DONE:
                    dialog.close()
                    await self.save()

            page.button("Save", make)

    def _new(self) -> None:
        """Create a behavior; ask first if something would be lost."""
        session = self._page.session
        if session.is_kept or session.chart is None:
            self._ask_new()
        else:
            question = f"'{session.chart.name}' has unsaved changes."
            self._page.ask(question, "Discard and create", self._ask_new)

    def _ask_new(self) -> None:
        """Ask how a new behavior is called, and where it goes."""
        workspace = self._page.console.workspace
        folders = {str(folder): words for folder, words in workspace.folder_words()}
        with self._page.dialog() as dialog:
            ui.label("New behavior").classes("title")
            name = ui.input("Name").props("outlined dense autofocus").classes("wide")
            name.on("keydown.enter", lambda: make())
            folder = ui.select(folders, value=str(workspace.own_folder), label="Chart folder")
            folder.props("outlined dense").classes("wide")

            async def make() -> None:
                if await self._make(name.value or "", str(folder.value)):
                    dialog.close()

            self._page.button("Create", make)

    async def _make(self, name: str, folder: str) -> bool:
        if not _is_usable(name):
            return False
        file = FilePath(folder) / f"{behavior_file(name)}.xml"
        if file.exists():
            ui.notify(f"{file} exists already.", type="warning")
            return False
        chart = chart_edit.new_chart(name, str(file))
        session = self._page.session
        return (await self._page.give(f"new '{name}'", lambda: session.open(chart))).state == DONE


def _is_usable(name: str) -> bool:
    """Return whether a behavior can have a name; else say which it can have."""
    if is_name(name) and is_behavior_name(name):
        return True
    ui.notify(
        "A name has letters, digits and single blanks, of which at least the first of a-z, "
        "A-Z, 0-9 and '_' is a letter, and 200 at most.",
        type="warning",
    )
    return False


def _small(
    page: EditingPage, text: str, deed: Callable[[], object], icon: str, hint: str
) -> ui.button:
    """Return a button without a text, which would make a second row of the tools."""
    made = page.button("", deed, icon=icon, look="quiet").props(f'aria-label="{text}"')
    return made.tooltip(hint)
