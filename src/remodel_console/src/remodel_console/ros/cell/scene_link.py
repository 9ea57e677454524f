"""The cell's robots, wires and components, followed while a page shows or a run records them.

Robots come from the parameter `cell/robots` (description as URDF, prefix of the joints), their
places from /tf_static, their joints from /joint_states; wires and components are the markers of
`cell/markers`. While the scene is not wanted, nothing is subscribed to, so the cell sends nothing.
"""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import rospy
from geometry_msgs.msg import Point, Quaternion, Transform
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from remodel_console.core.cell.cell_state import CellState, Line, Robot, Solid
from remodel_console.core.cell.robot_model import read_robot
from remodel_console.ros import topics
from remodel_console.scene import Scene

_POLL_S = 0.2
_DESCRIBED_EVERY_S = 2.0  # between two checks whether another cell describes itself
_WIRE = "wire/"  # begins the namespace of a wire's marker; its name follows


class SceneLink:
    """Keeps a scene up to date."""

    def __init__(self, scene: Scene, end: threading.Event) -> None:
        """Follow the cell whenever the scene is wanted, until the event is set."""
        self._scene = scene
        self._end = end
        self._lock = threading.Lock()
        self._subscribers: list[rospy.Subscriber] = []
        self._descriptions: object = None
        self._described_s = 0.0
        self._frames: dict[str, Transform] = {}
        threading.Thread(target=self._watch, name="scene 3D", daemon=True).start()

    def _watch(self) -> None:
        while not self._end.wait(_POLL_S):
            if self._scene.is_wanted and time.monotonic() - self._described_s > _DESCRIBED_EVERY_S:
                self._described_s = time.monotonic()
                self._read_robots()
            if self._scene.is_wanted and not self._subscribers:
                self._subscribers = [
                    rospy.Subscriber("/tf_static", TFMessage, self._on_frames, queue_size=10),
                    rospy.Subscriber("/joint_states", JointState, self._on_joints, queue_size=1),
                    rospy.Subscriber(
                        f"{topics.CELL}/markers", MarkerArray, self._on_markers, queue_size=1
                    ),
                ]
            elif not self._scene.is_wanted and self._subscribers:
                for subscriber in self._subscribers:
                    subscriber.unregister()
                self._subscribers = []

    def _read_robots(self) -> None:
        """Read what the robots look like; of a cell that does not say, none is drawn."""
        try:
            found = rospy.get_param(f"{topics.CELL}/robots", {})
        except (OSError, rospy.ROSException):
            return
        if found == self._descriptions:
            return
        self._descriptions = found
        robots = []
        for name, fields in sorted(found.items()):
            try:
                urdf = str(fields["description"])
                prefix = str(fields.get("prefix", ""))
                robots.append(Robot(read_robot(urdf), prefix, description=urdf))
            except (KeyError, TypeError, ValueError) as error:
                rospy.logwarn("robot %s of the cell is not drawn: %s", name, error)
        self._change(robots=tuple(map(self._placed, robots)))

    def _on_frames(self, message: TFMessage) -> None:
        """Place each robot where its root link is fixed."""
        self._frames |= {one.child_frame_id: one.transform for one in message.transforms}
        robots = tuple(map(self._placed, self._scene.now.robots))
        if robots != self._scene.now.robots:
            self._change(robots=robots)

    def _placed(self, robot: Robot) -> Robot:
        found = self._frames.get(robot.prefix + robot.model.root)
        if found is None:
            return robot
        position, rotation = _vector(found.translation), _quaternion(found.rotation)
        return replace(robot, position=position, rotation=rotation)

    def _on_joints(self, message: JointState) -> None:
        names = zip(message.name, message.position, strict=False)
        self._change(joints={**self._scene.now.joints, **dict(names)})

    def _on_markers(self, message: MarkerArray) -> None:
        now = self._scene.now
        wires, boxes = dict(now.wires), dict(now.boxes)
        for marker in message.markers:
            if marker.action == Marker.DELETEALL:
                wires, boxes = {}, {}
            elif marker.type == Marker.LINE_STRIP and marker.ns.startswith(_WIRE):
                points = tuple(map(_vector, marker.points))
                wire = Line(points, marker.scale.x, _colour(marker))
                name = marker.ns.removeprefix(_WIRE)
                # The same object stays as long as the wire lies there: it is not sent again.
                wires[name] = now.wires[name] if now.wires.get(name) == wire else wire
            elif marker.type == Marker.CUBE:
                place = _vector(marker.pose.position), _quaternion(marker.pose.orientation)
                boxes[marker.ns] = Solid(*place, _vector(marker.scale), _colour(marker))
        self._change(wires=wires, boxes=now.boxes if boxes == now.boxes else boxes)

    def _change(self, **fields: object) -> None:
        with self._lock:
            state: CellState = replace(self._scene.now, **fields)
            self._scene.now = state


def _vector(point: Point) -> tuple[float, float, float]:
    return round(point.x, 4), round(point.y, 4), round(point.z, 4)


def _quaternion(rotation: Quaternion) -> tuple[float, float, float, float]:
    return rotation.x, rotation.y, rotation.z, rotation.w


def _colour(marker: Marker) -> str:
    colour = marker.color
    red, green, blue = (round(255 * v) for v in (colour.r, colour.g, colour.b))
    return f"#{red:02x}{green:02x}{blue:02x}"
