"""What the panels of the editor use of its page: the chart, what is selected, and the changes."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence
from functools import partial

from nicegui import run, ui

from flexbe_synthesizer.core.chart.model import Chart
from remodel_console.core.access import Role
from remodel_console.core.answer import DONE
from remodel_console.core.editor import chart_edit
from remodel_console.core.editor.copying import Copied, outermost
from remodel_console.core.editor.editing import Path, change_at, container_at
from remodel_console.core.editor.fixes import Fix, Found, fixed
from remodel_console.core.editor.inspection import Inspection
from remodel_console.errors import CommandError
from remodel_console.session import Session
from remodel_console.sessions import Sessions
from remodel_console.web.editor.refusal import show_refusal
from remodel_console.web.editor.xml_pane import XmlPane
from remodel_console.web.page import Page

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
