"""The panel computed for an order."""

import math
from itertools import pairwise
from pathlib import Path

import pytest

from remodel_production.core.panel.panel_layout import PanelRules, lay_out
from remodel_production.core.production import Component, Order, Side, Terminal, TerminalRef, Wire
from remodel_production.edge.catalogue_file import read_catalogue
from remodel_production.errors import CatalogueError, LayoutError

CATALOGUE = read_catalogue(Path(__file__).parents[2] / "config" / "catalogue.yaml")
RULES = PanelRules()


def order(*pairs, section=2.5):
    """Return an order of wires given as ("Q1:B1", "Q2:T1"); B opens to the bottom."""
    terminals, wires = {}, []
    for number, pair in enumerate(pairs, start=1):
        refs = [TerminalRef(*text.split(":")) for text in pair]
        for ref in refs:
            side = Side.TOP if ref.terminal.startswith("T") else Side.BOTTOM
            terminals.setdefault(ref.component, []).append(Terminal(ref.terminal, side))
        wires.append(Wire(f"W{number}", *refs, "BK", section, "test"))
    components = tuple(Component(name, "", tuple(used)) for name, used in terminals.items())
    return Order("test", "", "test.qet", components, wires=tuple(wires))


def placed(layout):
    return {component.component.name: component for component in layout.components}


def test_bottom_to_top_stands_one_row_below():
    components = placed(lay_out(order(("Q1:B1", "Q2:T1"), ("Q2:B1", "Q3:T1")), CATALOGUE, RULES))
    assert components["Q1"].x - components["Q2"].x == pytest.approx(RULES.row_pitch)
    assert components["Q2"].x - components["Q3"].x == pytest.approx(RULES.row_pitch)


def test_equal_sides_stand_in_one_row():
    components = placed(lay_out(order(("Q1:T1", "Q2:T1"), ("Q2:B1", "Q3:B1")), CATALOGUE, RULES))
    assert len({component.x for component in components.values()}) == 1


def test_both_ends_of_a_wire_open_into_its_channel():
    layout = lay_out(order(("Q1:B1", "Q2:T1"), ("Q2:B1", "Q3:T1")), CATALOGUE, RULES)
    components = placed(layout)
    channels = {channel.name: channel for channel in layout.channels}
    for cut in layout.wires:
        channel = channels[cut.channel]
        for end in (cut.wire.a, cut.wire.b):
            component = components[end.component]
            terminal = next(t for t in component.terminals if t.name == end.terminal)
            mouth = component.x + terminal.x
            assert abs(mouth - channel.x) == pytest.approx(channel.width / 2)
            into = math.copysign(1, math.cos(terminal.insertion_yaw))
            assert into == math.copysign(1, mouth - channel.x)


def test_components_do_not_overlap_and_terminals_keep_their_pitch():
    pairs = [(f"Q1:B{n}", f"D{n}:T1") for n in range(1, 7)]
    components = sorted(lay_out(order(*pairs), CATALOGUE, RULES).components, key=lambda c: c.y)
    for first in components:
        ys = sorted(terminal.y for terminal in first.terminals)
        assert all(b - a >= RULES.terminal_pitch - 1e-9 for a, b in pairwise(ys))
        assert all(abs(y) + RULES.component_margin <= first.width / 2 + 1e-9 for y in ys)
        for second in components:
            if first is not second and first.x == second.x:
                gap = abs(first.y - second.y) - (first.width + second.width) / 2
                assert gap >= RULES.component_gap - 1e-9


def test_a_wire_is_long_enough_for_its_way_and_its_loose_end_stays_in_reach():
    pairs = [(f"Q1:B{n}", f"D{n}:T1") for n in range(1, 7)]
    for cut in lay_out(order(*pairs), CATALOGUE, RULES).wires:
        way = abs(cut.first_y - cut.second_y)
        assert cut.length >= max(RULES.shortest_wire, way + RULES.wire_slack)
        onwards = 1 if cut.second_y >= cut.first_y else -1
        assert cut.length + onwards * cut.first_y <= RULES.reach_y
        assert {cut.first, cut.second} == {cut.wire.a, cut.wire.b}


def test_wires_that_contradict_each_other_are_named():
    with pytest.raises(LayoutError, match=r"wire W2 \(Q1:B2 to Q2:B1, test\)"):
        lay_out(order(("Q1:B1", "Q2:T1"), ("Q1:B2", "Q2:B1")), CATALOGUE, RULES)


def test_too_many_rows_are_refused():
    pairs = [(f"Q{n}:B1", f"Q{n + 1}:T1") for n in range(1, 5)]
    with pytest.raises(LayoutError, match="need 5 rows"):
        lay_out(order(*pairs), CATALOGUE, RULES)


def test_a_row_wider_than_the_panel_is_refused():
    pairs = [(f"Q1:B{n}", f"D{n}:T1") for n in range(1, 60)]
    with pytest.raises(LayoutError, match=r"row 1 needs 0\.95 m for Q1"):
        lay_out(order(*pairs), CATALOGUE, RULES)


def test_a_section_that_the_catalogue_lacks_is_refused():
    with pytest.raises(CatalogueError, match=r"no wire of 3 mm2; it has 0\.75, 1, 1\.5"):
        lay_out(order(("Q1:B1", "Q2:T1"), section=3.0), CATALOGUE, RULES)
