"""The drawing in the editor, and its clipboard."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import replace
from functools import partial
from typing import TypeAlias

from nicegui import ui

from flexbe_synthesizer.core.chart.model import Chart, Point
from remodel_console.core.editor import chart_edit
from remodel_console.core.editor.copying import Copied, copied, pasted
from remodel_console.core.editor.editing import Path, read_path
from remodel_console.web.canvas import Places
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


Add: TypeAlias = Callable[[str, Path, Point | None], Awaitable[None]]


class DrawingEditor:
    """Takes what the drawing reports."""

    def __init__(self, page: EditingPage, add: Add) -> None:
        """Change the chart of a page; `add` adds an entry of the library to a container."""
        self._page = page
        self._add = add

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
