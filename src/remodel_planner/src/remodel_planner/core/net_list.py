"""The net list of a product: what its design connects, beside what the cell says is connected."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

from remodel_production.core.production import TerminalRef, Wire


@dataclass(frozen=True)
class FoundEnd:
    """Where the cell has an end of a wire.

    Attributes:
        at: terminal that holds it; None: none does.
        is_fixed: whether its clamp is closed on the end.
    """

    at: TerminalRef | None = None
    is_fixed: bool = False


@dataclass(frozen=True)
class FoundWire:
    """A wire of which the cell has a piece.

    Attributes:
        a: its end a; the cell's ends a and b may be the design's b and a.
        duct_length_m: [m] of its planned route in ducts; 0: none, or not known.
        in_ducts: share of that length at which it lies below the ducts' rims.
    """

    a: FoundEnd
    b: FoundEnd
    duct_length_m: float = 0.0
    in_ducts: float = 0.0


class Verdict(Enum):
    """How a wire compares with the design."""

    AS_DESIGNED = "as designed"
    MISSING = "missing"
    WRONG = "wrong"


@dataclass(frozen=True)
class Connection:
    """A wire's two ends by the design, and where the cell has them.

    Which of its ends is called a does not matter: a layout may turn a wire round.

    Attributes:
        designed: the terminals of ends a and b.
        found: None if the cell has no piece of it.
    """

    wire: str
    designed: tuple[TerminalRef, TerminalRef]
    found: FoundWire | None

    @property
    def verdict(self) -> Verdict:
        """How it compares with the design: a single end in another terminal makes it wrong."""
        if self._wrong:
            return Verdict.WRONG
        return Verdict.MISSING if self._missing or self._loose else Verdict.AS_DESIGNED

    @property
    def difference(self) -> str:
        """What differs from the design, for a person; empty if nothing does."""
        if self.found is None:
            return "no piece of it in the cell"
        parts = []
        if self._wrong:
            parts.append(f"in {_listed(self._wrong)} instead of {_listed(self._missing)}")
        elif self._missing:
            parts.append(f"no end in {_listed(self._missing)}")
        if self._loose:
            parts.append(f"not fixed in {_listed(self._loose)}")
        return "; ".join(parts)

    @property
    def says(self) -> str:
        """Where the cell has its ends, for a person."""
        if self.found is None:
            return "nowhere"
        return " to ".join(str(end.at or "nowhere") for end in self._ends)

    @property
    def _ends(self) -> tuple[FoundEnd, ...]:
        return (self.found.a, self.found.b) if self.found is not None else ()

    @property
    def _held(self) -> Counter[TerminalRef]:
        return Counter(end.at for end in self._ends if end.at is not None)

    @property
    def _wrong(self) -> tuple[TerminalRef, ...]:
        """The terminals that hold ends which do not belong there."""
        return tuple((self._held - Counter(self.designed)).elements())

    @property
    def _missing(self) -> tuple[TerminalRef, ...]:
        """The terminals of the design that hold no end of it."""
        return tuple((Counter(self.designed) - self._held).elements())

    @property
    def _loose(self) -> tuple[TerminalRef, ...]:
        """The terminals that hold an end by an open clamp."""
        return tuple(end.at for end in self._ends if end.at is not None and not end.is_fixed)


def net_list(
    wires: Sequence[Wire], asked: Collection[str], found: Mapping[str, FoundWire]
) -> tuple[Connection, ...]:
    """Return the connections of the wires that were asked for or are in the cell."""
    shown = {*asked, *found}
    return tuple(
        Connection(wire.name, (wire.a, wire.b), found.get(wire.name))
        for wire in wires
        if wire.name in shown
    )


def share_in_ducts(nets: Sequence[Connection]) -> float | None:
    """Return at which share of their planned length in ducts all wires lie below the rims.

    None if none of the wires that the cell has is planned in a duct.
    """
    wires = [net.found for net in nets if net.found is not None]
    length_m = sum(wire.duct_length_m for wire in wires)
    inside_m = sum(wire.duct_length_m * wire.in_ducts for wire in wires)
    return inside_m / length_m if length_m else None


def _listed(terminals: Sequence[TerminalRef]) -> str:
    return " and ".join(map(str, terminals))
