"""What designs do not say of their terminals is filled in by the catalogue and reported."""

from dataclasses import replace
from pathlib import Path

import pytest

from remodel_production.core.catalogue import TerminalRule
from remodel_production.core.imports.shared.account import Account, Imported
from remodel_production.core.imports.terminal_access import with_access
from remodel_production.core.production import Component, Order, Role, Side, Terminal
from remodel_production.edge.catalogue_file import read_catalogue

CATALOGUE = replace(
    read_catalogue(Path(__file__).parents[2] / "config" / "catalogue.yaml"),
    terminals=(
        TerminalRule(Role.DEVICE, "PT-*", 12.0, 0.003),
        TerminalRule(Role.DEVICE, "*", 40.0, 0.004),
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
