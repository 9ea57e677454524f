"""Replay: a past run, moment by moment: state path, feedback, values, pictures, and reasons."""

from __future__ import annotations

import time
from collections.abc import Iterable
from functools import partial

from nicegui import background_tasks, run, ui

from remodel_console.core.plot import series_plot
from remodel_console.core.record import REASONS, Entry, Kind, Moment, Record, Summary, value_words
from remodel_console.core.use_case import decision_words, duration_words, fault_words
from remodel_console.core.world import Notice, World, supervisor_notice
from remodel_console.errors import CommandError
from remodel_console.web.behavior_drawing import BehaviorDrawing
from remodel_console.web.camera_view import CameraView
from remodel_console.web.page import Page

_ROOM = (700.0, 420.0)  # for the drawing on a common screen [pixels]
_FRAME_S = 0.25  # between two moments while it plays
_STEP_S = 0.1  # of the slider
_SPEEDS = {1: "1 x", 5: "5 x", 20: "20 x"}
_KIND_WORDS = {
    Kind.RUN: "run",
    Kind.TASK: "task",
    Kind.STATE: "state",
    Kind.FEEDBACK: "feedback",
    Kind.RESULT: "result",
    Kind.FAILURE: "failure",
    Kind.DECISION: "decision",
    Kind.OPERATOR: "operator",
    Kind.PICTURE: "picture",
}


