"""The drawing of a chart on a page: pan, zoom, pick; a behavior with what runs in it lit."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from nicegui import run, ui
from nicegui.element import Element
from nicegui.events import GenericEventArguments

from flexbe_synthesizer.core.chart.model import Chart
from remodel_console.console import Console
from remodel_console.core.drawing import (
    Json,
    chart_graph,
    collapsed,
    drawn_path,
    drawn_paths,
    engine_paths,
)
from remodel_console.core.editing import Path
from remodel_console.errors import CommandError

# [s] After which a page that has not painted, or cannot report it, is sent the change again.
_LOST_S = 2.0


class _Lit(NamedTuple):
    """What is lit: the active path, those that were, and whether it waits for an operator."""

    active: str = ""
    passed: frozenset[str] = frozenset()
    asked: bool = False


class Canvas(Element, component="static/canvas.js"):
    """Shows a graph of `core.drawing`.

    Where it can be edited, it emits `moved`, `connect` and `dropped`.
    """

    def __init__(
        self,
        label: str,
        pick: Callable[[tuple[str, ...]], None] | None = None,
        *,
        is_editable: bool = False,
    ) -> None:
        """Show nothing yet.

        Args:
            label: what the drawing is.
            pick: gets the paths of the states that a person clicks; none: the chart.
            is_editable: states can be moved, connected and dropped.
        """
        super().__init__()
        self._props["label"] = label
        self._props["editable"] = is_editable
        self._marked: dict[str, list[str]] = {}
        self._wanted = self._sent = _Lit()
        self._sent_s: float | None = None  # None once the page has painted what was sent
        self.classes("canvas")
        self.on("painted", self._on_painted)
        self._picks = 0  # of the page, as far as they have arrived
        if pick is not None:
            self._pick = pick
            self.on("pick", self._on_pick)

    def draw(self, graph: Json, *, keeps_view: bool = False) -> None:
        """Show another graph."""
        self.run_method("draw", graph, keeps_view)

    def light(self, active: str, passed: frozenset[str], asked: bool) -> None:
        """Light the path that is active, dimly those that were; `asked`: it waits for an operator.

        A run may change state fifty times a second. So only what has changed is sent, and not
        before the page has painted the last: a slow page shows fewer states, not late ones.
        """
        self._wanted = _Lit(active, passed, asked)
        if self._sent_s is None or time.monotonic() - self._sent_s > _LOST_S:
            self._send()

    def _send(self) -> None:
        wanted, sent = self._wanted, self._sent
        if wanted == sent:
            return
        is_new_run = not sent.passed <= wanted.passed
        new = wanted.passed if is_new_run else wanted.passed - sent.passed
        self._sent, self._sent_s = wanted, time.monotonic()
        self.run_method("light", wanted.active, sorted(new), is_new_run, wanted.asked)

    def _on_painted(self) -> None:
        self._sent_s = None
        self._send()

    def _on_pick(self, event: GenericEventArguments) -> None:
        self._picks = int(event.args["number"])
        self._pick(tuple(map(str, event.args["paths"])))

    def select(self, paths: Sequence[str]) -> None:
        """Mark what is being edited, unless a later pick of the page is under way."""
        self.run_method("select", list(paths), True, self._picks)

    def mark(self, name: str, paths: Iterable[str]) -> None:
        """Mark the states of these paths with a class of the drawing's style, and no others."""
        wanted = sorted(paths)
        if wanted != self._marked.get(name, []):
            self._marked[name] = wanted
            self.run_method("keepMark", name, wanted)

    def show_values(self, path: str, values: Sequence[tuple[str, str]]) -> None:
        """Show values beside a state; of an empty path, none."""
        self.run_method("showValues", path, [list(value) for value in values])


_NOTHING: Json = {"name": "", "nodes": [], "edges": [], "flows": []}


class BehaviorDrawing:
    """Draws the saved chart of a behavior; a large one is open only where something runs.

    Attributes:
        name: of the behavior that is drawn, or is going to be; None before the first.
    """

    def __init__(
        self,
        console: Console,
        label: str,
        nothing: str,
        on_pick: Callable[[str], None] | None = None,
    ) -> None:
        """Draw nothing yet.

        Args:
            console: knows the charts.
            label: what the drawing is.
            nothing: what stands where no behavior is drawn.
            on_pick: gets the path of a state that is clicked, `Place/Insert`; empty: none.
        """
        self._breakpoints: frozenset[str] = frozenset()
        self.name: str | None = None
        self._console = console
        self._nothing = nothing
        pick = (lambda paths: on_pick(paths[0] if paths else "")) if on_pick else None
        self._canvas = Canvas(label, pick)
        self._empty = ui.label(nothing).classes("empty")
        self._chart: Chart | None = None
        self._paths: frozenset[str] = frozenset()  # of all that could be drawn
        self._drawn: frozenset[str] = frozenset()  # of what is
        self._open: Path = ()
        self._opened_s = 0.0
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

    @property
    def states(self) -> tuple[str, ...]:
        """Return the paths of all states and containers of the behavior, `Place/Insert`."""
        return tuple(sorted(self._paths))

    def engine_paths(self, path: str) -> frozenset[str]:
        """Return the paths that the engine may have for a drawn one."""
        return engine_paths(self._chart, path) if self._chart else frozenset()

    def with_breakpoint(self, breakpoints: frozenset[str]) -> frozenset[str]:
        """Return the states of this behavior that have one of these breakpoints."""
        found = {drawn_path(path, self._paths) for path in breakpoints} - {""}
        return frozenset(path for path in found if self.engine_paths(path) & breakpoints)

    def count_breakpoints(self, breakpoints: frozenset[str]) -> int:
        """Return how many a person has set: of one state, the engine may have several paths."""
        states = self.with_breakpoint(breakpoints)
        own = frozenset(path for state in states for path in self.engine_paths(state))
        return len(states) + len(breakpoints - own)

    def mark_breakpoints(self, breakpoints: frozenset[str]) -> None:
        """Mark the states that have a breakpoint; a closed container if one inside has."""
        self._breakpoints = breakpoints
        states = self.with_breakpoint(breakpoints)
        self._canvas.mark("stopping", {drawn_path(path, self._drawn) for path in states} - {""})

    def show_values(self, path: str, values: Sequence[tuple[str, str]]) -> None:
        """Show values beside a state, in place of those that were shown before."""
        self._canvas.show_values(drawn_path(path, self._drawn), values)

    def select(self, path: str) -> None:
        """Mark the state that was chosen."""
        self._canvas.select([path] if path else [])

    async def follow(self, rest_s: float = 0.0) -> None:
        """Open the container that has become active, if the drawing is collapsed.

        Args:
            rest_s: for which the last one that was opened stays open; to draw one is expensive.
        """
        is_due = time.monotonic() - self._opened_s >= rest_s
        other = self._drawn != self._paths and self._active_container() not in ((), self._open)
        if other and is_due:
            await self._open_container()

    async def _open_container(self) -> None:
        """Draw the chart; of a large one, only the containers open in which something runs."""
        chart, path = self._chart, self._active_container()
        self._open, self._opened_s = path, time.monotonic()
        if chart is None:
            self._drawn = frozenset()
            self._canvas.draw(_NOTHING)
            return
        part = collapsed(chart, path)
        self._drawn = drawn_paths(part)
        self._canvas.draw(chart_graph(part))
        self.mark_breakpoints(self._breakpoints)
        self.light(self._active, self._visited, is_asked=self._is_asked)

    def _active_container(self) -> Path:
        """Return the container that the active state lies in."""
        return tuple(drawn_path(self._active, self._paths).split("/"))[:-1]
