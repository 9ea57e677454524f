"""Translate the panel of a board into remodel_msgs/Panel, under the names of an order's tasks."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import fields

import yaml
from genpy import Message
from geometry_msgs.msg import Point, Pose2D, Vector3
from remodel_msgs.msg import Clip, Component, Duct, Rail, Terminal, Wire
from remodel_msgs.msg import Panel as PanelMsg

from remodel_production.core.board.panel import (
    Panel,
    PanelClip,
    PanelDevice,
    PanelDuct,
    PanelOpening,
    PanelRail,
    PanelWire,
)
from remodel_production.core.production import TerminalRef
from remodel_states.core.wires import PROPERTIES
from remodel_tasks.core.orders.work_order import WorkOrder

# Columns of a panel's text.
_TEXT_WIDTH = 150


def board_message(panel: Panel, order: WorkOrder, by_hand: Collection[str] = ()) -> PanelMsg:
    """Return the message for a panel. It has no channels: a magazine presents the wires.

    Args:
        panel: with all wires.
        order: whose tasks they are, in their order.
        by_hand: names of the tasks that no robot does: of these the cell gets the terminals alone.
    """
    message = PanelMsg(
        name=panel.name,
        size=Vector3(*panel.size),
        clips=[_clip(clip) for clip in panel.clips],
        ducts=[Duct(**_named(duct)) for duct in panel.ducts],
        rails=[Rail(**_named(rail)) for rail in panel.rails],
    )
    short = _short_names(order)
    terminals = {}
    for wire, task in zip(panel.wires, order.tasks, strict=True):
        a, b = (short[name] for name in task.terminals)
        terminals.update({wire.a: a, wire.b: b})
        if task.name not in by_hand:
            message.wires.append(_wire(wire, task.name, a, b))
    message.components = [_component(device, terminals) for device in panel.devices]
    return message


def panel_text(message: PanelMsg) -> str:
    """Return the YAML text of a panel's message, without the fields that are 0 or empty."""
    title = (
        f"# The panel of order {message.name}, as `remodel layout` writes it: remodel_msgs/Panel\n"
        "# in the text form of the message; metres, radians, panel frame.\n"
    )
    return title + yaml.dump(
        _set_fields(message),
        Dumper=_PanelDumper,
        sort_keys=False,
        allow_unicode=True,
        default_flow_style=None,
        width=_TEXT_WIDTH,
    )


class _Entry(dict[str, object]):
    """A part of the panel that is written on a line."""


class _PanelDumper(yaml.SafeDumper):
    """Writes YAML."""

    def represent_entry(self, entry: _Entry) -> yaml.MappingNode:
        """Return the node of an entry."""
        return self.represent_mapping("tag:yaml.org,2002:map", entry, flow_style=True)


_PanelDumper.add_representer(_Entry, _PanelDumper.represent_entry)


def _set_fields(value: object) -> object:
    """Return the fields of a message that are not 0 or empty; a point or a pose as a list."""
    if isinstance(value, Point | Pose2D | Vector3):
        numbers = [getattr(value, name) for name in value.__slots__]
        return numbers if any(numbers) else []
    if isinstance(value, Message):
        found = ((name, _set_fields(getattr(value, name))) for name in value.__slots__)
        said = {name: item for name, item in found if item not in (0, "", [], {})}
        return said if isinstance(value, PanelMsg | Component) else _Entry(said)
    if isinstance(value, list):
        return [_set_fields(item) for item in value]
    return value


def _short_names(order: WorkOrder) -> dict[str, str]:
    """Return the names of terminals without those of their components."""
    return {t.name: t.name.removeprefix(f"{t.component}:") for t in order.terminals}


def _component(device: PanelDevice, names: Mapping[TerminalRef, str]) -> Component:
    return Component(
        id=device.name,
        kind=device.kind,
        marker_id=device.label,
        marker_size=device.label_size,
        pose=Pose2D(*device.place, device.yaw),
        size=Vector3(*device.size),
        terminals=[
            _terminal(opening, names[TerminalRef(device.name, opening.name)])
            for opening in device.openings
        ],
    )


def _terminal(opening: PanelOpening, name: str) -> Terminal:
    return Terminal(
        id=name,
        mouth=Point(*opening.place),
        insertion_yaw=opening.insertion_yaw,
        bore=opening.bore,
        depth=opening.depth,
        chamfer=opening.chamfer,
        retention_force=opening.retention,
        insertion_force=opening.insertion,
        screw=Point(*(opening.screw or (0.0, 0.0, 0.0))),
    )


def _clip(clip: PanelClip) -> Clip:
    values = _named(clip)
    return Clip(retention_force=values.pop("retention"), **values)


def _named(item: PanelClip | PanelDuct | PanelRail) -> dict[str, object]:
    """Return the fields of an item under their names in its message."""
    values = {field.name: getattr(item, field.name) for field in fields(item)}
    values.update(id=values.pop("name"), pose=Pose2D(*item.pose))
    return values


def _wire(wire: PanelWire, name: str, a_terminal: str, b_terminal: str) -> Wire:
    message = Wire(
        id=name,
        a_component=wire.a.component,
        a_terminal=a_terminal,
        b_component=wire.b.component,
        b_terminal=b_terminal,
        colour=wire.colour,
        section=wire.section_mm2,
        length=wire.length,
        route=[Point(*point) for point in wire.route],
        ducts=list(wire.ducts),
    )
    for name in PROPERTIES if wire.material is not None else ():
        setattr(message, name, getattr(wire.material, name))
    return message
