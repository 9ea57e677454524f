"""A dense board for tests: two rows of terminals 8 mm apart."""

import math

from panels import wire

from remodel_work.panel import Channel, Component, Panel, PanelTerminal

ROW_X = 0.110
DEPTH, HEIGHT = 0.090, 0.045
PITCH = 0.008
H07V_2_5 = {
    "section": 2.5,
    "diameter": 0.0037,
    "linear_density": 0.032,
    "bending_stiffness": 1.6e-3,
    "torsional_stiffness": 1.2e-3,
}


def device(name, marker, x, y, terminals=10, sides="bt"):
    """A device with `terminals` openings on both sides, b1 ... towards the robot, t1 ... away."""
    opening = {"bore": 0.0045, "depth": 0.014, "chamfer": 0.0014, "retention_force": 80.0}
    openings = []
    for letter in sides:
        side = -1 if letter == "b" else 1
        for i in range(terminals):
            place = (side * DEPTH / 2, (i - (terminals - 1) / 2) * PITCH, 0.022)
            yaw = math.pi if side > 0 else 0.0
            openings.append(PanelTerminal(f"{letter}{i + 1}", place, yaw, **opening))
    return Component(
        id=name,
        kind="terminal block",
        marker_id=marker,
        marker_size=0.024,
        pose=(x, y, 0.0),
        size=(DEPTH, terminals * PITCH, HEIGHT),
        terminals=tuple(openings),
    )


def dense_panel(wires=()):
    """Two rows of two devices of ten terminals on each side."""
    y = 0.045
    return Panel(
        name="dense",
        size=(0.52, 0.80, 0.003),
        components=(
            device("N1", 1, -ROW_X, -y),
            device("N2", 2, -ROW_X, y),
            device("F1", 3, ROW_X, -y, sides="b"),
            device("F2", 4, ROW_X, y, sides="b"),
        ),
        channels=tuple(
            Channel(id, x, 0.130, -0.30, 0.30) for id, x in (("A", -0.22), ("B", 0.0), ("C", 0.22))
        ),
        wires=tuple(wires),
    )


def board_wire(name, a, b, length, **changes):
    """A wire of 2.5 mm2."""
    return wire(name, a, b, length, **{**H07V_2_5, **changes})
