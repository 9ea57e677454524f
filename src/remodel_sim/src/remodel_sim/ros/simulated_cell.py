"""The simulated cell for a node: plant and time, what it publishes, and the services it offers.

It publishes its time, states, markers and films. Faults and, for scoring only, the truth are the
simulator's own services.
"""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Protocol, TypeVar

import numpy as np
import rospy
from geometry_msgs.msg import Point, Quaternion, Vector3, WrenchStamped
from geometry_msgs.msg import Pose as PoseMsg
from remodel_msgs import srv
from remodel_msgs.msg import WireTruth as WireTruthMsg
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import ColorRGBA
from tf2_ros import TransformBroadcaster
from visualization_msgs.msg import Marker, MarkerArray

from remodel_sim.core.faults import FilmError, check_fault
from remodel_sim.edge.film import Film
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import WireTruth, ground_truth
from remodel_states.core.wires import Rgb, rgbs_of
from remodel_vision.ros.image_message import FixedFrames, optical_frame, transform
from remodel_work.cell.cell_design import CellDesign
from remodel_work.component_shape import HOUSING
from remodel_work.edge.cell_file import read_cell
from remodel_work.edge.robot_description import HAND, RAIL, foot_link, robot_description
from remodel_work.errors import CellError
from remodel_work.geometry import PANEL, WORLD, Pose
from remodel_work.panel import Component, Panel, PanelWire
from remodel_work.robot.arm import Kinematics
from remodel_work.robot.fingers import CAMERA_MOUNT

T = TypeVar("T")

# How often the clock is published [s of simulated time].
PERIOD_S = 0.02
# A pause of the process, as for a render, is not made up for by more than this at once [s].
MAX_CATCH_UP_S = 0.1


class KeptTime(Protocol):
    """What keeps the time of a cell that is killed."""

    time_s: float

    def keep_time(self, now_s: float) -> None:
        """Keep the time [s]."""


class SimClock:
    """Time that the cell makes.

    As fast as it can while an ability runs, at the pace of the wall between goals.

    Attributes:
        listeners: are called whenever time has passed.
    """

    def __init__(self, memory: KeptTime | None = None) -> None:
        """Start at one second: zero means "no time yet" in ROS.

        `memory` keeps the time; with it a restarted cell continues where it was, since nodes
        take time that goes back for a restart of the simulation.
        """
        self._memory = memory
        self.listeners: list[Callable[[], None]] = []
        kept_s = memory.time_s if memory else 0.0
        self.now_s = kept_s + PERIOD_S if kept_s else 1.0
        self._published_s = 0.0
        self._wall = time.monotonic()
        self._publisher = rospy.Publisher("/clock", Clock, queue_size=10)
        self._publish()

    @property
    def now(self) -> rospy.Time:
        """The simulated time."""
        return rospy.Time.from_sec(self.now_s)

    def advance(self, seconds: float) -> None:
        """Let simulated time pass."""
        self._wall = time.monotonic()
        self._move(seconds)

    def idle(self) -> None:
        """Let as much simulated time pass as wall time has passed."""
        wall = time.monotonic()
        self._move(min(wall - self._wall, MAX_CATCH_UP_S))
        self._wall = wall

    def _move(self, seconds: float) -> None:
        self.now_s += seconds
        if self.now_s - self._published_s >= PERIOD_S:
            self._publish()
        for listener in self.listeners:
            listener()

    def _publish(self) -> None:
        self._published_s = self.now_s
        if self._memory is not None:
            self._memory.keep_time(self.now_s)
        self._publisher.publish(Clock(self.now))


# Between two pictures [s of simulated time]; the film shows ten a second, so it runs at four times
# the cell's pace.
FILM_PERIOD_S = 0.4


class Filming:
    """Takes the pictures; a cancel waits for one at most, some 0.1 s."""

    def __init__(self, plant: SimulatedPlant, clock: SimClock, film: Film, camera: str) -> None:
        """Film with a camera of the cell."""
        self._plant = plant
        self._clock = clock
        self._film = film
        self._camera = camera
        self._taken_s = 0.0
        self._stopped = False

    def __call__(self) -> None:
        """Take a picture when it is time."""
        if self._stopped or self._clock.now_s - self._taken_s < FILM_PERIOD_S:
            return
        self._taken_s = self._clock.now_s
        try:
            self._film.add(self._plant.film(self._camera))
        except FilmError as error:
            rospy.logerr("%s; no more pictures are taken", error)
            self._stopped = True

    def close(self) -> None:
        """End the film."""
        try:
            self._film.close()
        except FilmError as error:
            rospy.logerr("%s", error)


# [s] How often the wire under way is published, by the clock of the people who watch: a cell that
# is faster than that must not be slowed down by showing more than they can see.
MARKERS_PERIOD_S = 0.05
# [s] of simulated time: how often everything is published at least.
WHOLE_PERIOD_S = 1.0


