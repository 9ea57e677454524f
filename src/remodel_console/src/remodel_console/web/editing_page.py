"""What the panels of the editor use of its page, and its small panels."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Iterable, Sequence
from difflib import unified_diff
from functools import partial
from html import escape
from pathlib import PurePath

from nicegui import run, ui

from flexbe_synthesizer.core.chart.model import Chart
from remodel_console.core import chart_edit
from remodel_console.core.commands import DONE, Role
from remodel_console.core.copying import Copied, outermost
from remodel_console.core.editing import Path, change_at, container_at
from remodel_console.core.inspection import (
    Fix,
    Found,
    Inspection,
    certificate_html,
    fixed,
    unambiguous,
)
from remodel_console.errors import CommandError
from remodel_console.session import Session, Sessions
from remodel_console.web.page import Page
from remodel_run.whole_task import counted


def show_refusal(goal: str, text: str, words: str, close: Callable[[], None]) -> None:
    """Add the errors of a chart that cannot be used, beside its lines.

    Args:
        goal: path of the chart's file.
        text: its content.
        words: the answer of the checks, a line for each error.
        close: called by the button at the end.
    """
    ui.label(f"{goal} cannot be used").classes("title")
    with ui.element("div").classes("refusal"):
        wrong = frozenset(_error_lines(words))
        with ui.element("pre").classes("source"):
            for number, line in enumerate(text.splitlines(), start=1):
                row = ui.label(f"{number:4}  {line}")
                if number in wrong:
                    row.classes("xml-error")
        with ui.element("div").classes("errors"):
            for line in words.splitlines():
                ui.label(_without_file(line))
    ui.button("Close", on_click=close).props("no-caps flat autofocus")


def _without_file(line: str) -> str:
    """Return a line of an answer without the file, which stands above it."""
    parts = line.split(":", 3)
    return f"Line {parts[1]}:{parts[3]}" if len(parts) > 3 and parts[1].isdigit() else line


def _error_lines(words: str) -> Iterable[int]:
    """Yield the lines that an answer of the checks names, `file:line:column: [code] message`."""
    for parts in (line.split(":") for line in words.splitlines()):
        if len(parts) > 3 and parts[1].isdigit():
            yield int(parts[1])


# What is typed into the XML means nothing else; but saving does, and is not the browser's.
_KEEP_KEYS = "(event) => { if (!(event.ctrlKey && event.key === 's')) event.stopPropagation(); }"
_TYPED_S = 0.4  # without a key pressed, after which typed XML is taken in


class XmlPane:
    """Shows the chart's XML.

    Attributes:
        text: what stands there, as far as it has been taken in.
        is_typing: the last change came from here, so the text stays as it was typed.
    """

    def __init__(self, take: Callable[[str], Awaitable[None]], *, is_dark: bool) -> None:
        """Build an empty pane; `take` gets the text after it was typed."""
        self.text = ""
        self.is_typing = False
        self._take = take
        self._editor = ui.codemirror(
            language="XML",
            line_wrapping=True,
            on_change=self._on_typed,
            theme="githubDark" if is_dark else "githubLight",
        ).classes("xml")
        self._editor.on("keydown", js_handler=_KEEP_KEYS)
        self._typed = ui.timer(_TYPED_S, self._take_typed, active=False, once=False)

    def show(self, text: str) -> None:
        """Show a chart's text, unless it is just being typed."""
        if not self.is_typing:
            self.text = text.replace("\r\n", "\n").replace("\r", "\n")  # as the page has it
            self._editor.set_value(self.text)

    def mark(self, inspection: Inspection, own: str) -> None:
        """Mark the lines of the problems in the file `own`."""
        self._editor.decorations = [
            {"kind": "line", "line": p.position.line, "class": f"xml-{p.code.severity.value}"}
            for p in inspection.problems
            if p.position.file == own and p.position.line > 0
        ]

    def reveal(self, line: int) -> None:
        """Show a line."""
        self._editor.reveal_line(line)

    def _on_typed(self) -> None:
        if (self._editor.value or "") != self.text:
            self._typed.deactivate()
            self._typed.activate()

    async def _take_typed(self) -> None:
        self._typed.deactivate()
        text = self._editor.value or ""
        if text != self.text:
            await self._take(text)


