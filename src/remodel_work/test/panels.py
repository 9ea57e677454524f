"""Panels for tests: small ones, and the examples of the cells."""

import dataclasses
import math
from functools import cache
from pathlib import Path

from remodel_states.edge.exported_tables import read_wire_materials
from remodel_work.panel import Channel, Component, Panel, PanelTerminal, PanelWire
from remodel_work.ros.panel_message import read_panel

EXAMPLES = Path(__file__).parents[2] / "remodel_sim/config"
ROW_X = 0.080


@cache
def example(name):
    """An example panel of the simulated cells: "household" is a whole cabinet."""
    return read_panel(EXAMPLES / f"{name}.yaml", read_wire_materials())


def moved_onto(panel, size, x, y):
    """A panel whose everything stands on a plate of another size, so far from its middle [m]."""

    def moved(pose):
        return (round(pose[0] + x, 6), round(pose[1] + y, 6), *pose[2:])

    parts = {
        name: tuple(
            dataclasses.replace(each, pose=moved(each.pose)) for each in getattr(panel, name)
        )
        for name in ("components", "clips", "ducts", "rails")
    }
    wires = tuple(
        dataclasses.replace(wire, route=tuple(map(moved, wire.route))) for wire in panel.wires
    )
    name = f"{panel.name}_on_a_large_plate"
    return dataclasses.replace(panel, name=name, size=(*size, panel.size[2]), wires=wires, **parts)


def with_first(panel, parts, **changes):
    """A panel whose first wire, component or rail, by the name of its field, is changed."""
    first, *others = getattr(panel, parts)
    changed = dataclasses.replace(first, **changes)
    return dataclasses.replace(panel, **{parts: (changed, *others)})


def with_first_terminal(panel, **changes):
    """A panel whose first component's first terminal is changed."""
    first, *others = panel.components[0].terminals
    changed = dataclasses.replace(first, **changes)
    return with_first(panel, "components", terminals=(changed, *others))


def with_springs(panel, insertion_force):
    """A panel whose terminals are spring clamps of this insertion force [N]."""

    def sprung(terminal):
        return dataclasses.replace(terminal, insertion_force=insertion_force)

    components = tuple(
        dataclasses.replace(each, terminals=tuple(map(sprung, each.terminals)))
        for each in panel.components
    )
    return dataclasses.replace(panel, components=components)


def component(name, marker, x, y, side, terminals=2, bore=0.0038):
    """A component whose openings are on the side of its row's channel: +1 near row, -1 far row."""
    yaw = math.pi if side > 0 else 0.0
    places = [(i - (terminals - 1) / 2) * 0.018 for i in range(terminals)]
    return Component(
        id=name,
        kind="test component",
        marker_id=marker,
        marker_size=0.022,
        pose=(x, y, 0.0),
        size=(0.050, 0.045, 0.045),
        terminals=tuple(
            PanelTerminal(
                id=str(i + 1),
                mouth=(side * 0.025, place, 0.022),
                insertion_yaw=yaw,
                bore=bore,
                depth=0.014,
                chamfer=0.0015,
                retention_force=80.0,
            )
            for i, place in enumerate(places)
        ),
    )


def wire(name, a, b, length, **changes):
    """A soft 1.5 mm^2 wire."""
    soft = PanelWire(
        name,
        *a,
        *b,
        colour="BU",
        section=1.5,
        diameter=0.003,
        length=length,
        linear_density=0.020,
        bending_stiffness=1e-3,
        ferrule_length=0.012,
        torsional_stiffness=0.8e-3,
        friction=0.5,
        rest_curvature=0.4,
        yield_curvature=8.0,
        hardening=0.3,
    )
    return dataclasses.replace(soft, **changes)


def panel(**changes):
    """Two rows, one channel, two wires."""
    plain = Panel(
        name="test",
        size=(0.40, 0.70, 0.003),
        components=(
            component("X1", 1, -ROW_X, -0.12, side=1),
            component("X2", 2, ROW_X, 0.12, side=-1),
            component("X3", 3, ROW_X, -0.12, side=-1),
            component("X4", 4, -ROW_X, 0.12, side=1),
        ),
        channels=(Channel(id="A", x=0.0, width=0.110, y_min=-0.30, y_max=0.30),),
        wires=(
            wire("W1", ("X1", "1"), ("X2", "1"), 0.48),
            wire("W2", ("X3", "1"), ("X2", "2"), 0.49, colour="BN"),
        ),
    )
    return dataclasses.replace(plain, **changes)
