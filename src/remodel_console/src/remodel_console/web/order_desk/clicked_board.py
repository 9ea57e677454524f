"""The drawing of a board whose wires and terminals are clicked."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from nicegui.element import Element
from nicegui.events import GenericEventArguments


class ClickedBoard(Element, component="../static/board.js"):
    """Shows a drawing, in which wires are highlighted, and reports clicks on wires."""

    def __init__(self, address: str, clicked: Callable[[Sequence[str]], object]) -> None:
        """Show the drawing of an address.

        Args:
            address: of the SVG of `remodel layout`.
            clicked: gets the name of a wire, or the names of all wires of a terminal.
        """
        super().__init__()
        self._props["address"] = address
        self._props["chosen"] = []

        def on_clicked(event: GenericEventArguments) -> None:
            clicked([str(name) for name in event.args])

        self.on("clicked", on_clicked)

    def highlight(self, wires: Sequence[str]) -> None:
        """Highlight these wires, and no others."""
        self._props["chosen"] = list(wires)
