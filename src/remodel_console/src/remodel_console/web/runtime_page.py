"""Runtime control (Deliverable 5.1, 5.3): start, watch, attach, answer, steer and stop."""

from __future__ import annotations

from functools import partial

from nicegui import background_tasks, run, ui

from flexbe_synthesizer.core.model import Chart
from remodel_console.core.answer import DONE
from remodel_console.core.commands import Command, Verb
from remodel_console.core.order import (
    LEVELS,
    UNATTENDED,
    Hold,
    Order,
    Pause,
    Preempt,
    Release,
    Repeat,
    Resume,
    SetAutonomy,
    Switch,
    TakeOutcome,
)
from remodel_console.core.run_view import Asked, Phase, RunView
from remodel_console.core.world import World
from remodel_console.errors import CommandError
from remodel_console.web.behavior_drawing import BehaviorDrawing
from remodel_console.web.log_pane import LogPane
from remodel_console.web.page import Page, table
from remodel_console.web.start_form import StartForm

_ATTACHED_LEVELS = {level: word for level, word in LEVELS.items() if level != UNATTENDED}
_ROOM = (900.0, 520.0)  # for the drawing on a common screen [pixels]
_READABLE_S = 0.25  # between two changes of what is there to click
_FIRST_LEVEL = 1  # low, as in the FlexBE App


