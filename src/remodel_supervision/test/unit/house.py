"""A small order that tests run, and a cell to run it."""

from pathlib import Path

from remodel_production.core.board.board import board_of
from remodel_production.core.production import Component, Order, Side, Terminal, TerminalRef, Wire
from remodel_production.edge.database.cell_ownership import CellOwnership
from remodel_production.edge.design_files import read_catalogue
from remodel_tasks.core.orders.board_order import board_order

HOUSE = Order(
    "house",
    "",
    "house.qet",
    (
        Component("Q1", "fuse", (Terminal("B1", Side.BOTTOM), Terminal("B2", Side.BOTTOM))),
        Component("Q2", "relay", (Terminal("T1", Side.TOP), Terminal("T2", Side.TOP))),
    ),
    (
        Wire("W1", TerminalRef("Q1", "B1"), TerminalRef("Q2", "T1"), "BU", 1.5, "line 1"),
        Wire("W2", TerminalRef("Q1", "B2"), TerminalRef("Q2", "T2"), "BU", 1.5, "line 2"),
    ),
)
CATALOGUE = read_catalogue(
    Path(__file__).parents[3] / "remodel_production" / "config" / "catalogue.yaml"
)
BOARD = board_of(HOUSE, CATALOGUE)


def house_order(use_case):
    """Return the order of a use case, for one arm."""
    return board_order(BOARD, use_case, arms=1)


def owner_of(database, cell="cell", station="station"):
    """Acquire a cell, and return the token."""
    return CellOwnership(database, cell, station, f"supervisor at {station}", 60.0).acquire().token
