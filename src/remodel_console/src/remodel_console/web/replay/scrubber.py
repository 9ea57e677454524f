"""The control of time in a replayed run: a track with marks, buttons, and the speed."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from nicegui import ui

from remodel_console.core.use_case.record import REASONS, Record
from remodel_run.record import Kind

_FRAME_S = 0.25  # between two moments while it plays
_STEP_S = 0.1  # of the slider
_SPEEDS = {1: "1 x", 5: "5 x", 20: "20 x"}


class Scrubber:
    """Moves through a record."""

    def __init__(self, show: Callable[[int], None], move: Callable[[float], None]) -> None:
        """Build it without a record.

        Args:
            show: gets the index of each entry that is gone to.
            move: gets each time in the run that is gone to [s].
        """
        self._show = show
        self._move = move
        self._record = Record(())
        self._index = 0
        with ui.element("section").classes("scrub"):
            with ui.row().classes("controls scrub-row"):
                _small("skip_previous", "Previous reason (B)", partial(self.step_reason, -1))
                _small("chevron_left", "Previous entry (,)", partial(self.step, -1))
                self._play = _small("play_arrow", "Play (P)", self.toggle)
                _small("chevron_right", "Next entry (.)", partial(self.step, 1))
                _small("skip_next", "Next reason (N)", partial(self.step_reason, 1))
                self._speed = ui.select(_SPEEDS, value=5).props('dense outlined aria-label="Speed"')
                self._clock = ui.label().classes("clock")
            with ui.element("div").classes("track"):
                self._slider = ui.slider(min=0, max=1, step=_STEP_S, value=0)
                self._slider.on("update:model-value", lambda event: self._seek(float(event.args)))
                self._slider.props('aria-label="Time in the run"').set_enabled(False)
                self._marks = ui.html("", sanitize=False).classes("marks")
        self._player = ui.timer(_FRAME_S, self._play_on, active=False)

    def open(self, record: Record) -> None:
        """Begin at the start of a record."""
        self._hold()
        self._record = record
        self._slider.props(f"max={record.length_s:.3f}")
        self._slider.set_enabled(bool(record.entries))
        self._marks.set_content(_marks(record))
        if record.entries:
            self.go(0)
        else:
            self._clock.text = "This run has no recorded entries."

    def step(self, step: int) -> None:
        """Go to the next entry, or the one before."""
        self.go(self._index + step)

    def step_reason(self, step: int) -> None:
        """Go to the next failure, decision or answer, or the one before."""
        self.go(self._record.next_reason(self._index, step))

    def toggle(self) -> None:
        """Play or pause."""
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

    def _seek(self, offset_s: float) -> None:
        """Show the moment of a time in the run [s]."""
        self._move(offset_s)
        index = self._record.at(offset_s)
        if index != self._index:
            self._select(index)

    def go(self, index: int) -> None:
        """Go to the entry of an index."""
        if self._record.entries:
            index = min(max(0, index), len(self._record.entries) - 1)
            offset_s = self._record.offset_s(self._record.entries[index])
            self._slider.value = offset_s
            self._move(offset_s)
            self._select(index)

    def _select(self, index: int) -> None:
        self._index, record = index, self._record
        self._clock.text = (
            f"{record.offsets_s[index]:.1f} s of {record.length_s:.1f} s, "
            f"entry {index + 1} of {len(record.entries)}"
        )
        self._show(index)


def _small(icon: str, title: str, deed: Callable[[], object]) -> ui.button:
    made = ui.button(icon=icon, on_click=deed, color=None)
    made.props(f'flat dense round title="{title}" aria-label="{title}"')
    return made


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
