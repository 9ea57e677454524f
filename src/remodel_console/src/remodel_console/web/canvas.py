"""The drawing of a chart on a page: pan, zoom, light what is active, pick what is meant."""

from __future__ import annotations

from collections.abc import Callable

from nicegui.element import Element
from nicegui.events import GenericEventArguments

Pick = Callable[[str], None]


class Canvas(Element, component="static/canvas.js"):
    """Shows an SVG of `core.drawing`."""

    def __init__(self, label: str, on_pick: Pick | None = None) -> None:
        """Show nothing yet; `on_pick` gets the path of what is clicked, empty for the ground."""
        super().__init__()
        self._props["label"] = label
        self._active = ("", False)
        self._passed: frozenset[str] = frozenset()
        self.classes("canvas")
        if on_pick is not None:
            self.on("pick", lambda event: on_pick(_path_of(event)))

    def draw(self, svg: str, *, keeps_view: bool = False) -> None:
        """Show another drawing."""
        self.run_method("draw", svg, keeps_view)

    def light(self, active: str, passed: frozenset[str], asked: bool) -> None:
        """Light the path that is active, dimly those that were; `asked`: it waits for somebody.

        Only what has changed is sent, since a run may change state fifty times a second.
        """
        is_new_run = not self._passed <= passed
        new = passed if is_new_run else passed - self._passed
        self._passed = passed
        if (active, asked) != self._active or new or is_new_run:
            self._active = (active, asked)
            self.run_method("light", active, sorted(new), is_new_run, asked)

    def select(self, path: str) -> None:
        """Mark what is being edited."""
        self.run_method("select", path)

    def fit(self) -> None:
        """Show the whole drawing."""
        self.run_method("fit")


def _path_of(event: GenericEventArguments) -> str:
    path = event.args
    return path if isinstance(path, str) else ""
