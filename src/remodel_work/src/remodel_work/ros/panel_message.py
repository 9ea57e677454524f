"""Panels from and to ROS messages, and from files.

Every error of a message's content is found here or in the rules of panels.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import rospy
import yaml
from genpy.message import fill_message_args
from geometry_msgs.msg import Point, Pose2D, Vector3
from remodel_msgs.msg import Channel as ChannelMsg
from remodel_msgs.msg import Clip as ClipMsg
from remodel_msgs.msg import Component as ComponentMsg
from remodel_msgs.msg import Connector as ConnectorMsg
from remodel_msgs.msg import Duct as DuctMsg
from remodel_msgs.msg import Panel as PanelMsg
from remodel_msgs.msg import Rail as RailMsg
from remodel_msgs.msg import Terminal as TerminalMsg
from remodel_msgs.msg import Wire as WireMsg

from remodel_states.core.wires import PROPERTIES, MaterialError, WireMaterials
from remodel_work.errors import PanelError
from remodel_work.panel import (
    Channel,
    Component,
    Connector,
    Duct,
    Panel,
    PanelClip,
    PanelTerminal,
    PanelWire,
    Rail,
    WireEnd,
)


def read_panel(path: Path, materials: WireMaterials) -> Panel:
    """Read a panel from a YAML file, in the text form of remodel_msgs/Panel itself.

    Raises:
        OSError, yaml.YAMLError, genpy.MessageException: when the file is no such text.
        PanelError: when a wire's material is not known, or a connector's end is none.
    """
    message = PanelMsg()
    fill_message_args(message, [yaml.safe_load(path.read_text())])
    return panel_from(message, materials)


def panel_from(message: PanelMsg, materials: WireMaterials) -> Panel:
    """Return the panel of a message, its wires' materials completed from the table.

    What is calculated and not in the table is logged.

    Raises:
        PanelError: when a wire's material is not known, or a connector's end is none.
    """
    problems, wires = [], []
    calculated: dict[str, list[str]] = {}
    for wire in message.wires:
        try:
            wires.append(_wire_from(wire, materials, calculated))
        except MaterialError as error:
            problems.append(f"wire {wire.id!r}: {error}")
        except PanelError as error:
            problems += [f"wire {wire.id!r}: {problem}" for problem in error.problems]
    if problems:
        raise PanelError(message.name, tuple(problems))
    for what, ids in calculated.items():
        rospy.loginfo(
            "panel %r: %s, for %d wires, such as %s", message.name, what, len(ids), ids[0]
        )
    return Panel(
        name=message.name,
        size=(message.size.x, message.size.y, message.size.z),
        components=tuple(_component_from(c) for c in message.components),
        channels=tuple(
            Channel(id=c.id, x=c.x, width=c.width, y_min=c.y_min, y_max=c.y_max)
            for c in message.channels
        ),
        wires=tuple(wires),
        clips=tuple(
            PanelClip(
                id=c.id,
                pose=_pose2d(c.pose),
                wire_diameter=c.wire_diameter,
                height=c.height,
                length=c.length,
                retention_force=c.retention_force,
            )
            for c in message.clips
        ),
        ducts=tuple(
            Duct(
                id=d.id,
                pose=_pose2d(d.pose),
                length=d.length,
                width=d.width,
                height=d.height,
                slot_pitch=d.slot_pitch,
                slot_width=d.slot_width,
                slot_bottom=d.slot_bottom,
            )
            for d in message.ducts
        ),
        serial=message.serial,
        rails=tuple(
            Rail(id=r.id, pose=_pose2d(r.pose), length=r.length, width=r.width, height=r.height)
            for r in message.rails
        ),
    )


def _pose2d(message: Pose2D) -> tuple[float, float, float]:
    return message.x, message.y, message.theta


def _point(message: Point) -> tuple[float, float, float]:
    return message.x, message.y, message.z


def _unless_all_0(values: tuple[float, float, float]) -> tuple[float, float, float] | None:
    return values if any(values) else None


def _wire_from(
    message: object, materials: WireMaterials, calculated: dict[str, list[str]]
) -> PanelWire:
    """Return a wire, and add to what is calculated of wires, by what it is."""
    values = {name: getattr(message, name) for name in PanelWire.__dataclass_fields__}
    values["connectors"] = tuple(_connector_from(c) for c in message.connectors)
    values["route"] = tuple(_point(point) for point in message.route)
    values["ducts"] = tuple(message.ducts)
    values["presented_at"] = _unless_all_0(_pose2d(message.presented_at))
    unsaid = [name for name in PROPERTIES if values[name] == 0]
    if unsaid:
        material = materials.find(message.construction, message.section)
        if origin := materials.origin(message.construction, message.section):
            what = f"properties of wires of {message.section:g} mm2 {origin}"
            calculated.setdefault(what, []).append(message.id)
        values.update({name: getattr(material, name) for name in unsaid})
    return PanelWire(**values)


def _connector_from(message: object) -> Connector:
    values = {name: getattr(message, name) for name in Connector.__dataclass_fields__}
    if message.end not in ("a", "b"):
        raise PanelError("", (f"connector {message.id!r}: end is {message.end!r}; allowed: a, b",))
    return Connector(**{**values, "end": WireEnd(message.end)})


def _component_from(message: object) -> Component:
    size = message.size
    terminals = tuple(
        PanelTerminal(
            id=t.id,
            mouth=_point(t.mouth),
            insertion_yaw=t.insertion_yaw,
            bore=t.bore,
            depth=t.depth,
            chamfer=t.chamfer,
            retention_force=t.retention_force,
            ways=max(1, t.ways),
            pitch=t.pitch,
            screw=_unless_all_0(_point(t.screw)),
            insertion_force=t.insertion_force,
        )
        for t in message.terminals
    )
    return Component(
        id=message.id,
        kind=message.kind,
        marker_id=message.marker_id,
        marker_size=message.marker_size,
        pose=_pose2d(message.pose),
        size=(size.x, size.y, size.z),
        terminals=terminals,
    )


def panel_message(panel: Panel) -> PanelMsg:
    """Return a panel as a message, from which `panel_from` reads it again."""
    message = PanelMsg(name=panel.name, serial=panel.serial, size=Vector3(*panel.size))
    message.components = [
        ComponentMsg(
            id=component.id,
            kind=component.kind,
            marker_id=component.marker_id,
            marker_size=component.marker_size,
            pose=Pose2D(*component.pose),
            size=Vector3(*component.size),
            terminals=[_terminal_message(terminal) for terminal in component.terminals],
        )
        for component in panel.components
    ]
    message.channels = [_filled(ChannelMsg(), channel) for channel in panel.channels]
    message.wires = [_wire_message(wire) for wire in panel.wires]
    message.clips = [_filled(ClipMsg(), clip) for clip in panel.clips]
    message.ducts = [_filled(DuctMsg(), duct) for duct in panel.ducts]
    message.rails = [_filled(RailMsg(), rail) for rail in panel.rails]
    return message


def _filled(message: Any, part: Any) -> Any:  # noqa: ANN401
    """Fill a message from the fields of the same names."""
    for name in message.__slots__:
        value = getattr(part, name)
        setattr(message, name, Pose2D(*value) if name == "pose" else value)
    return message


def _terminal_message(terminal: PanelTerminal) -> TerminalMsg:
    message = TerminalMsg()
    for name in message.__slots__:
        value = getattr(terminal, name)
        if name in ("mouth", "screw"):
            value = Point(*(value or (0.0, 0.0, 0.0)))
        setattr(message, name, value)
    return message


def _wire_message(wire: PanelWire) -> WireMsg:
    message = WireMsg()
    # The construction is not kept: what follows from it is.
    for name in set(message.__slots__) - {"construction"}:
        value = getattr(wire, name)
        if name == "connectors":
            value = [
                ConnectorMsg(**{**vars(connector), "end": connector.end.value})
                for connector in value
            ]
        elif name == "route":
            value = [Point(*point) for point in value]
        elif name == "presented_at":
            value = Pose2D(*(value or (0.0, 0.0, 0.0)))
        elif name == "ducts":
            value = list(value)
        setattr(message, name, value)
    return message