class ReplayPage(Page):
    """The page of a run that was recorded."""

    KEYS = (
        ("P", "play, or hold"),
        (",  .", "the moment before, the next one"),
        ("B  N", "the failure, decision or answer before, the next one"),
    )

    def build(self) -> None:
        """Build the list of runs, the drawing with what moves in time, and the panel of reasons."""
        self._record = Record(())
        self._run = 0
        self._index = 0
        with ui.element("div").classes("replay"):
            with ui.element("aside").classes("runs"):
                with ui.row().classes("runs-head"):
                    ui.label("Runs").classes("title")
                    again = ui.button(icon="refresh", on_click=self._list, color=None)
                    again.props('flat dense round title="Look again" aria-label="Look again"')
                self._runs = ui.element("div").classes("wide")
            with ui.element("section").classes("stage"):
                with ui.row().classes("headline"):
                    self._title = ui.label("Choose a run on the left.").classes("title")
                    self._where = ui.label().classes("where")
                self._drawing = BehaviorDrawing(
                    self.console,
                    "State machine of the behavior that ran",
                    "No behavior of this task has run yet.",
                    _ROOM,
                )
            with ui.element("section").classes("scrub"):
                self._build_scrubber()
            with ui.element("aside").classes("panel"):
                self._build_panel()
        self._player = ui.timer(_FRAME_S, self._play_on, active=False)
        self._has_supervisor = False

    def more_notices(self, world: World) -> Iterable[Notice]:
        """Return whether the supervisor, who has the records, is away."""
        return supervisor_notice(world)

    def show(self, world: World) -> None:
        """List the runs as soon as somebody can tell them; a record does not change."""
        if world.has_supervisor and not self._has_supervisor:
            background_tasks.create(self._list())
        self._has_supervisor = world.has_supervisor

    def press(self, key: str, *, ctrl: bool) -> None:
        """Move in time."""
        if ctrl or not self._record.entries:
            return
        if key.lower() == "p":
            self._toggle()
        elif key in (",", "."):
            self._step(1 if key == "." else -1)
        elif key.lower() in ("b", "n"):
            self._step_reason(1 if key.lower() == "n" else -1)

    # The runs

    async def _list(self) -> None:
        """List the runs; open the one that the address names."""
        recorder = self.console.recorder
        try:
            if recorder is None:
                raise CommandError("ROS is away; records cannot be asked for.")
            runs = await run.io_bound(recorder.runs)
        except CommandError as error:
            self._runs.clear()
            with self._runs:
                ui.label(str(error)).classes("ending bad")
            return
        self._runs.clear()
        with self._runs:
            if not runs:
                ui.label("No run is recorded yet.").classes("soft")
            for summary in runs:
                self._show_summary(summary)
        wanted = next((one for one in runs if str(one.run) == self.query.get("run")), None)
        if wanted is not None and not self._run:
            await self._open(wanted)

    def _show_summary(self, summary: Summary) -> None:
        button = ui.element("button").classes("run").on("click", partial(self._open, summary))
        button.props(f'data-run="{summary.run}"')
        with button:
            ui.label(f"{summary.run}  {summary.order}").classes("what")
            begun = time.strftime("%Y-%m-%d %H:%M", time.localtime(summary.started_s))
            ui.label(f"{begun}, {duration_words(summary.taken_s)}, {summary.cell}").classes("soft")
            words = f"{summary.done} of {summary.tasks} done"
            if not summary.has_ended:
                words += ", not ended"
            ui.label(words).classes("good" if summary.is_success else "soft")

    async def _open(self, summary: Summary) -> None:
        """Read the record of a run, and show its beginning."""
        recorder = self.console.recorder
        if recorder is None:
            return
        try:
            record = await run.io_bound(recorder.record, summary.run)
        except CommandError as error:
            ui.notify(str(error), type="negative")
            return
        self._hold()
        self._record, self._run = record, summary.run
        self._title.text = f"{summary.order}, run {summary.run}"
        for button in self._runs.default_slot.children:
            button.classes(remove="here")
            if button.props.get("data-run") == str(summary.run):
                button.classes("here")
        self._slider.props(f"max={record.length_s:.3f}")
        self._slider.set_enabled(bool(record.entries))
        self._reason_marks.set_content(_marks(record))
        if record.entries:
            self._go(0)
        else:
            self._clock.text = "Nothing was recorded of this run."

    # Time

    def _build_scrubber(self) -> None:
        with ui.row().classes("controls scrub-row"):
            self._small("skip_previous", "Reason before (B)", partial(self._step_reason, -1))
            self._small("chevron_left", "Moment before (,)", partial(self._step, -1))
            self._play = self._small("play_arrow", "Play (P)", self._toggle)
            self._small("chevron_right", "Next moment (.)", partial(self._step, 1))
            self._small("skip_next", "Next reason (N)", partial(self._step_reason, 1))
            self._speed = ui.select(_SPEEDS, value=5).props('dense outlined aria-label="Speed"')
            self._clock = ui.label().classes("clock")
        with ui.element("div").classes("track"):
            self._slider = ui.slider(min=0, max=1, step=_STEP_S, value=0)
            self._slider.on("update:model-value", lambda event: self._seek(float(event.args)))
            self._slider.props('aria-label="Time in the run"').set_enabled(False)
            self._reason_marks = ui.html("", sanitize=False).classes("marks")

    def _small(self, icon: str, title: str, deed: object) -> ui.button:
        made = ui.button(icon=icon, on_click=deed, color=None)
        made.props(f'flat dense round title="{title}" aria-label="{title}"')
        return made

    def _step(self, step: int) -> None:
        self._go(self._index + step)

    def _step_reason(self, step: int) -> None:
        self._go(self._record.next_reason(self._index, step))

    def _seek(self, offset_s: float) -> None:
        """Show the moment of a time in the run [s]."""
        index = self._record.at(offset_s)
        if index != self._index:
            self._index = index
            self._show_moment()

    def _toggle(self) -> None:
        if self._player.active:
            self._hold()
        elif self._record.entries:
            self._play.props("icon=pause")
            self._player.activate()

    def _hold(self) -> None:
        self._player.deactivate()
        self._play.props("icon=play_arrow")

    def _play_on(self) -> None:
        offset_s = float(self._slider.value) + _FRAME_S * int(self._speed.value)
        self._slider.value = min(offset_s, self._record.length_s)
        self._seek(offset_s)
        if offset_s >= self._record.length_s:
            self._hold()

    def _go(self, index: int) -> None:
        """Show a moment by the index of its entry."""
        if not self._record.entries:
            return
        self._index = min(max(0, index), len(self._record.entries) - 1)
        self._slider.value = self._record.offset_s(self._record.entries[self._index])
        self._show_moment()

    # A moment

    def _build_panel(self) -> None:
        self._now = ui.element("div").classes("wide")
        self._picture = CameraView("What a camera saw last", "no picture was kept until here")
        ui.label("Why").classes("heading")
        self._reasons = ui.element("div").classes("failures wide")
        self._plots = ui.element("div").classes("wide")

    def _show_moment(self) -> None:
        moment, record = self._record.moment(self._index), self._record
        offset_s = record.offset_s(moment.entry)
        self._clock.text = (
            f"{offset_s:.1f} s of {record.length_s:.1f} s, "
            f"entry {self._index + 1} of {len(record.entries)}"
        )
        self._where.text = " / ".join(filter(None, moment.state_path.split("/")))
        self._show_now(moment)
        self._show_values(offset_s)
        self._show_reasons(moment)
        address = f"/record/{self._run}/{moment.picture}" if moment.picture else ""
        self._picture.show(address)
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
            entry = moment.entry
            kind = _KIND_WORDS[entry.kind]
            ui.label(f"{kind}: {_entry_words(entry)}").classes("entry-words")
            told = moment.feedback
            if told is not None and told is not entry:
                ui.label(f"{_KIND_WORDS[told.kind]}: {_entry_words(told)}").classes("soft")

    def _show_values(self, offset_s: float) -> None:
        self._plots.clear()
        record = self._record
        with self._plots:
            for name in record.value_names():
                points = tuple(record.series(name))
                before = [value for time_s, value in points if time_s <= offset_s]
                with ui.row().classes("plot-head"):
                    ui.label(value_words(name)).classes("soft")
                    ui.label(f"{before[-1]:.3g}" if before else "-").classes("figure")
                svg = series_plot(name, points, offset_s, record.length_s)
                ui.html(svg, sanitize=False).classes("wide")

    def _show_reasons(self, moment: Moment) -> None:
        self._reasons.clear()
        with self._reasons:
            if not moment.reasons:
                ui.label("Until here nothing had to be decided.").classes("soft")
            for entry in moment.reasons:
                with ui.element("div").classes(f"failure {entry.kind.value}"):
                    when = f"{self._record.offset_s(entry):.1f} s"
                    ui.label(f"{entry.task}, {when}" if entry.task else when).classes("soft")
                    ui.label(_entry_words(entry))


