"""The cell's description, and what moves in it; its values, and putting it back."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import rospy
from geometry_msgs.msg import Point, Quaternion, Transform
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger, TriggerRequest
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from flexbe_core.engine.visit import VisitText
from remodel_console.core.cell.cell_state import CellState, Line, Robot, Solid
from remodel_console.core.cell.robot_model import read_robot
from remodel_console.errors import CommandError
from remodel_console.ros import topics
from remodel_console.ros.call_service import call_service
from remodel_console.watched import RunValues, Scene

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


class ValuesLink:
    """Subscribes to the visits of states."""

    def __init__(self, values: RunValues) -> None:
        """Keep `values` up to date."""
        self._values = values
        self._is_asking = False
        self._subscriber = self._subscribe()

    def _subscribe(self) -> rospy.Subscriber:
        """Subscribe; the engine sends all values first."""
        return rospy.Subscriber(topics.VISITS, String, self._take, tcp_nodelay=True)

    def _take(self, message: String) -> None:
        try:
            visit = VisitText.from_json(message.data)
        except (ValueError, TypeError, KeyError) as error:
            rospy.logwarn_once("%s has messages of another version: %s", topics.VISITS, error)
            return
        if self._values.take(visit):
            self._is_asking = False
        elif not self._is_asking:  # messages were lost
            self._is_asking = True
            self._subscriber.unregister()
            self._subscriber = self._subscribe()


RESET = f"{topics.CELL}/reset"  # a service that only simulated cells have
_LIMIT_S = 60.0  # wall time; a large panel takes some


def reset_cell() -> str:
    """Have the cell rebuild its panel without wires, and return its answer.

    Raises:
        CommandError: if it does not answer, or refuses.
    """
    answer = call_service(RESET, Trigger, TriggerRequest(), _LIMIT_S)
    if not answer.success:
        raise CommandError(f"the cell is not reset: {answer.message}")
    return str(answer.message)
