"""The wires that a person places, to be ticked off."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import ui

from remodel_console.core.use_case.use_case import HandWire, hand_words

Tick = Callable[[str, bool], Awaitable[object]]


class HandList:
    """Shows a row for each wire by hand, with what a person needs to place it."""

    def __init__(self, tick: Tick, *, is_operator: bool) -> None:
        """Build an empty list; `tick` gets a wire's name, and whether it is placed."""
        self._tick = tick
        self._is_operator = is_operator
        self._wires: tuple[HandWire, ...] = ()
        self._ticked: frozenset[str] = frozenset()
        self._boxes: dict[str, ui.checkbox] = {}
        with ui.element("div").classes("by-hand wide") as self._area:
            self._head = ui.label().classes("heading").props('role="status"')
            self._rows = ui.element("div").classes("wide")

    def show(self, wires: tuple[HandWire, ...], ticked: frozenset[str]) -> None:
        """Show wires, and which of them are placed."""
        self._area.set_visibility(bool(wires))
        if wires != self._wires:
            self._wires = wires
            self._rows.clear()
            with self._rows:
                self._boxes = {wire.name: self._row(wire) for wire in wires}
        self._ticked = ticked
        for name, box in self._boxes.items():
            box.set_value(name in ticked)
        self._head.text = hand_words(wires, ticked)

    async def _on_click(self, name: str, *, is_placed: bool) -> None:
        if is_placed != (name in self._ticked):  # else the box shows what another page has ticked
            await self._tick(name, is_placed)

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
