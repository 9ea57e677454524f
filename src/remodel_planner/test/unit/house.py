"""A small order that tests run."""

from remodel_planner.core.production import Component, Order, Side, Terminal, TerminalRef, Wire

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