SESSION = "session"  # in the page's address: the key of its session
_RELOAD_S = 2.0  # within which a page that is reloaded says so
_POLL_S = 0.02


async def released(sessions: Sessions, key: str) -> None:
    """Wait while the page of a session is being reloaded, so that the session is free again."""
    end_s = time.monotonic() + _RELOAD_S
    while sessions.is_shown(key) and time.monotonic() < end_s:
        await asyncio.sleep(_POLL_S)


class EditingPage(Page):
    """A page on which a chart is edited.

    Attributes:
        chart: as it is shown; None before one is open.
        inspection: what the checks found in the chart `inspected`.
        selected: path of the node whose properties are shown; empty for the chart.
        selection: paths of all selected nodes.
        wants_value: the first value that the selected state needs is to be entered next.
        found: the problems of the chart, with the state that each is at.
        xml: the pane of the chart's text.
    """

    NEEDS = Role.ENGINEER
    xml: XmlPane

    def build(self) -> None:
        """Begin without a chart."""
        self.chart: Chart | None = None
        self.inspection = Inspection()
        self.inspected: Chart | None = None
        self.selected: Path = ()
        self.selection: tuple[Path, ...] = ()
        self.wants_value = False
        self.found: tuple[Found, ...] = ()
        client = ui.context.client
        given = self.query.get(SESSION, "")
        self._is_left = False
        ui.on("editor-left", self._leave)
        self._key, self._session = self.console.sessions.take(
            given,
            lambda: client.has_socket_connection and not self._is_left,
            self.actor.name,
        )
        if self._key != given:  # a reload of the page continues the session
            ui.run_javascript(f"history.replaceState(null, '', '?{SESSION}={self._key}')")

    def _leave(self) -> None:
        """Free the session: the browser closes the page, or shows another one in its place."""
        self._is_left = True
        self.console.live.refresh()  # others may have the chart open

    @property
    def others(self) -> tuple[str, ...]:
        """Return who else has the chart open."""
        return self.console.sessions.others_at(self._key)

    @property
    def session(self) -> Session:
        """Return this page's own session."""
        return self._session

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
        """Change the container at a path; return whether that was possible."""
        session = self.session

        def deed() -> None:
            session.change(lambda chart: change_at(chart, path, change))

        self.xml.is_typing = False
        return (await self.give(f"edit: {what}", deed)).state == DONE

    def paste_path(self, what: Copied) -> Path:
        """Return the container that copies go into.

        That is the one they were copied from while they are selected, else the selected one.
        """
        if self.selection and {p[-1] for p in self.selection} >= {n.id for n in what.nodes}:
            return self.selection[0][:-1]
        return self.scope_path

    def select(self, *paths: Path) -> None:
        """Select nodes, or the chart; the properties are those of the first."""
        raise NotImplementedError

    async def fix(self, fix: Fix) -> None:
        """Make the change that corrects a problem."""
        await self.change(fix.words, fix.path, fix.change)

    async def fix_all(self, fixes: Sequence[Fix]) -> None:
        """Make the changes that correct several problems, as one change."""
        await self.change(f"fix {len(fixes)} problems", (), lambda chart: fixed(chart, fixes))

    async def delete(self) -> None:
        """Delete what is selected."""
        paths = outermost(self.selection)
        if not paths:
            return

        def change(chart: Chart) -> Chart:
            for path in paths:
                without = partial(chart_edit.without_node, node_id=path[-1])
                chart = change_at(chart, path[:-1], without)
            return chart

        names = ", ".join(f"'{'/'.join(path)}'" for path in paths)
        if await self.change(f"delete {names}", (), change):
            self.select(())

    async def synthesize(self, path: Path, initial: str, goal: str) -> None:
        """Fill a container with the chart of a file, or show what is wrong with that."""
        session = self.session
        self.xml.is_typing = False
        answer = await run.io_bound(
            self.console.desk.give,
            self.actor,
            f"synthesize {'/'.join(path)} i: {initial or 'start'} g: {goal}",
            lambda: session.synthesize(path[:-1], path[-1], initial, goal),
        )
        if answer.state == DONE:
            with self._dialogs:  # the button that was pressed is drawn again by now
                ui.notify(f"'{path[-1]}' is filled from {goal}", type="positive")
        else:
            self._show_refusal(goal, answer.words)

    def _show_refusal(self, goal: str, words: str) -> None:
        text = self.console.workspace.text_of(goal)
        with self.dialog() as dialog:
            show_refusal(goal, text, words, dialog.close)


