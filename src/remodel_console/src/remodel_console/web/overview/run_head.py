"""The head of the overview: the order, how far it is, and the buttons for all of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from nicegui import ui

from remodel_console.core.use_case.use_case import UseCase, duration_words, stop_words
from remodel_run.progress import Phase, sums_words

# What the page shows until a pause is answered.
PAUSING = "pausing"

Button = Callable[..., ui.button]
Deed = Callable[[], object]
_STYLES = {
    Phase.ASKING: "asking",
    Phase.PAUSING: "asking",
    Phase.PAUSED: "paused",
    Phase.PROTECTIVE_STOP: "away",
}


class RunHead:
    """Shows a run; its elements stay while it changes, so that clicks are not lost."""

    def __init__(
        self,
        button: Button,
        pause: Deed,
        resume: Deed,
        stop: Deed,
        protective_stop: Deed,
        release: Deed,
    ) -> None:
        """Build it; `button` makes buttons that only operators can press."""
        with ui.element("div").classes("protective").props('role="alert"') as self._banner:
            self._stopped_by = ui.label().classes("question")
            self._how_to_release = ui.label()
            self._release = button("Release the protective stop", release, icon="lock_open")
        with ui.row().classes("headline"):
            self._title = ui.label().classes("title")
            self._phase = ui.label()
            self._link = ui.link().classes("soft")
            self._serial = ui.label().classes("soft")
        with ui.element("div").classes("progress wide").props('role="img"') as self._bar:
            self._done = ui.element("div").classes("part done")
            self._aside = ui.element("div").classes("part aside")
        self._progress = ui.label().classes("soft")
        self._message = ui.label()
        self._interruptions = ui.label().classes("soft")
        with ui.row().classes("controls"):
            self._resume = button("Resume", resume, icon="play_arrow")
            self._pause = button("Pause", pause, icon="pause", look="quiet")
            button("Stop", stop, icon="stop", look="stop")
        self._protect = button("Protective stop", protective_stop, icon="front_hand", look="stop")
        self._protect.classes("protect")
        self._pending = ui.label().classes("soft").props('role="status"')
        self._pending.set_visibility(False)

    def show(self, now: UseCase, pending: Iterable[str] = ()) -> None:
        """Show what may have changed.

        Args:
            now: the run.
            pending: commands that the supervisor has not answered yet, such as "pausing".
        """
        self._show_protective_stop(now)
        self._title.text = now.order
        self._serial.text = now.serial
        self._phase.text = now.phase.words
        self._phase.classes(replace=f"state {_STYLES.get(now.phase, 'running')}")
        self._link.text = f"run {now.run}" if now.run else ""
        self._link.props(f'href="/replay?run={now.run}"')
        words = _progress_words(now)
        self._progress.text = words
        self._bar.props(f'aria-label="{words}"')
        self._done.style(f"width: {_percent(now.sums.done_in_all, now.sums.tasks)}")
        self._aside.style(f"width: {_percent(now.sums.skipped, now.sums.tasks)}")
        self._message.text = now.message
        self._message.set_visibility(bool(now.message) and now.phase is not Phase.ASKING)
        self._interruptions.text = _interruption_words(now.interruptions)
        self._interruptions.set_visibility(now.interruptions > 0)
        commands = tuple(pending)
        self._resume.set_visibility(now.is_held and now.phase is not Phase.PROTECTIVE_STOP)
        self._pause.set_visibility(not now.is_held and PAUSING not in commands)
        self._pending.text = " ".join(f"{command}…" for command in commands)
        self._pending.set_visibility(bool(commands))

    def _show_protective_stop(self, now: UseCase) -> None:
        is_stopped = now.phase is Phase.PROTECTIVE_STOP
        self._banner.set_visibility(is_stopped)
        self._protect.set_visibility(not is_stopped)
        self._release.set_visibility(now.is_releasable)
        self._stopped_by.text, self._how_to_release.text = stop_words(now)


def _progress_words(now: UseCase) -> str:
    if not now.run:
        return ""
    words = f"{sums_words(now.sums)}; {duration_words(now.worked_s)} of work so far"
    return words + (f", about {duration_words(now.left_s)} left" if now.left_s else "")


def _interruption_words(count: int) -> str:
    what = "an interruption" if count == 1 else f"{count} interruptions"
    return f"Resumed after {what}."


def _percent(part: int, total: int) -> str:
    return f"{100 * part / total:.1f}%" if total else "0"