class Markers:
    """Publishes components as boxes and wires as lines."""

    def __init__(self, plant: SimulatedPlant, clock: SimClock) -> None:
        """Advertise the topic."""
        self._plant = plant
        self._clock = clock
        self._published_s = self._whole_s = 0.0
        self._shown: object = None
        self._publisher = rospy.Publisher("cell/markers", MarkerArray, queue_size=2)

    def __call__(self) -> None:
        """Publish when it is time and there is a subscriber."""
        wall_s = time.monotonic()
        if wall_s - self._published_s < MARKERS_PERIOD_S:
            return
        self._published_s = wall_s
        viewers = self._publisher.get_num_connections()
        if not viewers:
            return
        plant = self._plant
        live = plant.live.wire.id if plant.live else ""
        shown = (viewers, live, id(plant.panel), frozenset(plant.parked))
        if shown == self._shown and self._clock.now_s - self._whole_s < WHOLE_PERIOD_S:
            if plant.live is not None:
                line = self._line(plant.live.wire, plant.live.cable.nodes())
                self._publisher.publish(MarkerArray([line]))
            return
        self._shown, self._whole_s = shown, self._clock.now_s
        markers = [Marker(action=Marker.DELETEALL)]
        markers += [self._box(component) for component in plant.panel.components]
        markers += [
            self._line(plant.panel.wire(wire_id), parked.nodes)
            for wire_id, parked in plant.parked.items()
        ]
        if plant.live is not None:
            markers.append(self._line(plant.live.wire, plant.live.cable.nodes()))
        self._publisher.publish(MarkerArray(markers))

    def _marker(self, namespace: str, name: str, kind: int, rgb: Rgb) -> Marker:
        marker = Marker(ns=f"{namespace}/{name}", type=kind, action=Marker.ADD)
        marker.header.frame_id, marker.header.stamp = WORLD, self._clock.now
        marker.pose.orientation.w = 1.0
        marker.color = ColorRGBA(*rgb, 1.0)
        return marker

    def _box(self, component: Component) -> Marker:
        marker = self._marker("component", component.id, Marker.CUBE, HOUSING)
        pose = self._plant.world_from_component(component.id)
        x, y, z = pose.position
        marker.pose = PoseMsg(Point(x, y, z + component.size[2] / 2), Quaternion(*pose.quaternion))
        marker.scale = Vector3(*component.size)
        return marker

    def _line(self, wire: PanelWire, nodes: np.ndarray) -> Marker:
        marker = self._marker("wire", wire.id, Marker.LINE_STRIP, rgbs_of(wire.colour)[0])
        marker.scale.x = wire.diameter
        marker.points = [Point(*node) for node in nodes]
        return marker


# Joint states, forces and frames are published this often [s of simulated time].
STATE_PERIOD_S = 0.04


class RobotState:
    """Publishes joint states, the forces at the wrists, and frames."""

    def __init__(self, plant: SimulatedPlant, clock: SimClock, fixed: FixedFrames) -> None:
        """Publish the frames that never move, once."""
        self._plant = plant
        self._clock = clock
        self._published_s = 0.0
        # What a viewer draws a robot by: its URDF, and what precedes its names elsewhere.
        robots = {
            robot.name: {"description": robot_description(robot.arm), "prefix": robot.prefix}
            for robot in plant.design.robots
        }
        rospy.set_param("cell/robots", robots)
        self._joints = rospy.Publisher("/joint_states", JointState, queue_size=5)
        self._wrenches = {
            robot.name: rospy.Publisher(
                f"cell/{robot.camera.name}/wrench", WrenchStamped, queue_size=5
            )
            for robot in plant.design.robots
        }
        self._moving = TransformBroadcaster()
        above = zip(plant.design.overhead_names, plant.design.overheads, strict=True)
        fixed({optical_frame(name): view.world_from_camera for name, view in above})
        fixed({PANEL: plant.panel.world_from_panel})
        lens = Pose(np.array(CAMERA_MOUNT), np.array([0.0, 0.0, 0.0, 1.0]))
        for robot in plant.design.robots:
            fixed({robot.prefix + _foot(robot.arm): robot.arm.world_from_base})
            fixed({optical_frame(robot.camera.name): lens}, parent=robot.prefix + HAND)

    def __call__(self) -> None:
        """Publish when it is time."""
        if self._clock.now_s - self._published_s < STATE_PERIOD_S:
            return
        self._published_s = self._clock.now_s
        message = JointState()
        message.header.stamp = self._clock.now
        for design in self._plant.design.robots:
            robot, hand = self._plant.robots[design.name], design.prefix + HAND
            positions, velocities = robot.joint_state
            message.name += [design.prefix + name for name in robot.joint_names]
            message.position += positions
            message.velocity += velocities
            wrench = WrenchStamped()
            wrench.header.frame_id, wrench.header.stamp = hand, self._clock.now
            wrench.wrench.force = Vector3(*robot.wrist_force)
            self._wrenches[design.name].publish(wrench)
            moving = {hand: robot.world_from_hand}
            if design.arm.axis is not None:
                moving[design.prefix + foot_link(design.arm)] = robot.world_from_base
            self._moving.sendTransform(
                [transform(WORLD, frame, pose, self._clock.now) for frame, pose in moving.items()]
            )
        self._joints.publish(message)


