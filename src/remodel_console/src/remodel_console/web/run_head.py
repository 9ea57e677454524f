"""The head of the overview: the order, how far it is, and the buttons for all of it."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from remodel_console.core.use_case import Phase, TaskPhase, UseCase, duration_words

Button = Callable[..., ui.button]
_STYLES = {Phase.ASKING: "asking", Phase.PAUSED: "paused"}


class RunHead:
    """Shows a run; its elements stay while it changes, so that clicks are not lost."""

    def __init__(self, button: Button, pause: Callable, resume: Callable, stop: Callable) -> None:
        """Build it; `button` makes buttons that only operators can press."""
        with ui.row().classes("headline"):
            self._title = ui.label().classes("title")
            self._phase = ui.label()
            self._link = ui.link().classes("soft")
        with ui.element("div").classes("progress wide").props('role="img"') as self._bar:
            self._done = ui.element("div").classes("part done")
            self._aside = ui.element("div").classes("part aside")
        self._progress = ui.label().classes("soft")
        self._message = ui.label()
        self._interruptions = ui.label().classes("soft")
        with ui.row().classes("controls"):
            self._resume = button("Go on", resume, icon="play_arrow")
            self._pause = button("Pause", pause, icon="pause", look="quiet")
            button("Stop", stop, icon="stop", look="stop")

    def show(self, now: UseCase) -> None:
        """Show what may have changed."""
        self._title.text = now.order
        self._phase.text = now.phase.words
        self._phase.classes(replace=f"state {_STYLES.get(now.phase, 'running')}")
        self._link.text = f"run {now.run}" if now.run else ""
        self._link.props(f'href="/replay?run={now.run}"')
        done, aside = now.count(TaskPhase.DONE), now.count(TaskPhase.SET_ASIDE)
        words = _progress_words(now, done, aside)
        self._progress.text = words
        self._bar.props(f'aria-label="{words}"')
        self._done.style(f"width: {_percent(done, len(now.tasks))}")
        self._aside.style(f"width: {_percent(aside, len(now.tasks))}")
        self._message.text = now.message
        self._message.set_visibility(bool(now.message) and now.phase is not Phase.ASKING)
        self._interruptions.text = _interruption_words(now.interruptions)
        self._interruptions.set_visibility(now.interruptions > 0)
        self._resume.set_visibility(now.phase is Phase.PAUSED)
        self._pause.set_visibility(now.phase is not Phase.PAUSED)


def _progress_words(now: UseCase, done: int, aside: int) -> str:
    words = f"{done} of {len(now.tasks)} tasks done"
    words += f", {aside} set aside" if aside else ""
    words += f"; {duration_words(now.told_s - now.started_s)} so far"
    return words + (f", about {duration_words(now.left_s)} left" if now.left_s else "")


def _interruption_words(count: int) -> str:
    what = "an interruption" if count == 1 else f"{count} interruptions"
    return f"It went on after {what}."


def _percent(part: int, total: int) -> str:
    return f"{100 * part / total:.1f}%" if total else "0"
