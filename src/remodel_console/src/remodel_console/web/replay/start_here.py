"""Start a behavior at the state of a moment of Replay, in a simulated cell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from nicegui import ui

from remodel_console.core.answer import DONE
from remodel_console.core.cell.cell_state import CellState, differences
from remodel_console.core.commands import Command, Verb
from remodel_console.core.run.order import FULL, Pairs, Start
from remodel_console.core.run.run_view import Phase
from remodel_console.core.run.state_values import Value
from remodel_console.core.use_case.record import Moment
from remodel_console.core.world import World
from remodel_console.edge.catalogue import Installed
from remodel_console.web.page import Page

_RESTORED = "The state gets the values that it found in this run; change any of them."
_UNKNOWN = (
    "No console recorded which values the state found in this run. Enter what earlier states would "
    "have written."
)
_CELL = (
    "The cell is not put back: robot, wires and components stay where they are now. To bring it to "
    "this moment, do the tasks before it again: start the order on Overview with an empty panel."
)
_SAME = "In the cell, everything that was recorded is where it was."
_NO_RECORDING = "How the cell was at this moment is not recorded."
_EVERY_S = 0.5  # between two comparisons with the cell


@dataclass(frozen=True)
class Recorded:
    """What a recording has of a moment: the values that the state found, and the cell."""

    values: tuple[Value, ...] = ()
    cell: CellState | None = None


class StartHere:
    """A button that starts a behavior where the replayed run is."""

    def __init__(self, page: Page, recorded: Callable[[], Recorded]) -> None:
        """Build the button; it can be pressed once there is a state to start at.

        `recorded` returns what is known of the moment.
        """
        self._page = page
        self._recorded = recorded
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
        if not world.can_be_put_back:
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
        recorded = self._recorded()
        with page.dialog() as dialog:
            ui.label(f"Start '{installed.name}' at {moment.state}").classes("title")
            is_reset = self._cell(dialog, recorded)
            ui.label("Values").classes("heading")
            ui.label(_RESTORED if recorded.values else _UNKNOWN).classes("soft")
            with ui.element("div").classes("pair wide"):
                fields = self._fields(installed, recorded.values)
            more = ui.textarea("Other values", placeholder="one per line: key = value")
            more.props("outlined dense stack-label rows=2").classes("wide")

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
                if not is_reset.value or await self._reset():
                    await self._start(order, dialog)

            page.button("Start", start, icon="play_arrow")

    def _fields(self, installed: Installed, values: tuple[Value, ...]) -> dict[str, ui.input]:
        """Show an input for each value that was recorded, and each that the behavior takes."""
        kinds = {port.name: port.type or "any" for port in installed.behavior.inputs}
        hints = {name: f"default, {kind}" for name, kind in kinds.items()}
        hints |= {v.name: f"{v.kind} that could not be recorded" for v in values if not v.literal}
        literals = {value.name: value.literal for value in values}
        fields = {}
        for name in dict.fromkeys((*literals, *hints)):
            field = ui.input(name, value=literals.get(name, ""), placeholder=hints.get(name, ""))
            fields[name] = field.props("outlined dense stack-label").classes("wide")
        return fields

    def _cell(self, dialog: ui.dialog, recorded: Recorded) -> ui.checkbox:
        """Show what the cell does not restore; return whether its panel is to be rebuilt first."""
        page, scene = self._page, self._page.console.scene
        ui.label("The cell").classes("heading")
        ui.label(_CELL).classes("soft")
        found = ui.column().classes("differences wide")
        is_reset = ui.checkbox("Rebuild the panel first, without any wire")
        is_reset.set_visibility(page.console.live.world.can_reset)
        shown: tuple[str, ...] | None = None

        def compare() -> None:
            nonlocal shown
            now, then = scene.now, recorded.cell
            if then is None:
                words: tuple[str, ...] = (_NO_RECORDING,)
            elif now.robots or now.wires or now.boxes:
                words = differences(then, now) or (_SAME,)
            else:
                words = ("No cell is running.",)
            if words != shown:
                shown = words
                found.clear()
                with found:
                    for text in words:
                        ui.label(text)

        scene.add_viewer(1)  # as long as the dialog is open, the cell is followed
        timer = ui.timer(_EVERY_S, compare)
        compare()
        is_followed = True

        def leave() -> None:
            nonlocal is_followed
            if is_followed:
                is_followed = False
                timer.cancel()
                scene.add_viewer(-1)

        dialog.on("hide", leave)
        dialog.client.on_delete(leave)
        return is_reset

    async def _reset(self) -> bool:
        """Have the cell rebuild its panel; return whether it did."""
        page, reset = self._page, self._page.console.reset_cell
        if reset is None:
            return False
        answer = await page.give("reset the simulated cell", reset)
        return answer.state == DONE

    async def _start(self, order: Start, dialog: ui.dialog) -> None:
        page, steering = self._page, self._page.console.steering
        answer = await page.give(str(order), lambda: steering.order(order))
        if answer.state == DONE:
            dialog.close()
            await self._load(order.name)
            page.go_to("/runtime")

    async def _load(self, name: str) -> None:
        """Load the behavior for Runtime control, unless that would lose changes."""
        page, session = self._page, self._page.session
        if session.chart is None or (session.is_saved and session.chart.name != name):
            command = Command(f"load {name}", Verb.LOAD, {"name": name})
            await page.give(command.text, lambda: session.carry_out(command))
