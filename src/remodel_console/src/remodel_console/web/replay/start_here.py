"""Start a behavior at the state of a moment of Replay, in a simulated cell."""

from __future__ import annotations

from nicegui import ui

from remodel_console.core.answer import DONE
from remodel_console.core.commands import Command, Verb
from remodel_console.core.run.order import FULL, Pairs, Start
from remodel_console.core.run.run_view import Phase
from remodel_console.core.run.run_words import path_words
from remodel_console.core.use_case.record import Moment
from remodel_console.core.world import World
from remodel_console.web.page import Page

_HINT = "The simulated cell stays as it is now. Enter what earlier states would have written."


class StartHere:
    """A button that starts a behavior where the replayed run is."""

    def __init__(self, page: Page) -> None:
        """Build the button; it can be pressed once there is a state to start at."""
        self._page = page
        self._moment: Moment | None = None
        self._button = page.button("Start from here", self._ask, icon="play_circle", look="quiet")
        self._why = ui.label().classes("soft")
        self.show(None, page.console.live.world)

    def show(self, moment: Moment | None, world: World) -> None:
        """Take the moment to start at, and show why that is not possible, if it is not."""
        self._moment = moment
        why = self._obstacle(moment, world)
        self._button.set_enabled(self._page.is_operator and not why)
        self._why.text = why
        self._why.set_visibility(bool(why) and moment is not None)

    @staticmethod
    def _obstacle(moment: Moment | None, world: World) -> str:
        if moment is None or not (moment.behavior and moment.state_path):
            return "No state was active at this moment."
        if not world.has_engine:
            return "The engine is not running."
        if not world.is_simulated:
            return "Only a simulated cell can start from here: nothing of a real one is put back."
        if world.run.phase is Phase.RUNNING:
            return "A behavior is running; stop it first."
        return ""

    def _ask(self) -> None:
        """Ask with which values it starts."""
        moment, page = self._moment, self._page
        if moment is None:
            return
        known = {one.name: one for one in page.console.catalogue.behaviors()}
        installed = known.get(moment.behavior)
        if installed is None:
            ui.notify(f"'{moment.behavior}' is not installed here any more.", type="warning")
            return
        with page.dialog() as dialog:
            ui.label(f"Start '{installed.name}' at {path_words(moment.state_path)}").classes(
                "title"
            )
            ui.label(_HINT).classes("soft")
            fields = {
                port.name: ui.input(port.name, placeholder=f"default, {port.type or 'any'}")
                for port in installed.behavior.inputs
            }
            more = ui.textarea("Other values", placeholder="one per line: key = value")
            for field in (*fields.values(), more):
                field.props("outlined dense stack-label").classes("wide")

            async def start() -> None:
                given = [(name, field.value or "") for name, field in fields.items()]
                lines = (line.partition("=") for line in (more.value or "").splitlines())
                given += [(key, value) for key, _, value in lines]
                inputs: Pairs = tuple(
                    (key.strip(), value.strip()) for key, value in given if value.strip()
                )
                order = Start(
                    installed.name,
                    installed.behavior_id,
                    installed.source_checksum,
                    FULL,
                    inputs=inputs,
                    start_at=moment.state_path,
                )
                steering = page.console.steering
                answer = await page.give(str(order), lambda: steering.order(order))
                if answer.state == DONE:
                    dialog.close()
                    await self._load(installed.name)
                    ui.navigate.to("/runtime")

            page.button("Start", start, icon="play_arrow")

    async def _load(self, name: str) -> None:
        """Load the behavior for Runtime control, unless that would lose changes."""
        page, session = self._page, self._page.session
        if session.chart is None or (session.is_saved and session.chart.name != name):
            command = Command(f"load {name}", Verb.LOAD, {"name": name})
            await page.give(command.text, lambda: session.carry_out(command))
