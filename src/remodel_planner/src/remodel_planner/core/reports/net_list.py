"""The net list of a product: what its design connects, beside what the cell says is connected."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from remodel_production.core.production import TerminalRef, Wire


@dataclass(frozen=True)
class Connection:
    """A wire's two ends by the design, and where the cell has them.

    Attributes:
        wire: its name.
        designed: the terminals of ends a and b.
        found: the terminals that hold them, "component/terminal"; empty: none. The cell's ends a
            and b may be the design's b and a.
        is_fixed: whether both are held by closed clamps.
    """

    wire: str
    designed: tuple[TerminalRef, TerminalRef]
    found: tuple[str, str]
    is_fixed: bool

    @property
    def is_right(self) -> bool:
        """Whether the wire connects what the design says, and stays there.

        Which of its ends is called a does not matter: a layout may turn a wire round.
        """
        wanted = [f"{ref.component}/{ref.terminal}" for ref in self.designed]
        return self.is_fixed and sorted(self.found) == sorted(wanted)

    @property
    def says(self) -> str:
        """What the cell says, for a person."""
        ends = " to ".join(at.replace("/", ":") or "nowhere" for at in self.found)
        return ends if self.is_fixed else f"{ends}, not fixed"


def net_list(
    wires: Sequence[Wire], found: Mapping[str, tuple[str, str, bool]]
) -> tuple[Connection, ...]:
    """Return the connections of the wires of which the cell has a piece.

    Args:
        wires: of the order.
        found: where the cell has the ends a and b of a wire, and whether both are fixed, by name.
    """
    return tuple(
        Connection(wire.name, (wire.a, wire.b), found[wire.name][:2], found[wire.name][2])
        for wire in wires
        if wire.name in found
    )
