"""The panel beside the drawing: commands for the running behavior, or the form that starts one."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial

from nicegui import run, ui

from flexbe_synthesizer.core.chart.model import Literal, format_literal
from remodel_console.core.run_view import Phase, RunView, count_words
from remodel_console.core.running import (
    LEVELS,
    STEP,
    UNATTENDED,
    Hold,
    Order,
    Pairs,
    Release,
    SetAutonomy,
    SimpleOrder,
    Start,
    Switch,
    TakeOutcome,
)
from remodel_console.edge.workspace import Installed
from remodel_console.errors import CommandError
from remodel_console.web.elements import table
from remodel_console.web.page import Page


class StartForm:
    """Shows what the loaded behavior takes, and starts it."""

    def __init__(self, page: Page, start: Callable[[Start], Awaitable[object]]) -> None:
        self._page = page
        self._start_behavior = start
        self._known = {one.name: one for one in page.console.catalogue.behaviors()}
        chart = page.console.session.chart
        loaded = chart.name if chart and chart.name in self._known else None
        choice = ui.select(
            sorted(self._known),
            value=loaded,
            label="Behavior",
            with_input=True,
            on_change=lambda event: page.load(event.value),
        )
        choice.props("outlined dense").classes("wide").set_enabled(page.is_operator)
        if chart is not None and loaded is None:
            ui.label(f"'{chart.name}' is not saved as a behavior yet; save it to run it.")
        if loaded is not None:
            self._build(self._known[loaded])

    def _build(self, installed: Installed) -> None:
        behavior = installed.behavior
        self._level = ui.select(
            {level: word.capitalize() for level, word in LEVELS.items()},
            value=UNATTENDED,
            label="Autonomy: what needs no confirmation",
        )
        self._level.props("outlined dense").classes("wide")
        chart = self._page.console.session.chart
        usual = {port.name: port.default for port in chart.inputs} if chart else {}
        self._parameters = {
            p.name: _entry(p.name, "default of the behavior") for p in behavior.parameters
        }
        self._inputs = {
            port.name: _entry(port.name, _usually(usual.get(port.name), port.type))
            for port in behavior.inputs
        }
        if not self._page.console.session.is_saved:
            ui.label(
                "Start runs the saved version, without the unsaved changes in the editor."
            ).classes("held")
        self._page.button("Start", self._start, icon="play_arrow")
        self._installed = installed

    async def _start(self) -> None:
        await self._start_behavior(
            Start(
                name=self._installed.name,
                behavior_id=self._installed.behavior_id,
                source_checksum=self._installed.source_checksum,
                level=int(self._level.value),
                parameters=_given(self._parameters),
                inputs=_given(self._inputs),
            )
        )


def _entry(name: str, hint: str) -> ui.input:
    entry = ui.input(name, placeholder=hint)
    entry.props("outlined dense stack-label").classes("wide")
    return entry


def _usually(default: Literal, kind: str | None) -> str:
    """Return what an input is if it is left empty, or what it takes."""
    return f"default: {format_literal(default)}" if default is not None else kind or "any"


def _given(entries: dict[str, ui.input]) -> Pairs:
    """Return what was given; the behavior's own defaults stay for what was not."""
    return tuple(
        (name, entry.value.strip())
        for name, entry in entries.items()
        if (entry.value or "").strip()
    )


_ATTACHED_LEVELS = {
    level: word.capitalize() for level, word in LEVELS.items() if level != UNATTENDED
}
_STEP_HINT = "Step mode: the engine asks before every transition; Alt+C takes it."
_FIRST_LEVEL = 1  # low, as in the FlexBE App


