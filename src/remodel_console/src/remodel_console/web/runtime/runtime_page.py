"""Runtime control (Deliverable 5.1, 5.3): start, watch, attach, answer, steer and stop."""

from __future__ import annotations

from nicegui import background_tasks, ui

from remodel_console.core.inbox import Kind
from remodel_console.core.run.order import Hold, Order, Pause, Release, Repeat, Resume, Switch
from remodel_console.core.run.run_view import Phase, RunView, state_words
from remodel_console.core.world import World
from remodel_console.web.behavior_drawing import BehaviorDrawing
from remodel_console.web.cell.cell_view import LiveCell
from remodel_console.web.log_pane import LogPane
from remodel_console.web.page import Page
from remodel_console.web.runtime.plot_panel import PlotPanel
from remodel_console.web.runtime.run_panel import RunPanel
from remodel_console.web.runtime.state_panel import StatePanel

_READABLE_S = 0.25  # between two changes of what is there to click
_OPEN_S = 1.0  # for which a container stays open in a large drawing


class RuntimePage(Page):
    """The page of the behavior that runs."""

    KEYS = (
        ("Alt+P", "pause or continue"),
        ("Alt+R", "repeat the active state"),
        ("Alt+L", "lock or unlock the active state"),
        ("Alt+S", "step mode on or off"),
        ("Alt+B", "breakpoint at the chosen or active state on or off"),
    )

    def build(self) -> None:
        """Build the drawing, the panel beside it, and the log below."""
        self._drawn_version = 0  # how often charts had been saved when it was drawn
        self._newer: Switch | None = None
        self._newer_for: object = None
        self._ran = ""  # name of the behavior that runs, or ran last; empty if it is not known
        self._line_count = 0
        self._is_in_view = True
        ui.timer(_READABLE_S, self._follow)
        with ui.element("div").classes("runtime"):
            with ui.element("section").classes("stage"):
                with ui.row().classes("headline"):
                    self._title = ui.label().classes("title")
                    self._state = ui.label().classes("state")
                self._drawing = BehaviorDrawing(
                    self.console,
                    "State machine of the behavior",
                    "Choose a behavior on the right to draw its state machine here.",
                    lambda path: self._state_panel.pick(path),
                )
            part, splitter = self._arrangement.part, self._arrangement.splitter
            splitter("Width of the commands", "panel", is_column=True)
            self._panel = RunPanel(self, self.order)
            with self._panel.area:
                with part("State", "panel"):
                    self._state_panel = StatePanel(self)
                self._state_panel.drawing = self._drawing
                with part("Plots", "panel"):
                    self._plots = PlotPanel(self)
                with part("Cell", "panel"):
                    self._cell = LiveCell(self.console)
            splitter("Height of the log", "log", is_column=False)
            with ui.element("section").classes("log-area"):
                self._log = LogPane()

    def show(self, world: World) -> None:
        """Show what has changed of the run."""
        lines, self._line_count = self.console.live.lines_since(self._line_count)
        if lines:
            self._log.add(lines)
        view, chart = world.run, self.console.session.chart
        loaded = chart.name if chart else ""
        running = self.console.steering.running_name() if view.phase is Phase.RUNNING else ""
        if view.phase is Phase.RUNNING:
            self._ran = running
        name = running or loaded or self._ran
        self._title.text = name or "No behavior is loaded"
        waits = any(card.kind is not Kind.QUESTION for card in self._cards)
        self._state.text = state_words(view, waits=waits)
        self._state.classes(replace=f"state {view.phase.value}")
        self._draw(name)
        self._light(view)
        self._check_for_newer_version(view)
        self._panel.show(view, running, loaded, self._newer)
        self._plots.show()
        self._cell.follow(world.use_case)

    def _draw(self, name: str) -> None:
        """Draw a behavior, unless this version of it is drawn already."""
        version = self.console.sessions.save_count
        if name != self._drawing.name or version != self._drawn_version:
            self._drawing.name, self._drawn_version = name, version
            background_tasks.create(self._drawing.draw(name))

    def _check_for_newer_version(self, view: RunView) -> None:
        """Check whether the running behavior was saved again, only when that can have changed."""
        version = self.console.sessions.save_count
        cause = (view.behavior_id, view.is_supervised, version)
        if cause != self._newer_for:
            self._newer_for = cause
            self._newer = self.console.steering.newer_version()

    def set_in_view(self, is_in_view: bool) -> None:
        """Draw the cell and the plots only while the page is in view."""
        self._is_in_view = is_in_view
        self._cell.set_shown(is_in_view and self._arrangement.is_shown("Cell"))
        self._plots.set_shown(is_in_view and self._arrangement.is_shown("Plots"))

    def press_with_alt(self, key: str) -> None:
        """Command the running behavior."""
        view = self.console.live.world.run
        if key == "b" and self.is_operator:
            background_tasks.create(self._state_panel.toggle())
        if not view.is_supervised or not self.is_operator:
            return
        orders: dict[str, Order] = {
            "p": Resume() if view.is_paused else Pause(),
            "r": Repeat(),
            "l": Hold(view.active) if view.held is None else Release(view.held),
            "s": self._panel.other_mode(view),
        }
        order = orders.get(key)
        if order is not None:
            background_tasks.create(self.order(order))

    def _light(self, view: RunView) -> None:
        """Light what is active, or was; nothing if another behavior is drawn."""
        is_other = self._ran not in ("", self._drawing.name)
        active, visited = ("", frozenset()) if is_other else (view.active, view.visited)
        self._drawing.light(active, visited, is_asked=view.asked is not None)

    async def _follow(self) -> None:
        """Show what changes with each state; not faster than it can be read."""
        view = self.console.live.world.run
        self._panel.follow(view)
        await self._drawing.follow(_OPEN_S)
        self._state_panel.show(self.console.live.world)
        if self._is_in_view:
            self._state_panel.follow(view)
            self._plots.follow()

    async def order(self, order: Order) -> None:
        """Give the engine an order."""
        await self.give(str(order), lambda: self.console.steering.order(order))
