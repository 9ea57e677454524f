"""The drawing of a chart on a page: pan, zoom, light what is active, pick what is meant."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from typing import NamedTuple, Protocol, TypeAlias

from nicegui.element import Element
from nicegui.events import GenericEventArguments

from remodel_console.core.editor.graph import Json

Places: TypeAlias = dict[str, list[int]]


class Picker(Protocol):
    """Takes what a person clicks in a drawing."""

    def pick(self, paths: tuple[str, ...]) -> None:
        """Select the states of these paths; none: the chart."""


class Editor(Picker, Protocol):
    """Takes what a person does in a drawing."""

    async def connect(self, path: str, event: str, target: str) -> None:
        """Lead an outcome of a state to a target beside it."""

    async def move(self, scope: str, states: Places, outcomes: Places) -> None:
        """Keep where what is in a container was put, by name."""

    async def drop(self, what: str, scope: str, at: list[int] | None) -> None:
        """Add an entry of the library to a container; at a place, if what is in it has places."""


_LOST_S = (
    2.0  # after which a page that has not painted, or cannot report it, is sent the change again
)


class _Lit(NamedTuple):
    """What is lit: the active path, those that were, and whether it waits for an operator."""

    active: str = ""
    passed: frozenset[str] = frozenset()
    asked: bool = False


class Canvas(Element, component="static/canvas.js"):
    """Shows a graph of `core.editor.graph`."""

    def __init__(
        self,
        label: str,
        picker: Picker | None = None,
        editor: Editor | None = None,
    ) -> None:
        """Show nothing yet.

        Args:
            label: what the drawing is.
            picker: takes what a person clicks in the drawing.
            editor: takes what is moved, connected and dropped; None: nothing can be.
        """
        super().__init__()
        self._props["label"] = label
        self._props["editable"] = editor is not None
        self._marked: dict[str, list[str]] = {}
        self._wanted = self._sent = _Lit()
        self._sent_s: float | None = None  # None once the page has painted what was sent
        self.classes("canvas")
        self.on("painted", self._on_painted)
        self._picks = 0  # of the page, as far as they have arrived
        if picker is not None:
            self._picker = picker
            self.on("pick", self._on_pick)
        if editor is not None:
            self.on("connect", lambda event: editor.connect(**event.args))
            self.on("moved", lambda event: editor.move(**event.args))
            self.on("dropped", lambda event: editor.drop(**event.args))

    def draw(self, graph: Json, *, keeps_view: bool = False) -> None:
        """Show another graph."""
        self.run_method("draw", graph, keeps_view)

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

    def _on_pick(self, event: GenericEventArguments) -> None:
        self._picks = int(event.args["number"])
        self._picker.pick(tuple(map(str, event.args["paths"])))

    def select(self, paths: Sequence[str]) -> None:
        """Mark what is being edited, unless a later pick of the page is under way."""
        self.run_method("select", list(paths), True, self._picks)

    def mark(self, name: str, paths: Iterable[str]) -> None:
        """Mark the states of these paths with a class of the drawing's style, and no others."""
        wanted = sorted(paths)
        if wanted != self._marked.get(name, []):
            self._marked[name] = wanted
            self.run_method("keepMark", name, wanted)

    def show_values(self, path: str, values: Sequence[tuple[str, str]]) -> None:
        """Show values beside a state; of an empty path, none."""
        self.run_method("showValues", path, [list(value) for value in values])

    def fit(self) -> None:
        """Show the whole drawing."""
        self.run_method("fit")
