"""Which wires a terminal has no place for: it takes one, or two in a twin ferrule; a bar many.

A design joins any number of wires at a point, and the import gives each a clamp of its own; the
catalogue says how many the terminals of a component really take. The wires beyond that need a
bridge, a bar or another terminal, which a person chooses.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

from remodel_production.core.catalogue import Catalogue
from remodel_production.core.production import Component, Order, Role, TerminalRef
from remodel_run.whole_task import counted


@dataclass(frozen=True)
class FullTerminal:
    """A point of a component at which more wires meet than it takes.

    Attributes:
        takes: how many wires it takes.
        wires: names of all that meet there.
        beyond: names of those that it has no place for.
    """

    name: TerminalRef
    takes: int
    wires: tuple[str, ...]
    beyond: tuple[str, ...]

    @property
    def reason(self) -> str:
        """Why the wires beyond are by hand."""
        takes = counted(self.takes, "wire")
        return f"{self.name} takes {takes}, and has {len(self.wires)}: it needs a bridge or a bar"


def full_terminals(order: Order, catalogue: Catalogue) -> Iterator[FullTerminal]:
    """Yield the points at which more wires meet than the catalogue allows, but those of joints.

    The wires of a point are counted in the order of its clamps.
    """
    wire_at = {end: wire.name for wire in order.wires for end in (wire.a, wire.b)}
    for component in order.components:
        if component.role is Role.JOINT:
            continue
        takes = catalogue.terminal_rule(component).wires
        for point, ends in _points(component).items():
            wires = tuple(wire_at[end] for end in ends if end in wire_at)
            if len(wires) > takes:
                yield FullTerminal(
                    TerminalRef(component.name, point), takes, wires, beyond=wires[takes:]
                )


def reasons_by_wire(order: Order, catalogue: Catalogue) -> dict[str, str]:
    """Return why the wires that some terminal has no place for are by hand, by their names."""
    reasons: dict[str, list[str]] = defaultdict(list)
    for full in full_terminals(order, catalogue):
        for wire in full.beyond:
            reasons[wire].append(full.reason)
    return {wire: "; ".join(lines) for wire, lines in reasons.items()}


def _points(component: Component) -> dict[str, list[TerminalRef]]:
    """Return the clamps of each point of a component."""
    points: dict[str, list[TerminalRef]] = defaultdict(list)
    for terminal in component.terminals:
        point = terminal.point or terminal.name
        points[point].append(TerminalRef(component.name, terminal.name))
    return points
