"""Replay: a past run, moment by moment: state path, feedback, values, pictures, and reasons."""

from __future__ import annotations

from nicegui import background_tasks, run, ui

from remodel_console.core.cell.cell_state import CellState, Recording
from remodel_console.core.cell.wire_history import recorded_wire_words
from remodel_console.core.use_case.record import Moment, Record, Summary
from remodel_console.core.world import ALL_PARTS, World
from remodel_console.errors import CommandError
from remodel_console.watched import Scene
from remodel_console.web.behavior_drawing import BehaviorDrawing
from remodel_console.web.cell.cell_view import CameraView, CellPanel
from remodel_console.web.page import Page
from remodel_console.web.replay.comparison_panel import ComparisonPanel, ValuePlots
from remodel_console.web.replay.run_list import RunList
from remodel_console.web.replay.scrubber import Scrubber
from remodel_console.web.replay.start_here import Recorded, StartHere
from remodel_run.record import Entry, entry_words

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
        if self._run:
            self._runs.mark(self._run)
        elif wanted is not None:
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
