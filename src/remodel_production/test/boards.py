"""Orders of boards: the example of a harness, and wires between devices that a test names."""

from pathlib import Path

from wire_lists import CATALOGUE

from remodel_production.core.imports.kbl import import_kbl
from remodel_production.core.production import (
    Component,
    Mount,
    Order,
    Side,
    Terminal,
    TerminalRef,
    Wire,
)


def loom():
    file = Path(__file__).parent / "unit" / "designs" / "loom.kbl"
    return import_kbl(file.read_bytes(), "loom", file.name, CATALOGUE).order


def order(*pairs, section_mm2=2.5, outside=()):
    """Return an order of wires given as ("Q1:B1", "Q2:T1"); B opens to the bottom."""
    terminals, wires = {}, []
    for number, pair in enumerate(pairs, start=1):
        refs = [TerminalRef(*text.split(":")) for text in pair]
        for ref in refs:
            side = Side.TOP if ref.terminal.startswith("T") else Side.BOTTOM
            terminals.setdefault(ref.component, []).append(Terminal(ref.terminal, side))
        wires.append(Wire(f"W{number}", *refs, "BK", section_mm2, "test"))
    components = tuple(
        Component(name, "", tuple(used), Mount.OUTSIDE if name in outside else Mount.PLATE)
        for name, used in terminals.items()
    )
    return Order("test", "", "", components, wires=tuple(wires))