_NO_CERTIFICATE = "A chart with errors has no certificate."


class CertificatePanel:
    """Shows the certificate, as it is written when the chart is saved."""

    def __init__(self) -> None:
        self._words = ui.label(_NO_CERTIFICATE).classes("soft")
        self._tables = ui.html("", sanitize=False).classes("wide certificate")
        self._shown: Inspection | None = None

    async def show(self, inspection: Inspection) -> None:
        """Show what holds for the chart as it was checked last."""
        if inspection is self._shown:
            return
        self._shown = inspection
        certificate = await run.io_bound(inspection.certify)
        if inspection is self._shown:
            self._words.set_visibility(certificate is None)
            self._tables.set_content("" if certificate is None else certificate_html(certificate))


_NO_CHANGE = "The file is as the chart is."
_NEW = "The chart has no file yet. Save writes all of it."
_MOST_LINES = 2000  # of text that are compared; more would hold the page up


class ChangesPanel:
    """Shows which lines Save changes."""

    def __init__(self, page: EditingPage) -> None:
        self._page = page
        self._words = ui.label(_NO_CHANGE).classes("soft")
        self._lines = ui.html("", sanitize=False).classes("wide changes")

    def show(self) -> None:
        """Show what Save would change."""
        session = self._page.session
        old, new = session.saved_text, session.text
        is_same = session.is_saved or old == new
        self._words.text = _NO_CHANGE if is_same else "" if old else _NEW
        self._words.set_visibility(is_same or not old)
        self._lines.set_content("" if is_same or not old else changes_html(old, new))


def changes_html(old: str, new: str) -> str:
    """Return the lines that differ between two texts, with three around each, as HTML."""
    lines = [text.splitlines() for text in (old, new)]
    if max(map(len, lines)) > _MOST_LINES:
        return f"<p>The text has more than {_MOST_LINES} lines; they are not compared here.</p>"
    parts = []
    for line in list(unified_diff(*lines, lineterm=""))[2:]:
        style = {"+": "added", "-": "removed", "@": "place"}.get(line[0], "")
        parts.append(f'<div class="{style}">{escape(line)}</div>')
    return "".join(parts)


Reveal = Callable[[int], None]


class ProblemList:
    """Shows what the checks have found, each a button that leads to its line."""

    def __init__(self, page: EditingPage, reveal: Reveal) -> None:
        """Build an empty list; `reveal` shows a line of the XML."""
        self._page = page
        self._reveal = reveal
        self._area = ui.element("div").classes("problems").props('role="status"')

    def show(self, inspection: Inspection, own: str, found: Sequence[Found]) -> None:
        """Show the problems of the chart in the file `own`."""
        self._area.clear()
        with self._area:
            count = inspection.error_count
            words = counted(count, "error") if count else "No errors."
            if inspection.unchecked:
                words = f"Not checked: {inspection.unchecked}"
            is_fine = not count and not inspection.unchecked
            ui.label(words).classes("soft" if is_fine else "bad-count")
            certain = unambiguous(found)
            if len(certain) > 1:
                words = f"Fix the {len(certain)} errors that have one correction"
                self._page.button(words, partial(self._page.fix_all, certain), look="quiet")
            for one in found:
                self._line(one, own)

    def _line(self, one: Found, own: str) -> None:
        """Add a problem: a button that shows its line, and one for each change that corrects it."""
        problem = one.problem
        file, line, _ = problem.position
        where = f"line {line}" if file == own else f"{PurePath(file).name}, line {line}"
        button = ui.element("button").classes(f"problem {problem.code.severity.value}")
        with button.on("click", partial(self._show, one, line)):
            ui.label(where).classes("place")
            ui.label(problem.message)
        show_fixes(self._page, one)

    def _show(self, one: Found, line: int) -> None:
        if one.path:
            self._page.select(one.path)
        self._reveal(line)


def show_fixes(page: EditingPage, found: Found) -> None:
    """Add a button for each change that corrects a problem."""
    if found.fixes:
        with ui.row().classes("fixes"):
            for fix in found.fixes:
                page.button(fix.words, partial(page.fix, fix), look="quiet")
