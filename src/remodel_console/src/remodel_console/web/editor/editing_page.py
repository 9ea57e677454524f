"""What the panels of the editor use of its page: the chart, what is selected, and the changes."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import run, ui

from flexbe_synthesizer.core.chart.model import Chart
from remodel_console.core.answer import DONE
from remodel_console.core.editor import chart_edit
from remodel_console.core.editor.editing import Path, change_at, container_at
from remodel_console.core.editor.inspection import Inspection
from remodel_console.errors import CommandError
from remodel_console.web.editor.problem_list import show_refusal
from remodel_console.web.editor.xml_pane import XmlPane
from remodel_console.web.page import Page


class EditingPage(Page):
    """A page on which a chart is edited.

    Attributes:
        chart: as it is shown; None before one is open.
        inspection: what the checks found in the chart `inspected`.
        selected: path of the selected node; empty for the chart.
        xml: the pane of the chart's text.
    """

    xml: XmlPane

    def build(self) -> None:
        """Begin without a chart."""
        self.chart: Chart | None = None
        self.inspection = Inspection()
        self.inspected: Chart | None = None
        self.selected: Path = ()

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
        session = self.console.session

        def deed() -> None:
            session.change(lambda chart: change_at(chart, path, change))

        self.xml.is_typing = False
        return (await self.give(f"edit: {what}", deed)).state == DONE

    def select(self, path: Path) -> None:
        """Select a node, or nothing."""
        raise NotImplementedError

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
        self.xml.is_typing = False
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

    def _show_refusal(self, goal: str, words: str) -> None:
        text = self.console.workspace.text_of(goal)
        with self.dialog() as dialog:
            show_refusal(goal, text, words, dialog.close)
