"""Between the cell's values and ROS messages.

Every error of a message's content is found here or in core.
"""

from __future__ import annotations

from pathlib import Path

import rospy
import yaml
from genpy import Message
from genpy.message import fill_message_args
from geometry_msgs.msg import Point, Pose2D, PoseStamped, Quaternion
from remodel_msgs.msg import CableObservation
from remodel_msgs.msg import Panel as PanelMsg
from remodel_msgs.msg import WireTruth as WireTruthMsg
from sensor_msgs.msg import CameraInfo

from remodel_sim.physics.truth import WireTruth
from remodel_skills.abilities.detect_cable import CableDetected
from remodel_skills.goal_checks import WORLD
from remodel_skills.robot_context import AbilityResult
from remodel_states.core.wires.wire_materials import PROPERTIES, MaterialError, WireMaterials
from remodel_work.camera import View
from remodel_work.errors import PanelError
from remodel_work.geometry import Pose
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
from remodel_work.robot.arm import ToolPose


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


def pose_stamped(pose: Pose) -> PoseStamped:
    """Return a pose as a message in the world frame."""
    message = PoseStamped()
    message.header.frame_id = WORLD
    message.header.stamp = rospy.Time.now()
    message.pose.position = Point(*(float(v) for v in pose.position))
    message.pose.orientation = Quaternion(*(float(v) for v in pose.quaternion))
    return message


def observation(detected: CableDetected, cable_id: str) -> CableObservation:
    """Return what DetectCable saw as a message."""
    tips = [pose_stamped(Pose.level(*(float(v) for v in t.tip), t.out_yaw)) for t in detected.tips]
    return CableObservation(
        cable_id=cable_id,
        centreline=[Point(*(float(v) for v in point)) for point in detected.centreline],
        tips=tips,
        length=detected.length,
        confidence=detected.confidence,
        truncated=detected.truncated,
    )


def result_fields(found: AbilityResult, goal: Message) -> dict[str, object]:
    """Return what an ability found out as fields of its result."""
    if isinstance(found, CableDetected):
        return {"observation": observation(found, goal.cable_id)}
    values = {name: value for name, value in vars(found).items() if name != "message"}
    return {name: _field(value) for name, value in values.items() if value is not None}


def _field(value: object) -> object:
    if isinstance(value, Pose):
        return pose_stamped(value)
    if isinstance(value, ToolPose):
        return pose_stamped(Pose.level(value.x, value.y, value.z, value.yaw))
    return value


def truth_message(truth: WireTruth) -> WireTruthMsg:
    """Return the truth about a wire as a message."""
    a, b = truth.a, truth.b
    return WireTruthMsg(
        wire_id=truth.wire_id,
        placed=truth.placed,
        a_at=a.at,
        b_at=b.at,
        a_depth=a.depth,
        b_depth=b.depth,
        a_fixed=a.fixed,
        b_fixed=b.fixed,
        duct_length=truth.duct_length,
        in_ducts=truth.in_ducts,
    )


def camera_info(view: View, frame_id: str, stamp: rospy.Time) -> CameraInfo:
    """Return a camera's intrinsics as a message."""
    lens = view.lens
    f, (cx, cy) = lens.focal_px, lens.centre_px
    message = CameraInfo()
    message.header.frame_id, message.header.stamp = frame_id, stamp
    message.width, message.height = lens.width, lens.height
    message.distortion_model, message.D = "plumb_bob", [0.0] * 5
    message.K = [f, 0, cx, 0, f, cy, 0, 0, 1]
    message.R = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    message.P = [f, 0, cx, 0, 0, f, cy, 0, 0, 0, 1, 0]
    return message