def _foot(arm: Kinematics) -> str:
    """Return the link of a robot that is bolted down."""
    return foot_link(arm) if arm.axis is None else RAIL


# The longest request waits for a picture that a skill takes [s].
TIMEOUT_S = 60.0
SERVER_FAULTS = ("server_frozen", "server_killed")
# A node that is to be killed answers first; so long the answer has to get out [s].
ANSWER_S = 0.2


class Owner(Protocol):
    """Who owns the plant: what is asked is done in its thread, between two ticks."""

    def ask(self, question: Callable[[], T], timeout_s: float) -> T:
        """Evaluate a function; raises CellError when there is no answer in time, or its error."""

    def freeze(self, seconds: float) -> None:
        """Do nothing for so long."""


class Services:
    """Answers the simulator's services."""

    def __init__(self, plant: SimulatedPlant, owner: Owner) -> None:
        """Advertise all of them."""
        self._plant, self._owner = plant, owner
        for name, kind, answer in (
            ("ground_truth", srv.GetGroundTruth, self._ground_truth),
            ("inject_fault", srv.InjectFault, self._inject_fault),
        ):
            rospy.Service(f"cell/{name}", kind, answer)

    def _inject_fault(self, request: srv.InjectFaultRequest) -> srv.InjectFaultResponse:
        text = f"{request.kind} {request.target!r}"

        def disturb() -> None:
            values = tuple(request.values)
            if request.kind not in SERVER_FAULTS:
                self._plant.disturb(request.kind, request.target, values)
                return
            check_fault(request.kind, request.target, values)
            if request.kind == "server_frozen":
                self._owner.freeze(values[0])
            else:
                threading.Timer(ANSWER_S, os.kill, (os.getpid(), signal.SIGKILL)).start()

        return srv.InjectFaultResponse(*self._done(disturb, text))

    def _ground_truth(self, _: srv.GetGroundTruthRequest) -> srv.GetGroundTruthResponse:
        plant = self._plant
        truths = self._owner.ask(lambda: ground_truth(plant, list(plant.shapes())), TIMEOUT_S)
        return srv.GetGroundTruthResponse([truth_message(truth) for truth in truths])

    def _done(self, action: Callable[[], None], text: str) -> tuple[bool, str]:
        try:
            self._owner.ask(action, TIMEOUT_S)
        except CellError as error:
            return False, str(error)
        return True, text


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


RATES_HZ = (120, 2000)


class SimulatedCell:
    """A plant whose time is ROS's.

    Attributes:
        plant: the physics.
        clock: its time.
        kind: for people.
    """

    kind = "simulated"

    def __init__(self, panel: Panel, memory: KeptTime | None, closing: ExitStack) -> None:
        """Build a cell by the node's parameters; raises ValueError or CellError."""
        design = read_cell(str(rospy.get_param("~cell", "one_panda")))
        rate_hz = float(rospy.get_param("~rate_hz", 240.0))
        if not RATES_HZ[0] <= rate_hz <= RATES_HZ[1]:
            raise ValueError(f"rate_hz is {rate_hz}; allowed: {RATES_HZ[0]} to {RATES_HZ[1]}")
        record, camera = _recording(design)
        self.clock = SimClock(memory)
        self.plant = SimulatedPlant(
            panel,
            design=design,
            seed=int(rospy.get_param("~seed", 0)),
            rate_hz=rate_hz,
            gui=bool(rospy.get_param("~gui", False)),
        )
        self.plant.on_time = self._passed
        self._film: Filming | None = None
        if record is not None:
            self._film = Filming(self.plant, self.clock, Film(record), camera)
            closing.callback(self._film.close)

    def offer(self, owner: Owner, fixed: FixedFrames) -> None:
        """Begin to publish the state of robots and scene, and offer the simulator's services."""
        self.clock.listeners += [
            RobotState(self.plant, self.clock, fixed),
            Markers(self.plant, self.clock),
        ]
        Services(self.plant, owner)

    def _passed(self, seconds: float) -> None:
        self.clock.advance(seconds)
        if self._film is not None:
            self._film()


def _recording(design: CellDesign) -> tuple[Path | None, str]:
    """Return the folder that a run is filmed into, None: it is not, and with which camera."""
    folder = str(rospy.get_param("~record", ""))
    camera = str(rospy.get_param("~record_camera", "scene"))
    if folder and not Path(folder).is_absolute():
        raise ValueError(f"record is {folder!r}; name an absolute path, such as $PWD/{folder}")
    if camera not in design.camera_names:
        there_are = ", ".join(design.camera_names)
        raise ValueError(f"record_camera is {camera!r}; there are: {there_are}")
    return Path(folder) if folder else None, camera
