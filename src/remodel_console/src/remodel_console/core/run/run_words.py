"""What a page says about the behavior that runs."""

from __future__ import annotations

from remodel_console.core.run.run_view import Phase, RunView


def state_words(view: RunView, *, waits: bool) -> str:
    """Return the state of the run; `waits`: for a value, a decision or a confirmation."""
    if view.phase is Phase.AWAY:
        return "no engine"
    if view.is_starting:
        return f"starting: {view.waits_for}" if view.waits_for else "starting"
    if view.phase is Phase.IDLE:
        return "idle"
    if waits or view.asked is not None:
        return "waiting for you"
    if view.is_paused:
        return "paused"
    if view.held is not None:
        return "locked"
    return "running" if view.is_supervised else "running unattended"


def count_words(view: RunView) -> str:
    """Return how many states the run has entered."""
    return f"{view.entries} state{'s' * (view.entries != 1)} entered"


def path_words(path: str) -> str:
    """Return the path of a state as a person reads it."""
    return " / ".join(filter(None, path.split("/")))
