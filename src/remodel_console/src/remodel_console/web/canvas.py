"""The drawing of a chart on a page: pan, zoom, light what is active, pick what is meant."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

from nicegui.element import Element
from nicegui.events import GenericEventArguments

Pick = Callable[[str], None]
_LOST_S = (
    2.0  # after which a page that has not painted, or cannot report it, is sent the change again
)


class _Lit(NamedTuple):
    """What is lit: the active path, those that were, and whether it waits for an operator."""

    active: str = ""
    passed: frozenset[str] = frozenset()
    asked: bool = False


class Canvas(Element, component="static/canvas.js"):
    """Shows an SVG of `core.drawing`."""

    def __init__(self, label: str, on_pick: Pick | None = None) -> None:
        """Show nothing yet; `on_pick` gets the path of what is clicked, empty for the ground."""
        super().__init__()
        self._props["label"] = label
        self._wanted = self._sent = _Lit()
        self._sent_s: float | None = None  # None once the page has painted what was sent
        self.classes("canvas")
        self.on("painted", self._on_painted)
        if on_pick is not None:
            self.on("pick", lambda event: on_pick(_path_of(event)))

    def draw(self, svg: str, *, keeps_view: bool = False) -> None:
        """Show another drawing."""
        self.run_method("draw", svg, keeps_view)

    def light(self, active: str, passed: frozenset[str], asked: bool) -> None:
        """Light the path that is active, dimly those that were; `asked`: it waits for an operator.

        A run may change state fifty times a second. So only what has changed is sent, and not
        before the page has painted the last: a slow page shows fewer states, not late ones.
        """
        self._wanted = _Lit(active, passed, asked)
        if self._sent_s is None or time.monotonic() - self._sent_s > _LOST_S:
            self._send()

    def _send(self) -> None:
        wanted, sent = self._wanted, self._sent
        if wanted == sent:
            return
        is_new_run = not sent.passed <= wanted.passed
        new = wanted.passed if is_new_run else wanted.passed - sent.passed
        self._sent, self._sent_s = wanted, time.monotonic()
        self.run_method("light", wanted.active, sorted(new), is_new_run, wanted.asked)

    def _on_painted(self) -> None:
        self._sent_s = None
        self._send()

    def select(self, path: str) -> None:
        """Mark what is being edited."""
        self.run_method("select", path)

    def fit(self) -> None:
        """Show the whole drawing."""
        self.run_method("fit")


def _path_of(event: GenericEventArguments) -> str:
    path = event.args
    return path if isinstance(path, str) else ""