def _entry_words(entry: Entry) -> str:
    """Return what an entry tells, for a person."""
    if entry.kind is Kind.STATE:
        return entry.state_path or "the behavior has ended"
    if entry.kind is Kind.FAILURE:
        return f"{fault_words(entry.fault)}: {entry.text}".removesuffix(": ")
    if entry.kind is Kind.DECISION:
        because = f", because {entry.because}" if entry.because else ""
        return f"The cell {decision_words(entry.text)}{because}."
    if entry.kind is Kind.OPERATOR:
        return f"{entry.because}: {entry.text}" if entry.because else entry.text
    if entry.kind is Kind.RUN and entry.because:
        return f"{entry.text}: {entry.because}"
    who = f"{entry.ability}: " if entry.ability else ""
    return f"{who}{entry.text}" or entry.kind.value


def _marks(record: Record) -> str:
    """Return the failures, decisions and answers as marks on the track of time."""
    if not record.entries or not record.length_s:
        return ""
    reasons = (entry for entry in record.entries if entry.kind in REASONS)
    places = (
        (100 * record.offset_s(entry) / record.length_s, entry.kind.value)
        for entry in sorted(reasons, key=lambda entry: entry.kind is Kind.FAILURE)  # on top
    )
    return "".join(
        f'<i class="{kind}-mark" style="left:{place:.2f}%"></i>' for place, kind in places
    )
