"""The wires that a person places, to be ticked off."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import ui

from remodel_console.core.use_case.use_case import hand_words
from remodel_run.progress import HandWire

Tick = Callable[[str, str, bool], Awaitable[bool]]


class HandList:
    """Shows a row for each wire by hand, with what a person needs to place it."""

    def __init__(self, tick: Tick, *, is_operator: bool) -> None:
        """Build an empty list; `tick` gets product, wire, and whether it is placed."""
        self._tick = tick
        self._is_operator = is_operator
        self._wires: tuple[HandWire, ...] = ()
        self._product = ""
        self._ticked: frozenset[str] = frozenset()
        self._boxes: dict[str, ui.checkbox] = {}
        with ui.element("div").classes("by-hand wide") as self._area:
            self._head = ui.label().classes("heading").props('role="status"')
            self._rows = ui.element("div").classes("wide")

    def show(
        self,
        wires: tuple[HandWire, ...],
        ticked: frozenset[str],
        product: str,
        *,
        is_before: bool,
    ) -> None:
        """Show the wires of a product, and which of them are placed.

        `is_before`: it is not the product that is built now, so that its serial number is shown.
        """
        self._area.set_visibility(bool(wires))
        self._product = product
        if wires != self._wires:
            self._wires = wires
            self._rows.clear()
            with self._rows:
                self._boxes = {wire.name: self._row(wire) for wire in wires}
        self._ticked = ticked
        self._show_ticks()
        words = hand_words(wires, ticked)
        self._head.text = f"{product}, built before. {words}" if is_before else words

    def _show_ticks(self) -> None:
        for name, box in self._boxes.items():
            box.set_value(name in self._ticked)

    async def _on_click(self, name: str, *, is_placed: bool) -> None:
        if is_placed == (name in self._ticked):
            return  # the box shows what another page has ticked
        if not await self._tick(self._product, name, is_placed) and not self._area.is_deleted:
            self._show_ticks()

    def _row(self, wire: HandWire) -> ui.checkbox:
        """Add a row."""
        with ui.element("div").classes("hand-wire"):
            marker = f", marker {wire.marker}" if wire.marker not in ("", wire.name) else ""
            box = ui.checkbox(f"{wire.name}{marker}").props("dense")
            box.set_enabled(self._is_operator)
            box.on_value_change(lambda: self._on_click(wire.name, is_placed=bool(box.value)))
            ui.label(wire.words).classes("line")
            ui.label(f"By hand, because {wire.reason}").classes("line soft")
        return box
