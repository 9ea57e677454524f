"""Replay: a past run, moment by moment; a behavior started at the state of a moment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from nicegui import background_tasks, run, ui

from remodel_console.core.cell import CellState, Recording, Value, differences
from remodel_console.core.commands import DONE
from remodel_console.core.record import Moment, Record, Summary, recorded_wire_words
from remodel_console.core.run_view import Phase
from remodel_console.core.running import FULL, Pairs, Start
from remodel_console.core.world import ALL_PARTS, World
from remodel_console.edge.workspace import Installed
from remodel_console.errors import CommandError
from remodel_console.watched import Scene, Viewer
from remodel_console.web.canvas import BehaviorDrawing
from remodel_console.web.cell_view import CameraView, CellPanel
from remodel_console.web.page import Page
from remodel_console.web.replay_panels import ComparisonPanel, RunList, Scrubber, ValuePlots
from remodel_run.record import Entry, entry_words

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
_STATE_UNKNOWN = "How the cell was at this moment is not recorded."
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
                words: tuple[str, ...] = (_STATE_UNKNOWN,)
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

        viewer = Viewer(scene)
        viewer.watch(True)  # as long as the dialog is open
        timer = ui.timer(_EVERY_S, compare)
        compare()

        def leave() -> None:
            timer.cancel()
            viewer.watch(False)

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
            await page.load_into(session, name)


_NO_RECORDING = "No console recorded the cell in three dimensions during this run."
_SHOWN_REASONS = 20  # the latest until the moment


class ReplayPage(Page):
    """The page of a run that was recorded."""

    PARTS = ALL_PARTS
    KEYS = (
        ("P", "play or pause"),
        (",  .", "previous or next entry"),
        ("B  N", "previous or next failure, decision or answer"),
    )

    def build(self) -> None:
        """Build the list of runs, the drawing with what moves in time, and the panel of reasons."""
        self._record = Record(())
        self._recording: Recording | None = None
        self._scene = Scene()
        self._index = 0
        self._run = 0
        self._shown_reasons: tuple[Entry, ...] | None = None
        with ui.element("div").classes("replay"):
            self._runs = RunList(self.console, self._open, lambda r: self._comparison.offer(r))
            with ui.element("section").classes("stage"):
                with ui.row().classes("headline"):
                    self._title = ui.label("No run is open").classes("title")
                    self._where = ui.label().classes("where")
                with ui.element("div").classes("drawing-area"):
                    self._drawing = BehaviorDrawing(
                        self.console,
                        "State machine of the behavior",
                        "Choose a run: its behaviors are drawn here while they run.",
                    )
                self._comparison = ComparisonPanel(self.console, lambda i: self._scrubber.go(i))
            self._scrubber = Scrubber(self._show_moment, self._move)
            part = self._arrangement.part
            self._arrangement.splitter("Width of the moment", "panel", is_column=True)
            with ui.element("aside").classes("panel").props('tabindex="0" aria-label="Moment"'):
                self._now = ui.element("div").classes("wide")
                self._start = StartHere(self, self._recorded)
                with part("Cell", "panel"):
                    self._cell = CellPanel(self._scene, self.console.meshes, self._about_wire)
                    self._no_cell = ui.label(_NO_RECORDING).classes("soft")
                self._no_cell.set_visibility(False)
                with part("Picture", "panel"):
                    self._picture = CameraView(
                        "Last camera picture", "no picture was stored up to this time"
                    )
                with part("Failures and decisions", "panel"):
                    ui.label("Failures and decisions").classes("heading")
                    self._reasons = ui.element("div").classes("failures wide")
                with part("Values", "panel"):
                    self._values = ValuePlots()
        self._has_supervisor = False

    def show(self, world: World) -> None:
        """List the runs as soon as a supervisor is running; a record does not change."""
        if world.has_supervisor and not self._has_supervisor:
            background_tasks.create(self._list())
        self._has_supervisor = world.has_supervisor
        moment = self._record.moment(self._index) if self._record.entries else None
        self._start.show(moment, world)

    def set_in_view(self, is_in_view: bool) -> None:
        """Draw the cell only while the page is in view."""
        self._cell.set_shown(is_in_view and self._arrangement.is_shown("Cell"))

    def press(self, key: str, *, ctrl: bool) -> None:
        """Move in time."""
        if ctrl or not self._record.entries:
            return
        if key.lower() == "p":
            self._scrubber.toggle()
        elif key in (",", "."):
            self._scrubber.step(1 if key == "." else -1)
        elif key.lower() in ("b", "n"):
            self._scrubber.step_reason(1 if key.lower() == "n" else -1)

    async def _list(self) -> None:
        """List the runs; open the one that the address names."""
        runs = await self._runs.list()
        wanted = next((one for one in runs if str(one.run) == self.query.get("run")), None)
        if wanted is not None and not self._run:
            await self._open(wanted)

    async def _open(self, summary: Summary) -> None:
        """Read the record of a run, and show its beginning."""
        scenes, of_run = self.console.scenes, (summary.run, summary.order, summary.started_s)
        try:
            record = await run.io_bound(self.console.record, summary.run)
        except CommandError as error:
            ui.notify(str(error), type="negative")
            return
        self._recording = await run.io_bound(scenes.read, *of_run)
        self._no_cell.set_visibility(self._recording is None)
        self._scene.now = CellState()
        self._record, self._run = record, summary.run
        self._title.text = f"{summary.order}, run {summary.run}"
        self._runs.mark(summary.run)
        self._values.open(record)
        self._scrubber.open(record)
        await self._comparison.open(summary, record)

    # A moment

    def _move(self, offset_s: float) -> None:
        """Show the cell in three dimensions as it was at a time in the run [s]."""
        if self._recording is not None:
            self._scene.now = self._recording.at(self._record.begin_s + offset_s)
        self._cell.show()

    def _recorded(self) -> Recorded:
        """Return what the recording has of the moment that is shown."""
        recording, record = self._recording, self._record
        if recording is None or not record.entries:
            return Recorded()
        path = record.moment(self._index).state_path
        values = recording.values_at(path, *record.visit_s(self._index))
        return Recorded(values, recording.at(record.begin_s + record.offsets_s[self._index]))

    def _about_wire(self, wire: str) -> tuple[str, ...]:
        return recorded_wire_words(self._record, wire, self._index)

    def _show_moment(self, index: int) -> None:
        moment, offset_s = self._record.moment(index), self._record.offsets_s[index]
        self._index = index
        self._cell.show()
        self._start.show(moment, self.console.live.world)
        self._where.text = moment.state
        self._show_now(moment)
        self._values.move(offset_s)
        if moment.reasons != self._shown_reasons:
            self._shown_reasons = moment.reasons
            self._show_reasons(moment.reasons)
        self._picture.show(f"/record/{self._run}/{moment.picture}" if moment.picture else "")
        self._drawing.light(moment.state_path, frozenset(moment.passed), is_asked=False)
        if moment.behavior != self._drawing.name:
            self._drawing.name = moment.behavior
            background_tasks.create(self._drawing.draw(moment.behavior))
        else:
            background_tasks.create(self._drawing.follow())

    def _show_now(self, moment: Moment) -> None:
        self._now.clear()
        with self._now:
            ui.label(f"Task {moment.task}" if moment.task else "Between tasks").classes("title")
            entry, feedback = moment.entry, moment.feedback
            ui.label(f"{entry.kind.value}: {entry_words(entry)}").classes("entry-words")
            if feedback is not None and feedback is not entry:
                ui.label(f"{feedback.kind.value}: {entry_words(feedback)}").classes("soft")

    def _show_reasons(self, reasons: tuple[Entry, ...]) -> None:
        self._reasons.clear()
        with self._reasons:
            if not reasons:
                ui.label("None up to this time.").classes("soft")
            for entry in reasons[:_SHOWN_REASONS]:
                with ui.element("div").classes(f"failure {entry.kind.value}"):
                    when = f"{self._record.offset_s(entry):.1f} s"
                    ui.label(f"{entry.task}, {when}" if entry.task else when).classes("soft")
                    ui.label(entry_words(entry))
