"""What an import read, assumed and left out, with places in the file."""

from __future__ import annotations

from dataclasses import dataclass

from remodel_production.core.production import Order

# What the line of a colour that is not known says, for which the default is taken.
UNKNOWN_COLOUR = "is no known colour"


@dataclass(frozen=True)
class LeftOut:
    """Something of the file that is not in the order, and why."""

    source: str
    reason: str

    def __str__(self) -> str:
        """Return the line for a person."""
        return f"{self.source}: left out, {self.reason}"


@dataclass(frozen=True)
class Account:
    """What an import read, assumed and left out.

    Attributes:
        unit: what the format calls a connection, in the plural.
        connections: number of connections in the file. Each became a wire, was joined with others
            into wires, or was left out.
        joined: number of connections that were joined into wires.
        wires_joined: number of wires that those became.
        assumptions: one line for each thing that the file does not say.
        left_out: the other connections.
        ignored: what is no connection, and is not in the order.
        unused_columns: of a list, and sheets of a workbook, that the order has nothing of.
    """

    unit: str
    connections: int
    assumptions: tuple[str, ...]
    left_out: tuple[LeftOut, ...]
    ignored: tuple[LeftOut, ...] = ()
    joined: int = 0
    wires_joined: int = 0
    unused_columns: tuple[LeftOut, ...] = ()

    @property
    def unknown_colours(self) -> tuple[str, ...]:
        """The assumptions for which a colour that is not known got the default."""
        return tuple(line for line in self.assumptions if UNKNOWN_COLOUR in line)

    @property
    def notes(self) -> tuple[str, ...]:
        """Assumptions and what was left out, a line each."""
        omitted = (*self.left_out, *self.ignored, *self.unused_columns)
        return (*self.assumptions, *map(str, omitted))


@dataclass(frozen=True)
class Imported:
    """An order, and the account of how it came about."""

    order: Order
    account: Account
