"""Translate a laid-out design of any size into remodel_msgs/Panel, for a cell with a magazine."""

from __future__ import annotations

from geometry_msgs.msg import Point, Pose2D, Vector3
from remodel_msgs.msg import Channel, Component, Panel, Terminal, Wire

from remodel_planning.core.orders.work_order import WorkOrder

# Where all parts are presented: the magazine beside the board.
MAGAZINE = "magazine"


def board_message(order: WorkOrder) -> Panel:
    """Return the message for the tasks of an order, in the board's frame [m]."""
    terminals: dict[str, list[Terminal]] = {name: [] for name in order.components}
    short = {}
    for terminal in order.terminals:
        short[terminal.name] = terminal.name.removeprefix(f"{terminal.component}:")
        x, y = (value / 1e3 for value in terminal.position_mm)
        mouth = Terminal(id=short[terminal.name], mouth=Point(x, y, 0.0))
        terminals[terminal.component].append(mouth)
    corners = [terminal.position_mm for terminal in order.terminals]
    component_of = {terminal.name: terminal.component for terminal in order.terminals}
    wires = [
        Wire(
            id=task.name,
            a_component=component_of[a],
            a_terminal=short[a],
            b_component=component_of[b],
            b_terminal=short[b],
            colour=str(task.characteristics.get("colour", "")),
            section=float(task.characteristics.get("section_mm2", 0.0)),
            length=task.routes[0].length_m,
        )
        for task in order.tasks
        for a, b in [task.terminals]
    ]
    return Panel(
        name=order.name,
        size=Vector3(*(max(side, default=0) / 1e3 for side in zip(*corners, strict=True)), 0.0),
        components=[
            Component(id=name, pose=Pose2D(), terminals=found) for name, found in terminals.items()
        ],
        channels=[Channel(id=MAGAZINE)],
        wires=wires,
    )
