"""What pages watch: cameras, the scene and its recording, and topics to plot.

Overhead and wrist camera publish whenever the cell takes a picture. The scene is rendered on
request only: the console requests it while a page shows it, and leaves a working cell most of its
time.

A topic is subscribed to by its own message class: another subscriber of this node to the same
topic would receive what the first one's class makes of it.
"""

from __future__ import annotations

import threading
import time
import xmlrpc.client
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TextIO

import rosgraph
import roslib.message
import rospy
from geometry_msgs.msg import Point, Quaternion, Transform
from remodel_msgs.srv import TakePicture, TakePictureRequest
from sensor_msgs.msg import Image, JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger, TriggerRequest
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from flexbe_core.engine.visit import VisitText
from remodel_console.core.cell import (
    CellState,
    Line,
    Robot,
    Solid,
    StateValues,
    change_between,
    frame_text,
    read_robot,
)
from remodel_console.core.plots import check_field, number_fields, number_in, split_plot
from remodel_console.core.use_case import UseCase
from remodel_console.edge.kept_files import SceneFiles, as_jpeg
from remodel_console.errors import CommandError, PictureError
from remodel_console.ros import topics
from remodel_console.ros.calls import call_service
from remodel_console.watched import Pictures, RunValues, Scene, TopicPlots

CAMERAS = ("overhead", "wrist")
SCENE = "scene"
_EVERY_S = 0.2  # between two pictures of one camera, at least
_SCENE_EVERY_S = 2.0
_POLL_S = 0.2
# Of the cell's time, at most so much goes into pictures for people.
_SHARE_AT_WORK, _SHARE_AT_REST = 0.1, 0.5


class CameraLink:
    """Subscribes to the cameras, and turns what they see into JPEG on threads of its own."""

    def __init__(
        self, pictures: Pictures, is_at_work: Callable[[], bool], end: threading.Event
    ) -> None:
        """Connect.

        Args:
            pictures: receive the pictures.
            is_at_work: returns whether the cell is working.
            end: until it is set, the scene is requested too.
        """
        self._pictures = pictures
        self._is_at_work = is_at_work
        self._end = end
        self._waiting: dict[str, Image] = {}
        self._has_new = threading.Event()
        for camera in CAMERAS:
            for topic in ("image_raw", "detections"):
                rospy.Subscriber(
                    f"{topics.CELL}/{camera}/{topic}",
                    Image,
                    self._take,
                    callback_args=camera,
                    queue_size=1,
                )
        threading.Thread(target=self._encode, name="cameras", daemon=True).start()
        threading.Thread(target=self._watch_scene, name="scene", daemon=True).start()

    def _take(self, message: Image, camera: str) -> None:
        self._waiting[camera] = message
        self._has_new.set()

    def _encode(self) -> None:
        """Encode the newest picture of each camera; older ones are skipped."""
        while not self._end.wait(_EVERY_S):
            if self._has_new.wait(_EVERY_S):
                self._has_new.clear()
                for camera in CAMERAS:
                    message = self._waiting.pop(camera, None)
                    if message is not None:
                        self._keep(camera, message)

    def _keep(self, camera: str, message: Image) -> None:
        try:
            shape = (message.height, message.width, message.step)
            self._pictures.take(camera, as_jpeg(message.data, *shape, message.encoding))
        except PictureError as error:
            rospy.logwarn_throttle(60, "camera %s: %s", camera, error)

    def _watch_scene(self) -> None:
        begin_s = took_s = 0.0
        while not self._end.wait(_POLL_S):
            share = _SHARE_AT_WORK if self._is_at_work() else _SHARE_AT_REST
            is_soon = time.monotonic() < begin_s + max(_SCENE_EVERY_S, took_s / share)
            if is_soon or not self._pictures.is_wanted:
                continue
            begin_s = time.monotonic()
            with suppress(CommandError):  # no cell; the page says so
                answer = call_service(
                    f"{topics.CELL}/take_picture", TakePicture, TakePictureRequest(SCENE)
                )
                if answer.success:
                    self._keep(SCENE, answer.image)
            took_s = time.monotonic() - begin_s


_DESCRIBED_EVERY_S = 2.0  # between two checks whether another cell describes itself
_WIRE = "wire/"  # begins the namespace of a wire's marker; its name follows


class SceneLink:
    """Keeps a scene up to date."""

    def __init__(self, scene: Scene, end: threading.Event) -> None:
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


_RECORDER_POLL_S = 0.02  # wall time
_PERIOD_S = 0.1  # between two frames, ROS time


