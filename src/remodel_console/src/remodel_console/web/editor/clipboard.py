"""Copy, cut and paste of states, also from one chart into another."""

from __future__ import annotations

from nicegui import ui

from flexbe_synthesizer.core.chart.model import Chart
from remodel_console.core.editor.copying import Copied, copied, pasted
from remodel_console.web.editor.editing_page import EditingPage


class Clipboard:
    """The states that were copied last on a page."""

    def __init__(self, page: EditingPage) -> None:
        """Begin empty."""
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
