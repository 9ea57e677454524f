r"""Where connectors stand at the end of a bundle of a harness: in a row, open towards the bundle.

┌──┐ 1                 Seen from its wires, each row has its first connector on the left, and
│X1│ 2 ──\   /── ┌──┐  so has each connector its first cavity. So wires between equal cavities
└──┘ 3 ──  \ /   │X2│  of two rows that face each other meet halfway.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from remodel_production.core.production import Component, TerminalRef

Point = tuple[float, float]


@dataclass(frozen=True)
class Row:
    """A row of connectors [m]: along it, what is at the left as seen from the wires is negative.

    Attributes:
        widths: of the connectors, by name.
        middles: of the connectors, by name.
        cavities: where each cavity is.
    """

    widths: Mapping[str, float]
    middles: Mapping[str, float]
    cavities: Mapping[TerminalRef, float]


def row_of(components: Sequence[Component], pitch: float, gap: float) -> Row:
    """Return connectors beside each other, with a pitch of their cavities and gaps between [m]."""
    widths = {c.name: max(1, len(c.terminals)) * pitch for c in components}
    left = -(sum(widths.values()) + gap * (len(components) - 1)) / 2
    middles: dict[str, float] = {}
    cavities: dict[TerminalRef, float] = {}
    for component in components:
        middle = left + widths[component.name] / 2
        middles[component.name] = middle
        for index, terminal in enumerate(component.terminals):
            aside = (index - (len(component.terminals) - 1) / 2) * pitch
            cavities[TerminalRef(component.name, terminal.name)] = middle + aside
        left += widths[component.name] + gap
    return Row(widths, middles, cavities)


@dataclass(frozen=True)
class Stand:
    """The end of a bundle, at which a row of connectors stands.

    Attributes:
        end: [m] of the bundle, in the plane of the openings.
        heading: in which the bundle leaves [rad].
    """

    end: Point
    heading: float

    @property
    def turn(self) -> float:
        """The angle by which a connector is turned that opens to the bottom of the board [rad]."""
        return math.remainder(self.heading + math.pi / 2, 2 * math.pi)

    def place(self, along: float, behind: float) -> Point:
        """Return what is so far along the row, and so far behind the openings [m]."""
        out_x, out_y = math.cos(self.heading), math.sin(self.heading)
        x, y = self.end
        # Seen from the bundle, the row goes on to the right.
        return (
            x - behind * out_x + along * out_y,
            y - behind * out_y - along * out_x,
        )
