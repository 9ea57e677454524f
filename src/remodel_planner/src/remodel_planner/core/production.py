"""Production knowledge: what an order is made of, whatever file it came from.

    Order ─ Component ─ Terminal
          └ Wire ─ a, b: TerminalRef

A terminal takes one wire end. Where a drawing joins several wires at one point, the importer makes
one terminal of each.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum


class Side(Enum):
    """The side of a component, as drawn, on which a terminal opens."""

    TOP = "top"
    BOTTOM = "bottom"


@dataclass(frozen=True)
class TerminalRef:
    """A terminal by name."""

    component: str
    terminal: str

    def __str__(self) -> str:
        """Return it as people write it."""
        return f"{self.component}:{self.terminal}"


@dataclass(frozen=True)
class Terminal:
    """A clamp that takes one wire end; `name` is unique in its component.

    Attributes:
        point: at which the drawing joins its wire, with the component's other clamps of that point;
            empty if the clamp is its only one.
    """

    name: str
    side: Side
    point: str = ""


@dataclass(frozen=True)
class Component:
    """A device mounted in the cabinet; `name` is unique in its order."""

    name: str
    kind: str
    terminals: tuple[Terminal, ...]

    def terminal(self, name: str) -> Terminal:
        """Return the terminal of that name; KeyError if there is none."""
        return {terminal.name: terminal for terminal in self.terminals}[name]


@dataclass(frozen=True)
class Wire:
    """A wire between two terminals; `name` is unique in its order.

    Attributes:
        colour: IEC 60757 code, such as "BU".
        section_mm2: [mm^2] of the conductor.
        source: where the design file draws it, such as "folio 2, line 1234".
    """

    name: str
    a: TerminalRef
    b: TerminalRef
    colour: str
    section_mm2: float
    source: str


@dataclass(frozen=True)
class Order:
    """What is to be wired: components and wires, in the design's order.

    Attributes:
        title: of the design.
        source: the design's file name.
        notes: what the import guessed and left out, a line each.
    """

    name: str
    title: str
    source: str
    components: tuple[Component, ...]
    wires: tuple[Wire, ...]
    notes: tuple[str, ...] = ()

    def first(self, count: int) -> Order:
        """Return the order cut down to its first wires and the components that they need."""
        wires = self.wires[:count]
        ends = {end for wire in wires for end in (wire.a, wire.b)}
        components = []
        for component in self.components:
            used = tuple(
                t for t in component.terminals if TerminalRef(component.name, t.name) in ends
            )
            if used:
                components.append(replace(component, terminals=used))
        return replace(self, components=tuple(components), wires=wires)
