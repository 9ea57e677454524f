"""Small panels for tests."""

import dataclasses
import math

from remodel_sim.core.workpiece.panel import Channel, Component, Panel, Terminal, Wire

ROW_X = 0.080


def component(name, marker, x, y, side, terminals=2, bore=0.0038):
    """A component whose openings are on the side of its row's channel: +1 near row, -1 far row."""
    yaw = math.pi if side > 0 else 0.0
    places = [(i - (terminals - 1) / 2) * 0.018 for i in range(terminals)]
    return Component(
        name,
        "test component",
        marker,
        0.022,
        (x, y, 0.0),
        (0.050, 0.045, 0.045),
        tuple(
            Terminal(str(i + 1), (side * 0.025, place, 0.022), yaw, bore, 0.014, 0.0015, 80.0)
            for i, place in enumerate(places)
        ),
    )


def wire(name, a, b, length, **changes):
    """A soft 1.5 mm^2 wire."""
    soft = Wire(
        name, *a, *b, "BU", 1.5, 0.003, length, 0.020, 1e-3, 0.012, 0.8e-3, 0.5, 0.4, 8.0, 0.3
    )
    return dataclasses.replace(soft, **changes)


def panel(**changes):
    """Two rows, one channel, two wires."""
    plain = Panel(
        "test",
        (0.40, 0.70, 0.003),
        (
            component("X1", 1, -ROW_X, -0.12, 1),
            component("X2", 2, ROW_X, 0.12, -1),
            component("X3", 3, ROW_X, -0.12, -1),
            component("X4", 4, -ROW_X, 0.12, 1),
        ),
        (Channel("A", 0.0, 0.110, -0.30, 0.30),),
        (
            wire("W1", ("X1", "1"), ("X2", "1"), 0.48),
            wire("W2", ("X3", "1"), ("X2", "2"), 0.49, colour="BN"),
        ),
    )
    return dataclasses.replace(plain, **changes)