class RuntimePage(Page):
    """The page of the behavior that runs."""

    KEYS = (
        ("C", "confirm what the engine asks"),
        ("P", "pause, or go on"),
        ("R", "repeat the active state"),
        ("L", "lock the active state, or let it go"),
    )

    def build(self) -> None:
        """Build the drawing, the panel beside it, and the log below."""
        self._shown: object = None
        self._drawn_chart: Chart | None = None
        self._newer: Switch | None = None
        self._newer_for: object = None
        self._line_count = 0
        self._outcomes: ui.element | None = None
        self._outcomes_of = ""
        ui.timer(_READABLE_S, self._show_what_changes_fast)
        with ui.element("div").classes("runtime"):
            with ui.element("section").classes("stage"):
                with ui.row().classes("headline"):
                    self._title = ui.label().classes("title")
                    self._state = ui.label().classes("state")
                self._drawing = BehaviorDrawing(
                    self.console,
                    "State machine of the behavior",
                    "Choose a behavior on the right; its state machine is drawn here.",
                    _ROOM,
                )
            self._panel = ui.element("aside").classes("panel")
            with ui.element("section").classes("log-area"):
                self._log = LogPane()

    def show(self, world: World) -> None:
        """Show what has changed of the run."""
        lines, self._line_count = self.console.live.lines_since(self._line_count)
        if lines:
            self._log.add(lines)
        loaded = self._loaded()
        session = self.console.session
        is_saved_anew = session.is_saved and session.chart is not self._drawn_chart
        if loaded != self._drawing.name or is_saved_anew:
            self._drawing.name, self._drawn_chart = loaded, session.chart
            background_tasks.create(self._drawing.draw(loaded))
        running = self.console.running_name() if world.run.phase is Phase.RUNNING else ""
        self._light(world.run, running)
        self._look_for_newer_version(world.run)
        shown = (world.has_master, _without_path(world.run), running, loaded, self._newer)
        if shown != self._shown:
            self._shown = shown
            self._show_panel(world, running, loaded)

    def _look_for_newer_version(self, view: RunView) -> None:
        """Look whether what runs has been saved anew; only when that can have changed."""
        session = self.console.session
        cause = (view.behavior_id, view.is_supervised, session.chart, session.is_saved)
        if cause != self._newer_for:
            self._newer_for = cause
            self._newer = self.console.newer_version()

    def press(self, key: str, *, ctrl: bool) -> None:
        """Do what a key means on this page."""
        view = self.console.live.world.run
        if ctrl or not view.is_supervised:
            return
        orders: dict[str, Order | None] = {
            "c": self._confirmation(view),
            "p": Resume() if view.is_paused else Pause(),
            "r": Repeat(),
            "l": Hold(view.active) if view.held is None else Release(view.held),
        }
        order = orders.get(key.lower())
        if order is not None:
            background_tasks.create(self._order(order))

    def _light(self, view: RunView, running: str) -> None:
        """Light what is active; nothing if another behavior is drawn than the one that runs."""
        is_other = view.phase is Phase.RUNNING and running not in ("", self._drawing.name)
        active, visited = ("", frozenset()) if is_other else (view.active, view.visited)
        self._drawing.light(active, visited, is_asked=view.asked is not None)

    # The panel

    def _show_panel(self, world: World, running: str, loaded: str) -> None:
        """Build the panel anew for what the engine does."""
        view = world.run
        self._title.text = running or loaded or "No behavior is loaded"
        self._state.text = _state_words(view)
        self._state.classes(replace=f"state {view.phase.value}")
        self._panel.clear()
        self._outcomes = None
        with self._panel:
            if view.phase is not Phase.RUNNING:
                self._show_idle(view)
            else:
                self._show_running(view, running, loaded)
            self._where = ui.label(_breadcrumb(view.active)).classes("where")
            self._count = ui.label(_count_words(view)).classes("soft")
            if view.phase is not Phase.RUNNING:
                self._where.set_visibility(False)
                self._count.set_visibility(view.entries > 0)

    def _show_idle(self, view: RunView) -> None:
        if view.ending:
            style = "ending bad" if view.is_ending_bad else "ending"
            ui.label(f"The last run {view.ending}.").classes(style)
        StartForm(self)

    def _show_running(self, view: RunView, running: str, loaded: str) -> None:
        if view.asked is not None:
            self._show_request(view)
        if view.is_supervised:
            if view.ending:
                ui.label(f"The behavior {view.ending}.").classes("ending bad")
            self._show_newer_version()
            self._show_controls(view)
        else:
            self._show_attach(running, loaded)
        self.button("Stop", self._ask_stop, icon="stop", look="stop")
        if view.is_supervised:
            self._show_userdata()

    def _show_request(self, view: RunView) -> None:
        """Show what the engine asks, with the button that answers it."""
        confirmation = self._confirmation(view)
        with ui.element("div").classes("request").props('role="alert"'):
            ui.label("The engine asks you").classes("soft")
            label = view.asked.path.rpartition("/")[2] if view.asked else ""
            if confirmation is None:
                ui.label(f"Leave '{label}'? Its outcomes are not known here; attach first.")
                return
            ui.label(f"Leave '{label}' with '{confirmation.outcome}'?").classes("question")
            self.button(
                f"Confirm '{confirmation.outcome}'",
                partial(self._order, confirmation),
                icon="check",
            ).classes("confirm").props("autofocus")

    def _show_newer_version(self) -> None:
        """Offer the version that has been saved while this one runs."""
        if self._newer is None:
            return
        with ui.element("div").classes("card attach"):
            ui.label(f"Another version of '{self._newer.name}' is saved.").classes("question")
            ui.label("The active state goes on in it, locked until you unlock it.").classes("soft")
            self._control("Switch to it", self._newer, "swap_horiz")

    def _show_attach(self, running: str, loaded: str) -> None:
        """Show how to attach, or what to load first."""
        name = f"'{running}'" if running else "A behavior of another version than installed here"
        with ui.element("div").classes("card attach"):
            ui.label(f"{name} runs unattended.").classes("question")
            ui.label("Attach to confirm its steps, and to lock, pause or lead it.").classes("soft")
            if running and running != loaded:
                ui.label(f"Load '{running}' first: {_loaded_words(loaded)}.")
                self.button(f"Load '{running}'", partial(self.load, running), icon="folder_open")
                return
            level = ui.select(_ATTACHED_LEVELS, value=_FIRST_LEVEL, label="Autonomy")
            level.props("outlined dense").classes("wide")

            async def attach() -> None:
                await self.give("attach", lambda: self.console.attach(int(level.value)))

            self.button("Attach", attach, icon="visibility")

    def _show_controls(self, view: RunView) -> None:
        level = ui.select(
            _ATTACHED_LEVELS,
            value=view.level,
            label="Autonomy: what the engine does unasked",
            on_change=lambda event: self._order(SetAutonomy(int(event.value))),
        )
        level.props("outlined dense").classes("wide").set_enabled(self.is_operator)
        with ui.row().classes("controls"):
            if view.is_paused:
                self._control("Go on", Resume(), "play_arrow")
            else:
                self._control("Pause", Pause(), "pause")
            self._control("Repeat", Repeat(), "replay")
            if view.held is not None:
                self._control("Unlock", Release(view.held), "lock_open")
            else:
                with self.button("Lock", self._show_levels, icon="lock", look="quiet"):
                    self._levels = ui.menu()
        if view.held is not None:
            ui.label(f"Locked: {_breadcrumb(view.held)}").classes("held")
        self._outcomes = ui.element("div").classes("wide")
        self._outcomes_of = ""
        self._show_outcomes()

    def _show_levels(self) -> None:
        """Fill the menu of what can be locked now."""
        self._levels.clear()
        with self._levels:
            for path in self.console.live.world.run.holdable():
                ui.menu_item(_breadcrumb(path), partial(self._order, Hold(path)))

    async def _show_what_changes_fast(self) -> None:
        """Show what follows each state; not faster than it can be read."""
        view = self.console.live.world.run
        self._where.text = _breadcrumb(view.active)
        self._count.text = _count_words(view)
        self._show_outcomes()
        await self._drawing.follow()

    def _show_outcomes(self) -> None:
        """Show the outcomes of the active state."""
        view = self.console.live.world.run
        if not view.is_supervised or self._outcomes is None or view.active == self._outcomes_of:
            return
        outcomes = view.outcomes(view.active)
        self._outcomes_of = view.active if outcomes else ""
        self._outcomes.clear()
        with self._outcomes:
            label = view.active.rpartition("/")[2]
            ui.label(f"Leave '{label}' with" if outcomes else "").classes("soft")
            with ui.row().classes("controls outcomes"):
                for index, outcome in enumerate(outcomes):
                    forced = TakeOutcome(view.active, index, outcome, is_forced=True)
                    self._control(outcome, forced, None)

    def _control(self, text: str, order: Order, icon: str | None) -> None:
        self.button(text, partial(self._order, order), icon=icon, look="quiet")

    def _show_userdata(self) -> None:
        with ui.expansion("Userdata").classes("wide"):
            rows = ui.element("div")

            async def look() -> None:
                rows.clear()
                engine = self.console.engine
                try:
                    found = await run.io_bound(engine.userdata) if engine else ()
                except CommandError as error:
                    with rows:
                        ui.label(str(error)).classes("ending bad")
                    return
                with rows:
                    table(("Key", "Value", "Where"), ((k, v, w) for w, k, _, v in found))

            ui.button("Read", on_click=look, icon="refresh").props("flat dense no-caps")

    # Deeds

    def _loaded(self) -> str:
        chart = self.console.session.chart
        return chart.name if chart else ""

    def _confirmation(self, view: RunView) -> TakeOutcome | None:
        """Return the answer to what the engine asks; None if it asks nothing that is known."""
        if not isinstance(view.asked, Asked):
            return None
        outcomes = view.outcomes(view.asked.path)
        index = view.asked.index
        if index >= len(outcomes):
            return None
        return TakeOutcome(view.asked.path, index, outcomes[index], is_forced=False)

    async def _order(self, order: Order) -> None:
        await self.give(str(order), lambda: self.console.order(order))

    async def load(self, name: str) -> None:
        """Load a behavior into the session; ask first if something would be lost."""
        session = self.console.session
        command = Command(f"load {name}", Verb.LOAD, {"name": name})

        async def do() -> None:
            await self.give(command.text, lambda: session.carry_out(command))

        if session.is_saved or session.chart is None:
            await do()
        else:
            self.ask(
                f"'{session.chart.name}' has changes that are not saved.", "Load, and lose them", do
            )

    def _ask_stop(self) -> None:
        self.ask(
            "Stop the behavior? Its goals are cancelled.", "Stop", partial(self._order, Preempt())
        )

    async def start(self, order: Order) -> bool:
        """Start a behavior; tell whether the engine was asked."""
        return (await self.give(str(order), lambda: self.console.order(order))).state == DONE


def _without_path(view: RunView) -> tuple[object, ...]:
    """Return what the panel depends on: all but what changes with each state."""
    return (
        view.phase, view.behavior_id, view.asked, view.level,
        view.is_paused, view.held, view.has_structure, view.ending,
    )  # fmt: skip


def _state_words(view: RunView) -> str:
    if view.phase is Phase.AWAY:
        return "no engine"
    if view.phase is Phase.IDLE:
        return "idle"
    if view.asked is not None:
        return "waits for you"
    if view.is_paused:
        return "paused"
    if view.held is not None:
        return "locked"
    return "runs" if view.is_supervised else "runs unattended"


def _loaded_words(loaded: str) -> str:
    return f"'{loaded}' is loaded now" if loaded else "nothing is loaded yet"


def _count_words(view: RunView) -> str:
    return f"{view.entries} states entered"


def _breadcrumb(path: str) -> str:
    return " / ".join(part for part in path.split("/") if part)
