"""Placed wires, as a cell stores them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from remodel_work.geometry import Array
from remodel_work.panel import WireEnd
from remodel_work.routes import TerminalKey


@dataclass(frozen=True, eq=False)
class ParkedWire:
    """A wire that stays where it is.

    Attributes:
        nodes: (n, 3) from tip to tip [m], world frame.
        fixed: the ends that closed clamps held when it was parked.
    """

    nodes: Array
    fixed: frozenset[WireEnd]


@dataclass(frozen=True, eq=False)
class PlacedWires:
    """All that lies on a panel beside the live wire.

    Attributes:
        parked: by the wire's name.
        occupied: the wire end that each terminal holds.
    """

    parked: Mapping[str, ParkedWire] = field(default_factory=dict)
    occupied: Mapping[TerminalKey, tuple[str, WireEnd]] = field(default_factory=dict)