class RunPanel:
    """Shows what can be done with the run, and sends the engine orders.

    What depends on the run is rebuilt when that changes. The Stop button never is, and stands above
    all of it: it does not move while it is pressed.

    Attributes:
        area: the whole panel.
    """

    def __init__(self, page: Page, order: Callable[[Order], Awaitable[object]]) -> None:
        """Build a panel without a run; `order` gives the engine an order."""
        self._page = page
        self._order = order
        self._shown: object = None
        self._level_before = _FIRST_LEVEL
        self._outcomes: ui.element | None = None
        self._outcomes_of = ""
        with (
            ui.element("aside")
            .classes("panel")
            .props('tabindex="0" aria-label="Commands"') as self.area
        ):
            self._stop = page.button("Stop", self._ask_stop, icon="stop", look="stop")
            self._area = ui.element("div").classes("run-area")
            self._userdata = self._build_userdata()
            self._where = ui.label().classes("where")
            self._count = ui.label().classes("soft")

    def show(self, view: RunView, running: str, loaded: str, newer: Switch | None) -> None:
        """Show what can be done.

        Args:
            view: the run.
            running: name of the behavior that runs; empty if none does, or it is not known.
            loaded: name of the behavior that is loaded; empty if none is.
            newer: the switch to another saved version of what runs; None without one.
        """
        shown = (_without_path(view), running, loaded, newer)
        if shown == self._shown:
            return
        self._shown = shown
        self._area.clear()
        self._outcomes = None
        with self._area:
            if view.is_starting:
                ui.label("The engine prepares the behavior; Stop ends that.").classes("held")
            elif view.phase is not Phase.RUNNING:
                self._show_idle(view)
            else:
                self._show_running(view, running, loaded, newer)
        self._stop.set_visibility(view.phase is Phase.RUNNING or view.is_starting)
        self._userdata.set_visibility(view.is_supervised)
        self._where.set_visibility(view.phase is Phase.RUNNING)
        self._count.set_visibility(view.entries > 0)
        self.follow(view)

    def follow(self, view: RunView) -> None:
        """Show what follows each state."""
        self._where.text = view.chart_state(view.active).words
        self._count.text = count_words(view)
        self._show_outcomes(view)

    def _show_idle(self, view: RunView) -> None:
        if view.ending:
            style = "ending bad" if view.has_failed else "ending"
            ui.label(f"The last run {view.ending_words}.").classes(style)
        StartForm(self._page, self._order)

    def _show_running(self, view: RunView, running: str, loaded: str, newer: Switch | None) -> None:
        if view.is_supervised:
            if view.ending:
                ui.label(f"The behavior {view.ending}.").classes("ending bad")
            self._show_newer_version(newer)
            self._show_controls(view)
        else:
            self._show_attach(running, loaded)

    def _show_newer_version(self, newer: Switch | None) -> None:
        """Offer the version that has been saved while this one runs."""
        if newer is None:
            return
        with ui.element("div").classes("card attach"):
            ui.label(f"Another version of '{newer.name}' is saved.").classes("question")
            ui.label("The active state continues in it, locked until you unlock it.").classes(
                "soft"
            )
            self._control("Switch", newer, "swap_horiz")

    def _show_attach(self, running: str, loaded: str) -> None:
        """Show how to attach, or what to load first."""
        name = (
            f"'{running}'" if running else "A behavior that is not installed here in this version"
        )
        with ui.element("div").classes("card attach"):
            ui.label(f"{name} runs unattended.").classes("question")
            ui.label("Attach to confirm, lock, pause and force its states.").classes("soft")
            if running and running != loaded:
                ui.label(f"Load '{running}' first: {_loaded_words(loaded)}.")
                self._page.button(
                    f"Load '{running}'", partial(self._page.load, running), icon="folder_open"
                )
                return
            level = ui.select(_ATTACHED_LEVELS, value=_FIRST_LEVEL, label="Autonomy")
            level.props("outlined dense").classes("wide")

            async def attach() -> None:
                await self._page.give(
                    "attach", lambda: self._page.console.steering.attach(int(level.value))
                )

            self._page.button("Attach", attach, icon="visibility")

    def _show_controls(self, view: RunView) -> None:
        level = ui.select(
            _ATTACHED_LEVELS,
            value=view.level,
            label="Autonomy: what needs no confirmation",
            on_change=lambda event: self._order(SetAutonomy(int(event.value))),
        )
        level.props("outlined dense").classes("wide").set_enabled(self._page.is_operator)
        if view.level == STEP:
            ui.label(_STEP_HINT).classes("held")
            self._control("Leave step mode", self.other_mode(view), "fast_forward")
        else:
            self._level_before = view.level or _FIRST_LEVEL
            self._control("Step mode", self.other_mode(view), "skip_next")
        with ui.row().classes("controls"):
            if view.is_paused:
                self._control("Continue", SimpleOrder.RESUME, "play_arrow")
            else:
                self._control("Pause", SimpleOrder.PAUSE, "pause")
            self._control("Repeat", SimpleOrder.REPEAT, "replay")
            if view.held is not None:
                self._control("Unlock", Release(view.held), "lock_open")
            else:
                with self._page.button("Lock", self._show_levels, icon="lock", look="quiet"):
                    self._levels = ui.menu()
        if view.held is not None:
            ui.label(f"Locked: {view.chart_state(view.held).words}").classes("held")
        self._outcomes = ui.element("div").classes("wide")
        self._outcomes_of = ""
        self._show_outcomes(view)

    def other_mode(self, view: RunView) -> SetAutonomy:
        """Return the order that begins step mode, or ends it at the level of before."""
        return SetAutonomy(self._level_before if view.level == STEP else STEP)

    def _show_levels(self) -> None:
        """Fill the menu of what can be locked now."""
        self._levels.clear()
        with self._levels:
            view = self._page.console.live.world.run
            words = {view.chart_state(path).words: path for path in reversed(view.holdable())}
            for text, path in reversed(words.items()):
                ui.menu_item(text, partial(self._order, Hold(path)))

    def _show_outcomes(self, view: RunView) -> None:
        """Show the outcomes of the active state."""
        if not view.is_supervised or self._outcomes is None or view.active == self._outcomes_of:
            return
        outcomes = view.outcomes(view.active)
        self._outcomes_of = view.active if outcomes else ""
        self._outcomes.clear()
        with self._outcomes:
            state = view.chart_state(view.active)
            ui.label(f"Leave '{state.label}' with" if outcomes else "").classes("soft")
            with ui.row().classes("controls outcomes"):
                for index, outcome in enumerate(outcomes):
                    forced = TakeOutcome(view.active, index, outcome, is_forced=True)
                    self._control(state.answer(outcome), forced, None)

    def _control(self, text: str, order: Order, icon: str | None) -> None:
        self._page.button(text, partial(self._order, order), icon=icon, look="quiet")

    def _build_userdata(self) -> ui.expansion:
        with ui.expansion("Userdata").classes("wide") as userdata:
            rows = ui.element("div")

            async def look() -> None:
                rows.clear()
                engine = self._page.console.steering.engine
                try:
                    found = await run.io_bound(engine.userdata) if engine else ()
                except CommandError as error:
                    with rows:
                        ui.label(str(error)).classes("ending bad")
                    return
                with rows:
                    table(("Key", "Value", "State"), ((k, v, w) for w, k, _, v in found))

            ui.button("Read", on_click=look, icon="refresh").props("flat dense no-caps")
        return userdata

    def _ask_stop(self) -> None:
        self._page.ask(
            "Stop the behavior and cancel its goals?",
            "Stop",
            partial(self._order, SimpleOrder.PREEMPT),
        )


def _without_path(view: RunView) -> tuple[object, ...]:
    """Return what the panel depends on: all but what changes with each state."""
    return (
        view.phase, view.is_starting, view.behavior_id, view.level,
        view.is_paused, view.held, view.has_structure, view.ending_words,
    )  # fmt: skip


def _loaded_words(loaded: str) -> str:
    return f"'{loaded}' is loaded" if loaded else "no behavior is loaded"
