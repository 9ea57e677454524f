"""The drawing of a behavior on a page, with what runs in it lit."""

from __future__ import annotations

from nicegui import run, ui

from flexbe_synthesizer.core.chart.model import Chart
from remodel_console.console import Console
from remodel_console.core.editor.collapse import collapsed
from remodel_console.core.editor.drawing import drawn_path, drawn_paths
from remodel_console.core.editor.editing import Path
from remodel_console.core.editor.graph import Json, chart_graph
from remodel_console.errors import CommandError
from remodel_console.web.canvas import Canvas

_NOTHING: Json = {"name": "", "nodes": [], "edges": [], "flows": []}


class BehaviorDrawing:
    """Draws the saved chart of a behavior; a large one is open only where something runs.

    Attributes:
        name: of the behavior that is drawn, or is going to be; None before the first.
    """

    def __init__(self, console: Console, label: str, nothing: str) -> None:
        """Draw nothing yet.

        Args:
            console: knows the charts.
            label: what the drawing is.
            nothing: what stands where no behavior is drawn.
        """
        self.name: str | None = None
        self._console = console
        self._nothing = nothing
        self._canvas = Canvas(label)
        self._empty = ui.label(nothing).classes("empty")
        self._chart: Chart | None = None
        self._paths: frozenset[str] = frozenset()  # of all that could be drawn
        self._drawn: frozenset[str] = frozenset()  # of what is
        self._open: Path = ()
        self._active = ""
        self._visited: frozenset[str] = frozenset()
        self._is_asked = False
        self._passed: frozenset[str] = frozenset()
        self._passed_of: object = None

    async def draw(self, name: str) -> None:
        """Draw the behavior of a name; of an empty one, nothing."""
        self.name = name
        try:
            chart = await run.io_bound(self._console.chart_to_watch, name) if name else None
            words = self._nothing
        except CommandError as error:
            chart, words = None, str(error)
        if name != self.name:
            return
        self._chart = chart
        self._paths = drawn_paths(chart) if chart else frozenset()
        self._empty.text = words
        self._empty.set_visibility(chart is None)
        await self._open_container()

    def light(self, active: str, visited: frozenset[str], *, is_asked: bool) -> None:
        """Light what is active, dimly what was.

        Args:
            active: path of the state, as the engine publishes it; empty if none is.
            visited: paths that were active before.
            is_asked: the active state waits for an operator.
        """
        self._active, self._visited, self._is_asked = active, visited, is_asked
        if (visited, self._drawn) != self._passed_of:  # kept, as most stay
            self._passed_of = (visited, self._drawn)
            self._passed = frozenset(drawn_path(path, self._drawn) for path in visited) - {""}
        self._canvas.light(drawn_path(active, self._drawn), self._passed, is_asked)

    async def follow(self) -> None:
        """Open the container that has become active, if the drawing is collapsed."""
        if self._drawn != self._paths and self._active_container() not in ((), self._open):
            await self._open_container()

    async def _open_container(self) -> None:
        """Draw the chart; of a large one, only the containers open in which something runs."""
        chart, path = self._chart, self._active_container()
        self._open = path
        if chart is None:
            self._drawn = frozenset()
            self._canvas.draw(_NOTHING)
            return
        part = collapsed(chart, path)
        self._drawn = drawn_paths(part)
        self._canvas.draw(chart_graph(part))
        self.light(self._active, self._visited, is_asked=self._is_asked)

    def _active_container(self) -> Path:
        """Return the container that the active state lies in."""
        return tuple(drawn_path(self._active, self._paths).split("/"))[:-1]
