"""The cell in three dimensions, and what is known of the wire that is chosen in it."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from remodel_console.scene import Meshes, Scene
from remodel_console.web.cell.cell_view import CellView

Words = Callable[[str], tuple[str, ...]]


class CellPanel:
    """Shows a cell; a wire is chosen by a click on it, or from a list."""

    def __init__(self, scene: Scene, meshes: Meshes, words: Words) -> None:
        """Build it; it is hidden as long as the cell does not describe itself.

        Args:
            scene: the cell.
            meshes: of its robots.
            words: returns lines about a wire.
        """
        self._scene = scene
        self._words_of = words
        self._wires: tuple[str, ...] = ()
        self._words: tuple[str, ...] = ()
        with ui.element("div").classes("cell-panel wide") as self._area:
            self._view = CellView(scene, meshes, self._choose)
            with ui.row().classes("cell-wire"):
                self._wire = ui.select([], label="Wire", clearable=True)
                self._wire.props("outlined dense").on_value_change(self._show_words)
                self._facts = ui.element("div").classes("wire-facts").props('role="status"')
        self._area.set_visibility(False)

    @property
    def is_available(self) -> bool:
        """Return whether the cell can be drawn here."""
        return self._view.is_available

    def set_shown(self, is_shown: bool) -> None:
        """Stop while the page is in the background, and go on."""
        self._view.set_shown(is_shown)

    def show(self) -> None:
        """Show the wires that there are now, and what is known of the one that is chosen."""
        self._area.set_visibility(self.is_available)
        wires = tuple(sorted(self._scene.now.wires))
        if wires != self._wires:
            self._wires = wires
            value = self._wire.value if self._wire.value in wires else None
            self._wire.set_options(list(wires), value=value)
        self._show_words()

    def _choose(self, wire: str) -> None:
        if wire in self._wires:
            self._wire.value = wire

    def _show_words(self) -> None:
        words = self._words_of(str(self._wire.value)) if self._wire.value else ()
        if words == self._words:
            return
        self._words = words
        self._facts.clear()
        with self._facts:
            for text in words:
                ui.label(text)
