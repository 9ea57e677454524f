"""What is uncertain about a cell, and what a seed makes of it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from zlib import crc32

import msgspec
import numpy as np


class Uncertain(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A quantity that is drawn about what the model has.

    Attributes:
        unit: such as "m"; empty: a factor.
        meaning: for a person.
        spread: standard deviation, in that unit.
        at_least: values below count as this one.
        at_most: values above count as this one.
        origin: where the numbers come from.
    """

    unit: str
    meaning: str
    spread: float
    at_least: float
    at_most: float
    origin: str

    def __post_init__(self) -> None:
        """Refuse what cannot be drawn."""
        if not self.spread >= 0.0:
            raise ValueError(f"spread is {self.spread}; allowed: 0 or more")
        if not self.at_least <= self.middle <= self.at_most:
            raise ValueError(
                f"at_least {self.at_least} and at_most {self.at_most} are not on both sides of "
                f"{self.middle:g}, which the model has"
            )

    @property
    def middle(self) -> float:
        """What the model has."""
        return 0.0 if self.unit else 1.0

    def draw(self, random: np.random.Generator) -> float:
        """Return a value."""
        value = self.middle + self.spread * random.standard_normal()
        return float(min(max(value, self.at_least), self.at_most))


# The quantities that a plant can be made to differ in.
QUANTITIES = (
    "wire_stiffness",
    "wire_friction",
    "wire_curvature",
    "pad_friction",
    "grip_force",
    "light",
    "force_noise",
    "camera_position",
    "camera_turn",
    "device_position",
    "device_turn",
)


@dataclass(frozen=True)
class Shift:
    """By which something is beside its place [m], and turned [rad]."""

    dx: float
    dy: float
    turn: float


@dataclass(frozen=True)
class Variation:
    """How one cell differs from its model.

    Attributes:
        factors: of the quantities without a unit, by name.
        force_noise: standard deviation of a reading of a wrist's force, each axis [N].
        cameras: of the overhead cameras, by name.
        devices: of the components, by name.
    """

    factors: Mapping[str, float]
    force_noise: float
    cameras: Mapping[str, Shift]
    devices: Mapping[str, Shift]


def vary(
    table: Mapping[str, Uncertain], seed: int, cameras: Collection[str], devices: Collection[str]
) -> Variation:
    """Return how the cell of a seed differs from its model.

    Each quantity has a stream of chance of its own, by its name and that of the device: a quantity
    that is added to the table changes none of the others.
    """

    def drawn(quantity: str, of: str = "") -> float:
        stream = crc32(f"{quantity} {of}".encode())
        return table[quantity].draw(np.random.default_rng([seed, stream]))

    def shifts(kind: str, names: Collection[str]) -> Iterator[tuple[str, Shift]]:
        for name in names:
            dx, dy = (drawn(f"{kind}_position", f"{name} {axis}") for axis in "xy")
            yield name, Shift(dx, dy, drawn(f"{kind}_turn", name))

    return Variation(
        {name: drawn(name) for name, each in table.items() if not each.unit},
        drawn("force_noise"),
        dict(shifts("camera", cameras)),
        dict(shifts("device", devices)),
    )