class SceneRecorder:
    """Writes what has changed in a scene and in userdata, ten times in a second of the cell."""

    def __init__(
        self,
        scene: Scene,
        files: SceneFiles,
        use_case: Callable[[], UseCase | None],
        values: deque[StateValues],
        end: threading.Event,
    ) -> None:
        """Record each run that `use_case` returns, until the event is set.

        `values` holds the userdata that states have found; what is recorded is taken out.
        """
        self._scene = scene
        self._files = files
        self._use_case = use_case
        self._values = values
        self._end = end
        self._run: tuple[int, str] | None = None
        self._file: TextIO | None = None
        self._state = CellState()
        self._written_s = 0.0
        self._is_first = True
        threading.Thread(target=self._record, name="scene recorder", daemon=True).start()

    def _record(self) -> None:
        while not self._end.wait(_RECORDER_POLL_S):
            self._follow_run()
            if self._file is not None:
                self._write()
            else:
                self._values.clear()
        self._close()

    def _follow_run(self) -> None:
        """Begin and end with the runs."""
        now = self._use_case()
        run = (now.run, now.order) if now is not None and now.is_under_way and now.run else None
        if run == self._run:
            return
        self._close()
        self._run = run
        if run is None:
            return
        try:
            self._file = self._files.begin(
                *run,
                begun_s=time.time(),
                started_s=now.started_s,
                goes_on=now.interruptions > 0,
            )
        except OSError as error:
            rospy.logwarn("run %d of %s is not recorded in three dimensions: %s", *run, error)
            return
        self._state, self._written_s, self._is_first = CellState(), 0.0, True
        self._scene.add_viewer(1)

    def _write(self) -> None:
        now_s = rospy.get_time()
        if 0.0 <= now_s - self._written_s < _PERIOD_S or self._file is None:
            return
        state = self._scene.now
        change = change_between(self._state, state)
        changes = [change] if change else []
        while self._values:
            changes.append({"values": self._values.popleft().as_json()})
        self._written_s = now_s
        if not changes:
            return
        if self._is_first:
            changes[0]["whole"] = True
        joints = {**self._state.joints, **change.get("joints", {})}  # what turns slowly adds up
        self._state, self._is_first = replace(state, joints=joints), False
        try:
            self._file.writelines(frame_text(now_s, one) for one in changes)
            self._file.flush()
        except OSError as error:
            rospy.logwarn("the recording in three dimensions ends: %s", error)
            run = self._run
            self._close()
            self._run = run  # it is not begun again

    def _close(self) -> None:
        self._run = None
        if self._file is not None:
            self._scene.add_viewer(-1)
            with suppress(OSError):  # of a full disk: what is still to be written is lost
                self._file.close()
            self._file = None


_CALLER = "/remodel_console"
_CHECK_S = 0.5  # between two checks of what is to be plotted


class TopicValues:
    """Subscribes to the topics of plots while pages show them."""

    def __init__(
        self, plots: TopicPlots, chosen: Callable[[], tuple[str, ...]], end: threading.Event
    ) -> None:
        self._plots = plots
        self._chosen = chosen
        self._end = end
        self._subscribers: dict[str, rospy.Subscriber] = {}
        threading.Thread(target=self._watch, name="plots", daemon=True).start()

    def topics(self) -> dict[str, str]:
        """Return the message types of all topics that a node publishes, by their names."""
        try:
            return dict(sorted(rosgraph.Master(_CALLER).getPublishedTopics("")))
        except (OSError, xmlrpc.client.Error, rosgraph.MasterError) as error:
            raise CommandError("the ROS master does not answer; start it: roscore") from error

    def fields(self, topic: str) -> tuple[str, ...]:
        """Return the fields of a topic that are numbers.

        Raises:
            CommandError: if no node publishes it, or its type is not built here.
        """
        return tuple(number_fields(self._kind(topic), _fields_of))

    def check(self, plot: str) -> None:
        """Refuse what cannot be plotted.

        Raises:
            CommandError: if there is no such topic, or its field is no number.
        """
        self._parsed(plot)

    def _parsed(self, plot: str) -> tuple[str, str, str]:
        """Return topic, field and message type of a plot."""
        try:
            topic, field = split_plot(plot)
            kind = self._kind(topic)
            check_field(field, kind, tuple(number_fields(kind, _fields_of)))
        except ValueError as error:
            raise CommandError(str(error)) from error
        return topic, field, kind

    def _kind(self, topic: str) -> str:
        kinds = self.topics()
        if topic not in kinds:
            raise CommandError(f"no node publishes {topic}; rostopic list prints what there is")
        return kinds[topic]

    def _watch(self) -> None:
        while not self._end.wait(_CHECK_S):
            chosen = self._chosen() if self._plots.is_wanted else ()
            for plot in set(self._subscribers) - set(chosen):
                self._subscribers.pop(plot).unregister()
            self._plots.keep(chosen)  # no line leads over the time in which nothing was received
            for plot in set(chosen) - set(self._subscribers):
                self._subscribe(plot)

    def _subscribe(self, plot: str) -> None:
        try:
            topic, field, kind = self._parsed(plot)
        except CommandError as error:
            self._plots.report(plot, str(error))
            return
        take = partial(self._take, plot, field)
        self._subscribers[plot] = rospy.Subscriber(topic, _class_of(kind), take)

    def _take(self, plot: str, field: str, message: object) -> None:
        try:
            self._plots.add(plot, number_in(message, field))
        except IndexError:
            self._plots.report(plot, f"the messages have no element {field}")


def _fields_of(kind: str) -> list[tuple[str, str]]:
    message = _class_of(kind)
    return list(zip(message.__slots__, message._slot_types, strict=True))


def _class_of(kind: str) -> type[rospy.Message]:
    found = roslib.message.get_message_class(kind)
    if found is None:
        text = f"the message type {kind} is not built in this workspace; "
        raise CommandError(f"{text}build its package, source it, and start the console again")
    return found  # type: ignore[no-any-return]
