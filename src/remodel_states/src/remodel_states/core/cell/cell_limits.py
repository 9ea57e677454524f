"""Which boards and wires a cell can wire: stated once, in its file.

The import of a design, the planner and the cell itself ask here, so that they give one answer.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from remodel_states.core.cell.within import within

_RANGE = {
    "type": "object",
    "required": ["least", "most"],
    "additionalProperties": False,
    "properties": {"least": {"type": "number", "minimum": 0}, "most": {"type": "number"}},
}
SCHEMA: Mapping[str, Any] = {
    "type": "object",
    "required": ["plate", "devices", "wire_length", "wire_diameter"],
    "additionalProperties": False,
    "properties": {
        "plate": {
            "type": "object",
            "required": ["x", "y"],
            "additionalProperties": False,
            "properties": {axis: {"type": "number", "exclusiveMinimum": 0} for axis in ("x", "y")},
        },
        "devices": {"type": "integer", "minimum": 1},
        "wire_length": _RANGE,
        "wire_diameter": _RANGE,
    },
}
"""JSON schema of what a cell's file states under `takes`; lengths in m."""


@dataclass(frozen=True)
class CellLimits:
    """What a cell takes.

    Attributes:
        cell: its name.
        plate: the greatest size of a plate along x and y of the panel's frame [m].
        devices: the greatest number on a plate.
        wire_length: least and greatest length from tip to tip [m].
        wire_diameter: least and greatest diameter over the insulation [m].
    """

    cell: str
    plate: tuple[float, float]
    devices: int
    wire_length: tuple[float, float]
    wire_diameter: tuple[float, float]

    @classmethod
    def stated(cls, cell: str, takes: Mapping[str, Any]) -> CellLimits:
        """Return the limits that a cell's file states, in the form of `SCHEMA`."""
        length, diameter = takes["wire_length"], takes["wire_diameter"]
        return cls(
            cell,
            (float(takes["plate"]["x"]), float(takes["plate"]["y"])),
            takes["devices"],
            (float(length["least"]), float(length["most"])),
            (float(diameter["least"]), float(diameter["most"])),
        )

    def about_board(self, size: tuple[float, float], devices: int) -> Iterator[str]:
        """Yield a sentence for each limit that a board exceeds.

        Args:
            size: of its plate along x and y of the panel's frame [m].
            devices: on it.
        """
        for axis, found, most in zip("xy", size, self.plate, strict=True):
            yield from within(
                f"the plate's size in {axis}",
                found,
                (0.1, most),
                remedy="a larger cell, or fewer devices on the plate" if found > most else "",
            )
        if devices > self.devices:
            yield (
                f"{devices} devices are on the plate, {devices - self.devices} too many; allowed: "
                f"{self.devices}: a cell without labels, or fewer devices on the plate"
            )

    def about_length(self, length: float) -> Iterator[str]:
        """Yield a sentence if a wire of a length [m] is too short or too long."""
        yield from within("length", length, self.wire_length)

    def about_diameter(self, diameter: float) -> Iterator[str]:
        """Yield a sentence if a wire of a diameter [m] is too thin or too thick."""
        least, most = self.wire_diameter
        yield from within("diameter", 1e3 * diameter, (1e3 * least, 1e3 * most), "mm")
