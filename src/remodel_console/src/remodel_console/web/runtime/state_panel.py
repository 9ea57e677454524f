"""One state of the drawing: its breakpoint, and its values."""

from __future__ import annotations

from nicegui import ui

from remodel_console.core.run.run_view import Phase, RunView, path_words
from remodel_console.core.run.state_values import Row
from remodel_console.core.world import World
from remodel_console.web.behavior_drawing import BehaviorDrawing
from remodel_console.web.page import Page, table

_LONGEST = 200  # characters of a value that are shown
_ACTIVE = "the active state"


class StatePanel:
    """Shows the state that was chosen, or else the active one.

    Attributes:
        drawing: in which the state is marked; set before anything is shown.
    """

    drawing: BehaviorDrawing

    def __init__(self, page: Page) -> None:
        """Build the panel."""
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
        if paths & live.world.breakpoints:
            await self._page.give(
                f"remove the breakpoint at {state}",
                lambda: steering.change_breakpoints(removed=paths),
            )
        else:
            await self._page.give(
                f"set a breakpoint at {state}", lambda: steering.change_breakpoints(added=paths)
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
