"""What designs do not say of their terminals is filled in by the catalogue and reported."""

from dataclasses import replace
from pathlib import Path

import pytest

from remodel_production.core.catalogue import TerminalRule, reasons_by_wire
from remodel_production.core.imports.assembly import Connection, Device, assemble, with_access
from remodel_production.core.imports.values import Account, Imported
from remodel_production.core.production import (
    Component,
    Order,
    Role,
    Side,
    Terminal,
    TerminalRef,
)
from remodel_production.edge.design_files import read_catalogue

CATALOGUE = replace(
    read_catalogue(Path(__file__).parents[2] / "config" / "catalogue.yaml"),
    terminals=(
        TerminalRule(Role.DEVICE, "PT-*", 12.0, 0.003),
        TerminalRule(Role.DEVICE, "*", 40.0, 0.004, kind="*bus", wires=3),
        TerminalRule(Role.DEVICE, "*", 40.0, 0.004, wires=2),
        TerminalRule(Role.CONNECTOR, "*", 30.0, 0.0025),
    ),
)


def filled(component):
    order = Order("o", "", "", (component,), wires=(), notes=("before",))
    return with_access(Imported(order, Account("lines", 0, ("before",), ())), CATALOGUE)


@pytest.mark.parametrize(
    ("role", "part", "limit", "clearance"),
    [
        (Role.DEVICE, "PT-2.5", 12.0, 0.003),
        (Role.DEVICE, "", 40.0, 0.004),
        (Role.CONNECTOR, "PT-2.5", 30.0, 0.0025),
    ],
)
def test_the_first_rule_that_fits_fills_in_what_is_not_given(role, part, limit, clearance):
    ends = (Terminal("1", Side.TOP), Terminal("2", Side.BOTTOM))
    imported = filled(Component("K1", "", ends, role=role, part_number=part))
    found = imported.order.components[0].terminals
    assert [t.insertion_force_limit_n for t in found] == [limit, limit]
    assert [t.clearance_m for t in found] == [clearance, clearance]
    assert [t.approach for t in found] == [(0.0, -1.0, 0.0), (0.0, 1.0, 0.0)]
    assert imported.account.assumptions == imported.order.notes
    assert imported.account.assumptions[1] == (
        f"insertion force limit not given, {limit:g} N taken for {role.value}s (of 2 terminals)"
    )


def test_what_the_design_says_stays_and_is_no_assumption():
    said = Terminal(
        "1", Side.TOP, approach=(1.0, 0.0, 0.0), clearance_m=0.0, insertion_force_limit_n=5.0
    )
    imported = filled(Component("K1", "", (said,)))
    assert imported.order.components[0].terminals == (said,)
    assert imported.account.assumptions == ("before",)


def joined(*names, role=Role.DEVICE):
    """Return the import of wires from X:1, X:2, ... to the same point of each component."""
    connections = [
        Connection(
            TerminalRef("X", f"{n}{name}"), TerminalRef(name, "1"), "BK", 1.0, "", f"{name}{n}"
        )
        for name in names
        for n in range(1, 5)
    ]
    devices = [Device("X"), *(Device(name, role=role) for name in names)]
    made = assemble(devices, connections)
    order = Order("o", "", "", made.components, wires=made.wires)
    return with_access(Imported(order, Account("lines", 0, (), ())), CATALOGUE)


def test_wires_that_a_terminal_has_no_place_for_are_by_hand_and_in_the_account():
    imported = joined("K1", "PE bus")
    assert imported.account.assumptions[-2:] == (
        "K1:1 takes 2 wires, and has 4: it needs a bridge or a bar; by hand: K13, K14",
        "PE bus:1 takes 3 wires, and has 4: it needs a bridge or a bar; by hand: PE bus4",
    )
    reasons = reasons_by_wire(imported.order, CATALOGUE)
    assert list(reasons) == ["K13", "K14", "PE bus4"]
    assert reasons["K13"] == "K1:1 takes 2 wires, and has 4: it needs a bridge or a bar"


def test_a_joint_takes_all_its_wires():
    assert not reasons_by_wire(joined("S1", role=Role.JOINT).order, CATALOGUE)


def test_the_catalogues_terminals_take_two_wires_and_distribution_bars_many():
    catalogue = read_catalogue(Path(__file__).parents[2] / "config" / "catalogue.yaml")
    names = ("K1", "PE", "N-Schiene", "Interrupteur différentiel 2P 40A", "PE BUS", "PE bar")
    names = (*names, "barette_de_terre.elmt", "6 bar")  # the last one is a pressure switch
    takes = [catalogue.terminal_rule(Component(name, "", ())).wires for name in names]
    assert takes == [2, 30, 30, 12, 30, 30, 30, 2]
