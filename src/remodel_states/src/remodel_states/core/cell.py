"""Which boards and wires a cell can wire: stated once, in its file.

The import of a design, the planner and the cell itself ask here, so that they give one answer.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise
from typing import Any, NamedTuple

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


# Which wires the robots of a cell can place along their routes; planner and cell both ask here


# A wall that is no longer is a post of a fork: it holds no wire bent [m].
FORK_LENGTH_M = 0.020
# A slot lets a wire through that is thinner by this, the least that was tried (docs/simulation.md,
# "Wires led into ducts") [m].
SLOT_PLAY_M = 0.0014
# A wire that is let down into forks is so much longer than the line between its openings: shorter,
# its second end does not come in front of its opening; longer, it bows out between the forks [m].
SPARE_M = (0.028, 0.060)
STRAIGHT_RAD = math.radians(5.0)
# Rounding of lengths and places [m].
_TOLERANCE_M = 1e-6


class Objection(NamedTuple):
    """Why no robot places a wire: what several wires may have in common, and a sentence."""

    kind: str
    sentence: str


@dataclass(frozen=True)
class Passage:
    """A duct, or the posts of a fork, on a wire's route.

    Attributes:
        name: of it.
        length: of its walls [m].
        slot_pitch: between the slots of its walls [m]; 0: they are solid.
        slot_width: of these slots [m].
    """

    name: str
    length: float
    slot_pitch: float
    slot_width: float

    @property
    def is_fork(self) -> bool:
        """Whether it is no trough, but the posts of a fork: walls too short to hold a wire bent."""
        return not self.slot_pitch and self.length <= FORK_LENGTH_M


def objections(
    takes: CellLimits,
    length: float,
    diameter: float,
    route: Sequence[Sequence[float]],
    passages: Sequence[Passage],
) -> Iterator[Objection]:
    """Yield why the robots of a cell cannot place a wire; nothing: they can.

    Args:
        takes: the limits of the cell.
        length: of the wire, from tip to tip [m].
        diameter: over its insulation [m].
        route: x and y, and what follows, of points [m], from opening to opening; empty: free.
        passages: the ducts and forks on the route.
    """
    kinds = ("shorter than {0:g} m", "longer than {1:g} m")
    for sentence in takes.about_length(length):
        yield Objection(_kind(kinds, length, takes.wire_length), sentence)
    kinds = ("thinner than {0:g} mm", "thicker than {1:g} mm")
    limits_mm = (1e3 * takes.wire_diameter[0], 1e3 * takes.wire_diameter[1])
    for sentence in takes.about_diameter(diameter):
        yield Objection(_kind(kinds, 1e3 * diameter, limits_mm), sentence)
    along = sum(math.dist(p[:2], q[:2]) for p, q in pairwise(route))
    if length < along:
        yield Objection(
            "shorter than their routes",
            f"it is {length:.2f} m long and its route {along:.2f} m, {along - length:.2f} m too "
            "short: cut it to the route's length and both bends",
        )
    if any(passage.is_fork for passage in passages):
        yield from _about_forks(length, along, route)
    slots: dict[float, list[str]] = {}
    for passage in dict.fromkeys(passages):
        if passage.slot_pitch:
            slots.setdefault(passage.slot_width, []).append(repr(passage.name))
    for width, names in slots.items():
        lack = diameter + SLOT_PLAY_M - width
        if lack > _TOLERANCE_M:
            yield Objection(
                "thicker than slots",
                f"{diameter * 1e3:.1f} mm thick, and the slots of duct{'s' * (len(names) > 1)} "
                f"{', '.join(names)} are {width * 1e3:.1f} mm wide, {lack * 1e3:.1f} mm too "
                f"narrow: slots of {(diameter + SLOT_PLAY_M) * 1e3:.1f} mm",
            )


def _kind(kinds: tuple[str, str], found: float, limits: tuple[float, float]) -> str:
    return kinds[found > limits[1]].format(*limits)


def _about_forks(
    length: float, along: float, route: Sequence[Sequence[float]]
) -> Iterator[Objection]:
    """Yield why a wire with a route of a length [m] cannot be let down into its forks."""
    headings = [math.atan2(q[1] - p[1], q[0] - p[0]) for p, q in pairwise(route)]
    turn = max((abs(math.remainder(b - a, math.tau)) for a, b in pairwise(headings)), default=0.0)
    if turn > STRAIGHT_RAD:
        yield Objection(
            "not straight through forks",
            f"its route turns by {math.degrees(turn):.0f} deg; the cell lets wires down into forks "
            "in a straight line only: connectors that face each other",
        )
        return
    least, most = SPARE_M
    if not least - _TOLERANCE_M <= length - along <= most + _TOLERANCE_M:
        yield Objection(
            "not cut for their forks",
            f"it is {length:.3f} m long and its openings are {along:.3f} m apart, through forks; "
            f"allowed: {least * 1e3:.0f} to {most * 1e3:.0f} mm more: cut it to "
            f"{along + least:.3f} to {along + most:.3f} m",
        )


# Which components of a board would stand in each other; import and cell both ask here


class Footprint(NamedTuple):
    """The rectangle along the panel's axes that a component takes [m]."""

    low: tuple[float, float]
    high: tuple[float, float]


def footprint(middle: tuple[float, float], size: tuple[float, float], yaw: float) -> Footprint:
    """Return what a component takes.

    Args:
        middle: of it, in the panel's frame [m].
        size: along its own x and y [m].
        yaw: by which it is turned [rad].
    """
    cos, sin = abs(math.cos(yaw)), abs(math.sin(yaw))
    half_x, half_y = (cos * size[0] + sin * size[1]) / 2, (sin * size[0] + cos * size[1]) / 2
    (x, y) = middle
    return Footprint((x - half_x, y - half_y), (x + half_x, y + half_y))


def overlaps(footprints: Mapping[str, Footprint]) -> Iterator[str]:
    """Yield a sentence for each two components that overlap."""
    ranked = sorted(footprints.items(), key=lambda item: item[1])
    for index, (name, one) in enumerate(ranked, start=1):
        for other_name, other in islice(ranked, index, None):
            if other.low[0] >= one.high[0] - _TOLERANCE_M:
                break
            by = min(
                min(one.high[axis], other.high[axis]) - max(one.low[axis], other.low[axis])
                for axis in (0, 1)
            )
            if by > _TOLERANCE_M:
                first, second = sorted((name, other_name))
                yield (
                    f"components {first!r} and {second!r} overlap by {by * 1e3:.1f} mm: places "
                    "farther apart"
                )


# What is out of its limits: how it is worded


# Rounding of decimal numbers, in any unit.
TOLERANCE = 1e-9


def within(
    what: str, value: float, limits: tuple[float, float], unit: str = "m", remedy: str = ""
) -> Iterator[str]:
    """Yield a sentence if a value is out of its limits: by how much, and what would change it."""
    low, high = limits
    if low - TOLERANCE <= value <= high + TOLERANCE:
        return
    off, too = (low - value, "little") if value < low else (value - high, "much")
    yield (
        f"{what} is {value:.4g} {unit}, {off:.3g} {unit} too {too}; allowed: {low:.4g} to "
        f"{high:.4g} {unit}".replace("  ", " ")
        .replace(" ;", ";")
        .rstrip()
        + (f": {remedy}" if remedy else "")
    )
