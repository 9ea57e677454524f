"""Runtime control (Deliverable 5.1, 5.3): start, watch, attach, answer, steer and stop."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from nicegui import background_tasks, run, ui
from nicegui.element import Element

from remodel_console.console import Console
from remodel_console.core.cell import Row
from remodel_console.core.plots import WINDOW_S, recent_plot
from remodel_console.core.run_view import Phase, RunView, path_words, state_words
from remodel_console.core.running import (
    Hold,
    LogLine,
    Order,
    Release,
    SimpleOrder,
    Switch,
)
from remodel_console.core.world import Kind, World
from remodel_console.errors import CommandError
from remodel_console.watched import Viewer
from remodel_console.web.canvas import BehaviorDrawing
from remodel_console.web.cell_view import LiveCell
from remodel_console.web.elements import Plot, table, time_words
from remodel_console.web.page import Page
from remodel_console.web.run_panel import RunPanel


class PlotPanel:
    """Shows the last minute of each plot, and the fields in which a person chooses one more."""

    def __init__(self, page: Page) -> None:
        """Build it; the plots are kept with the settings, for all pages."""
        self._page = page
        self._console: Console = page.console
        self._shown: tuple[str, ...] = ()
        self._rows: dict[str, tuple[ui.label, ui.label, Plot]] = {}
        self._viewer = Viewer(page.console.plots)
        with ui.element("section").classes("wide plot-panel").props('aria-label="Plots"'):
            ui.label("Plots").classes("heading")
            self._area = ui.element("div").classes("wide")
            self._topic = ui.select({}, label="Topic", with_input=True)
            self._topic.on("focus", self._list_topics).on_value_change(self._list_fields)
            # Another element of a list is typed, such as position[3].
            self._field = ui.select([], label="Field", with_input=True, new_value_mode="add-unique")
            for choice in (self._topic, self._field):
                choice.props("outlined dense").classes("wide").set_enabled(page.is_operator)
            page.button("Plot", self._add, look="quiet")
        ui.context.client.on_delete(lambda: self.set_shown(False))
        self.set_shown(True)

    def set_shown(self, is_shown: bool) -> None:
        """Receive no values while the page is in the background, and go on."""
        self._viewer.watch(is_shown)

    def show(self) -> None:
        """Show the plots that are chosen now, also by another page."""
        plots = self._console.settings.now.plots
        if plots == self._shown:
            return
        self._shown = plots
        self._area.clear()
        self._rows.clear()
        with self._area:
            for plot in plots:
                with ui.row().classes("plot-head"):
                    ui.label(plot).classes("soft where")
                    figure = ui.label().classes("figure")
                    self._remove_button(plot)
                problem = ui.label().classes("soft").props('role="status"')
                self._rows[plot] = (figure, problem, Plot(plot))

    def _remove_button(self, plot: str) -> None:
        button = self._page.button("", lambda: self._remove(plot), icon="close", look="quiet")
        button.props(f'aria-label="Remove the plot {plot}" dense')

    def follow(self) -> None:
        """Show the newest values."""
        for plot, (figure, problem, drawing) in self._rows.items():
            points = self._console.plots.points(plot)
            figure.text = f"{points[-1][1]:.4g}" if points else "-"
            problem.text = self._console.plots.problem(plot)
            problem.set_visibility(bool(problem.text))
            drawing.show(recent_plot(points, WINDOW_S))

    async def _list_topics(self) -> None:
        source = self._console.plots.source
        try:
            topics = await run.io_bound(source.topics) if source else {}
        except CommandError:
            return  # the line of status says that there is no master
        names = {topic: f"{topic} ({kind})" for topic, kind in topics.items()}
        if names != self._topic.options:
            value = self._topic.value
            self._topic.set_options(names, value=value if value in names else None)

    async def _list_fields(self) -> None:
        topic, source = self._topic.value, self._console.plots.source
        if not topic or source is None:
            self._field.set_options([], value=None)
            return
        try:
            fields = await run.io_bound(source.fields, str(topic))
        except CommandError as error:
            self._page.show_error(str(error))
            return
        self._field.set_options(list(fields), value=fields[0] if fields else None)

    async def _add(self) -> None:
        plot = f"{self._topic.value or ''}.{self._field.value or ''}"
        await self._page.give(f"plot {plot}", lambda: self._console.add_plot(plot))

    async def _remove(self, plot: str) -> None:
        settings = self._console.settings
        await self._page.give(
            f"remove the plot {plot}",
            lambda: settings.change(
                lambda now: replace(now, plots=tuple(p for p in now.plots if p != plot))
            ),
        )


_LONGEST = 200  # characters of a value that are shown
_ACTIVE = "the active state"


class StatePanel:
    """Shows the state that was chosen, or else the active one.

    Attributes:
        drawing: in which the state is marked; set before anything is shown.
    """

    drawing: BehaviorDrawing

    def __init__(self, page: Page) -> None:
        self._page = page
        self._picked = ""  # path in the drawing
        self._states: tuple[str, ...] = ()
        self._values: tuple[str, tuple[Row, ...]] = ("", ())
        self._shown: object = None
        with ui.element("section").classes("wide state-panel").props('aria-label="State"'):
            ui.label("State").classes("heading")
            self._choice = ui.select({"": _ACTIVE}, value="", with_input=True, label="State")
            self._choice.props("outlined dense").classes("wide")
            self._choice.on_value_change(lambda event: self.pick(str(event.value or "")))
            with ui.row().classes("controls"):
                self._toggle = page.button("Breakpoint", self.toggle, look="quiet")
                self._clear = page.button("Remove all", self._remove_all, look="quiet")
            self._hint = ui.label().classes("state-hint")
            self._table = ui.element("div").classes("wide")

    def pick(self, path: str) -> None:
        """Choose a state of the drawing; of an empty path, the active one."""
        if path not in ("", *self.drawing.states) or path == self._picked:
            return
        self._picked = path
        self._list_states()
        self._choice.value = path
        self.drawing.select(path)
        self.show(self._page.console.live.world)

    def show(self, world: World) -> None:
        """Show the breakpoints, and which states there are."""
        self._list_states()
        self.drawing.mark_breakpoints(world.breakpoints)
        paths = self._paths(world.run)
        has_point = bool(paths & world.breakpoints)
        is_idle = bool(paths or world.breakpoints) and not world.run.is_supervised
        count = self.drawing.count_breakpoints(world.breakpoints)
        shown = (has_point, count, is_idle, bool(paths))
        if shown == self._shown:
            return
        self._shown = shown
        self._toggle.text = "Remove breakpoint" if has_point else "Breakpoint"
        self._toggle.set_enabled(self._page.is_operator and bool(paths))
        self._clear.text = f"Remove all {count}"
        self._clear.set_visibility(count > 1)
        self._hint.text = (
            "An unattended run ignores breakpoints: start with another autonomy, or attach."
            if is_idle
            else ""
        )
        self._hint.set_visibility(is_idle)

    def _list_states(self) -> None:
        """Offer the states of the behavior that is drawn."""
        states = self.drawing.states
        if states != self._states:
            self._states = states
            self._picked = self._picked if self._picked in states else ""
            options = {"": _ACTIVE} | {path: path_words(path) for path in states}
            self._choice.set_options(options, value=self._picked)

    async def toggle(self) -> None:
        """Set a breakpoint at the state, or remove it."""
        live, steering = self._page.console.live, self._page.console.steering
        paths = self._paths(live.world.run)
        if not paths:
            return
        view = live.world.run
        state = path_words(self._picked) or view.chart_state(view.active).words
        has_point = bool(paths & live.world.breakpoints)
        change = {"removed": paths} if has_point else {"added": paths}
        await self._page.give(
            f"{'remove the' if has_point else 'set a'} breakpoint at {state}",
            lambda: steering.change_breakpoints(**change),
        )

    async def _remove_all(self) -> None:
        live, steering = self._page.console.live, self._page.console.steering
        await self._page.give(
            "remove all breakpoints",
            lambda: steering.change_breakpoints(removed=live.world.breakpoints),
        )

    def _paths(self, view: RunView) -> frozenset[str]:
        """Return the paths of the state in the engine."""
        if self._picked:
            return self.drawing.engine_paths(self._picked)
        return frozenset(filter(None, (view.active,)))

    def follow(self, view: RunView) -> None:
        """Show the values of the state: as it found them, and as it has left them behind."""
        if view.phase is not Phase.RUNNING:
            self._show_values("", ())
            return
        paths = sorted(self._paths(view), key=len)
        self._show_values(self._picked or view.active, self._page.console.values.rows(*paths))

    def _show_values(self, path: str, rows: tuple[Row, ...]) -> None:
        if (path, rows) == self._values:
            return
        self._values = (path, rows)
        self.drawing.show_values(path, [(row.key, _cut(row.left or row.found)) for row in rows])
        self._table.clear()
        if rows:
            cells = [(row.key, _cut(row.found), _cut(row.left)) for row in rows]
            with self._table:
                table(("Key", "On entry", "On exit"), cells)


def _cut(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"


class LogPane(Element, component="static/log_pane.js"):
    """Shows lines, the newest at the bottom."""

    def add(self, lines: Iterable[LogLine]) -> None:
        """Add lines."""
        rows = [[time_words(line.time_s), line.severity, line.text] for line in lines]
        self.run_method("add", rows)


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
            "p": SimpleOrder.RESUME if view.is_paused else SimpleOrder.PAUSE,
            "r": SimpleOrder.REPEAT,
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
