"""The simulated cell as a robot's drivers show it: topics and services, without any skill."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import rospy
from geometry_msgs.msg import Point, PoseStamped, Quaternion, Vector3, WrenchStamped
from geometry_msgs.msg import Pose as PoseMsg
from remodel_msgs import srv
from sensor_msgs.msg import CameraInfo, Image, JointState
from trajectory_msgs.msg import JointTrajectory

from flexbe_core.ros.master import join, spin
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.ros.simulated_cell import Markers, RobotState, Services, SimClock
from remodel_states.core.wires import WireMaterials
from remodel_states.edge.exported_tables import read_wire_materials
from remodel_vision.ros.image_message import (
    FixedFrames,
    camera_info,
    depth_image,
    image,
    optical_frame,
)
from remodel_work.camera import Picture
from remodel_work.cell.cell_design import RobotDesign
from remodel_work.edge.cell_file import read_cell
from remodel_work.edge.robot_description import HAND
from remodel_work.errors import CellError, PanelError
from remodel_work.geometry import Array, Pose
from remodel_work.panel import WireEnd
from remodel_work.robot.arm import ToolPose
from remodel_work.ros.panel_message import panel_from, read_panel

T = TypeVar("T")

# Cameras that a node watches take a picture this often [s of simulated time].
CAMERA_PERIOD_S = 0.1
# Simulated time waits so long for who answers each wrench [s of the wall]. Origin: an answer that
# takes 0.4 s on an idle machine took more than 2 s at a load of 11; it bounds the wait, no more.
ANSWER_S = 10.0
# Joint states are published at every second step of the physics, wrenches at each.
STATE_STEPS = 2
PACES = (0.05, 2.0)


class RobotDriver:
    """Steps the plant at a pace of the wall's time; all requests are done between two steps."""

    def __init__(self, plant: SimulatedPlant, materials: WireMaterials, pace: float) -> None:
        """Advertise everything; `pace` is simulated time over the wall's."""
        self._plant, self._materials, self._pace = plant, materials, pace
        self._clock = SimClock()
        self._lock = threading.Lock()
        self._frozen_until = 0.0
        self._steps, self._pictures_s = 0, 0.0
        self._robots = {robot.name: _Driven(plant, robot) for robot in plant.design.robots}
        self._cameras = {
            name: _Camera(name, partial(plant.take_overhead_picture, number))
            for number, name in enumerate(plant.design.overhead_names)
        }
        for robot in plant.design.robots:
            self._cameras[robot.camera.name] = _Camera(
                robot.camera.name, lambda name=robot.name: plant.take_wrist_picture(name)
            )
        fixed = FixedFrames(lambda: self._clock.now)
        self._clock.listeners += [
            RobotState(plant, self._clock, fixed),
            Markers(plant, self._clock),
        ]
        Services(plant, self)
        for name, kind, answer in (
            ("fixture/operate_clamp", srv.OperateClamp, self._operate_clamp),
            ("fixture/load_panel", srv.LoadPanel, self._load_panel),
            ("magazine/present_wire", srv.PresentWire, self._present_wire),
            ("magazine/operate", srv.OperateMagazine, self._operate_magazine),
        ):
            rospy.Service(name, kind, answer)

    def spin(self, is_over: Callable[[], bool]) -> None:
        """Run until `is_over` returns that the node ends."""
        period_s = self._plant.world.time_step / self._pace
        pause, due = threading.Event(), time.monotonic()
        while not is_over():
            for robot in self._robots.values():
                robot.await_answer()
            with self._lock:
                if time.monotonic() >= self._frozen_until:
                    self._step()
            due = max(due + period_s, time.monotonic() - period_s)
            pause.wait(max(0.0, due - time.monotonic()))

    def _step(self) -> None:
        now_s, time_step = self._clock.now_s, self._plant.world.time_step
        for robot in self._robots.values():
            robot.drive(now_s, time_step)
        self._plant.step()
        self._clock.advance(time_step)
        self._steps += 1
        for robot in self._robots.values():
            robot.publish(self._clock.now, with_state=self._steps % STATE_STEPS == 0)
        if self._clock.now_s - self._pictures_s >= CAMERA_PERIOD_S:
            self._pictures_s = self._clock.now_s
            for camera in self._cameras.values():
                camera.publish(self._clock.now)

    def ask(self, question: Callable[[], T], _timeout_s: float) -> T:
        """Evaluate a function between two steps; raises what it raises."""
        with self._lock:
            return question()

    def freeze(self, seconds: float) -> None:
        """Do nothing for so long."""
        self._frozen_until = time.monotonic() + seconds

    def _done(self, answer: Any, action: Callable[[], None]) -> Any:  # noqa: ANN401
        """Do something between two steps, and say in the answer whether it was done."""
        try:
            self.ask(action, 0.0)
        except (CellError, ValueError) as error:
            answer.message = str(error)
        else:
            answer.success = True
        return answer

    def _operate_clamp(self, request: srv.OperateClampRequest) -> srv.OperateClampResponse:
        answer, key = srv.OperateClampResponse(), (request.component_id, request.terminal_id)

        def operate() -> None:
            self._plant.panel.component(key[0]).terminal(key[1])
            if request.close:
                answer.met = self._plant.close_clamp(*key)
            else:
                self._plant.open_clamp(*key)

        return self._done(answer, operate)

    def _load_panel(self, request: srv.LoadPanelRequest) -> srv.LoadPanelResponse:
        def load() -> None:
            panel = panel_from(request.panel, self._materials)
            if not request.keep or panel != self._plant.loaded:
                self._plant.load(panel)
                self._restarted()

        return self._done(srv.LoadPanelResponse(), load)

    def _present_wire(self, request: srv.PresentWireRequest) -> srv.PresentWireResponse:
        answer, wire_id, plant = srv.PresentWireResponse(), request.wire_id, self._plant

        def present() -> None:
            plant.panel.wire(wire_id)
            tools = {name: robot.sent for name, robot in self._robots.items()}
            if request.placed:
                placed = plant.take_up(wire_id, tools)
                tips = {end: Pose.level(*at, 0.0) for end, at in placed.expected.items()}
                answer.fixed = [end in placed.fixed for end in WireEnd]
            else:
                shown = plant.feed(wire_id, request.channel_id, tools)
                tips, answer.direction = dict(shown.tips), shown.direction
                answer.fixed = [False, False]
            answer.tips = [_pose(tips[end]) for end in WireEnd]
            self._restarted()

        return self._done(answer, present)

    def _restarted(self) -> None:
        """Leave the arms where they are: the plant has built the robots again."""
        for robot in self._robots.values():
            robot.forget()

    def _operate_magazine(self, request: srv.OperateMagazineRequest) -> srv.OperateMagazineResponse:
        at, plant = request.at, self._plant

        def operate() -> None:
            if request.command == request.OPEN:
                plant.open_magazine(WireEnd(request.end))
            elif request.command == request.MOVE_FORK:
                plant.move_fork(at.x, at.y)
            elif request.command == request.LOWER_FORK:
                plant.lower_fork()
            elif request.command == request.DROP:
                plant.drop(np.array([at.x, at.y, at.z]))
            else:
                raise ValueError(f"command is {request.command}; allowed: 0 to 3")

        return self._done(srv.OperateMagazineResponse(), operate)


# Timed postures that the driver follows, as ros_control's joint trajectory controller does


# Times that differ by less are the same: stamps are rounded [s].
SAME_S = 1e-4


class Setpoints:
    """Postures and when they are due; between two of them the robot moves evenly."""

    def __init__(self) -> None:
        """Begin without any."""
        self._due: list[tuple[float, Array]] = []
        self._reached: tuple[float, Array] | None = None

    def add(self, at_s: float, joints: Array) -> None:
        """Be in a posture, (joints,), at a time [s]; it replaces what was due then and later."""
        self._due = [point for point in self._due if point[0] < at_s - SAME_S]
        self._due.append((at_s, joints))

    def clear(self) -> None:
        """Drop all, and where they led to."""
        self._due, self._reached = [], None

    def step(self, now_s: float, time_step: float, joints: Array) -> Array | None:
        """Return where to be after a step, (joints,); None: nothing is due, stay.

        Args:
            now_s: when it begins [s].
            time_step: [s].
            joints: where the robot was sent last, (joints,).
        """
        if not self._due:
            self._reached = None
            return None
        end_s = now_s + time_step
        began_s, begun = self._reached or (now_s, joints)
        while self._due and self._due[0][0] <= end_s + SAME_S:
            began_s, begun = self._due.pop(0)
        reached = begun
        if self._due and began_s < end_s:
            due_s, there = self._due[0]
            began_s = max(began_s, now_s)
            reached = begun + (end_s - began_s) / (due_s - began_s) * (there - begun)
        self._reached = max(began_s, end_s), reached
        return reached


class _Driven:
    """The topics of one robot; what is commanded comes into force with the next step."""

    def __init__(self, plant: SimulatedPlant, design: RobotDesign) -> None:
        self._plant, self._design = plant, design
        self.sent: ToolPose = design.home
        self._setpoints, self._adding = Setpoints(), threading.Condition()
        # Whether the commands come step by step, each an answer to the last wrench; and the newest.
        self._answers, self._answered_s = False, 0.0
        self._now_s = 0.0
        self._joints = design.arm.joints_for(design.home)
        self._fingers: tuple[float, float] | None = None
        # As they are built: fingers last.
        names = plant.robots[design.name].joint_names[: len(self._joints)]
        self._joint_names = [design.prefix + name for name in names]
        name = design.name
        self._states = rospy.Publisher(f"{name}/joint_states", JointState, queue_size=5)
        self._wrench = rospy.Publisher(f"{name}/wrench", WrenchStamped, queue_size=5)
        rospy.Subscriber(
            f"{name}/equilibrium_pose", PoseStamped, self._take_pose, queue_size=5, tcp_nodelay=True
        )
        rospy.Subscriber(
            f"{name}/joint_trajectory",
            JointTrajectory,
            self._take_joints,
            queue_size=5,
            tcp_nodelay=True,
        )
        rospy.Subscriber(f"{name}/gripper", JointTrajectory, self._take_fingers, queue_size=5)

    def _take_pose(self, message: PoseStamped) -> None:
        p, q = message.pose.position, message.pose.orientation
        # Half a turn about x, then the yaw: x = cos(yaw / 2), y = sin(yaw / 2).
        yaw = 2.0 * float(np.arctan2(q.y, q.x))
        try:
            joints = self._design.arm.joints_for(ToolPose(p.x, p.y, p.z, yaw))
        except CellError as error:
            rospy.logwarn_throttle(1.0, f"{self._design.name}: {error}")
            return
        self._add(message.header.stamp.to_sec(), joints)

    def _take_joints(self, message: JointTrajectory) -> None:
        wanted = self._joint_names
        if sorted(message.joint_names) != sorted(wanted) or any(
            len(point.positions) != len(wanted) for point in message.points
        ):
            found = ", ".join(message.joint_names)
            rospy.logwarn_throttle(
                1.0,
                f"{self._design.name}: a trajectory of the joints {found} is not followed; "
                f"allowed: {', '.join(wanted)}, each with a position in every point",
            )
            return
        order = [message.joint_names.index(name) for name in wanted]
        for point in message.points:
            at_s = (message.header.stamp + point.time_from_start).to_sec()
            self._add(at_s, np.array(point.positions)[order])

    def _add(self, at_s: float, joints: Array) -> None:
        with self._adding:
            self._setpoints.add(at_s, joints)
            self._answers = at_s - self._now_s < 1.5 * self._plant.world.time_step
            self._answered_s = at_s
            self._adding.notify_all()

    def await_answer(self) -> None:
        """Wait for the answer to the last wrench while commands come step by step."""
        with self._adding:
            answered = self._adding.wait_for(
                lambda: not self._answers or self._answered_s > self._now_s + SAME_S, ANSWER_S
            )
            self._answers = self._answers and answered

    def _take_fingers(self, message: JointTrajectory) -> None:
        if not message.points or not all(point.positions for point in message.points):
            rospy.logwarn_throttle(
                1.0, f"{self._design.name}: a gripper command without positions is not followed"
            )
            return
        first, last = message.points[0].positions[0], message.points[-1].positions[0]
        self._fingers = last, 2.0 * first

    def forget(self) -> None:
        """Drop commands to a robot that has been built again since."""
        with self._adding:
            self._setpoints.clear()
            self._fingers, self._answers = None, False

    def drive(self, now_s: float, time_step: float) -> None:
        """Send the robot where it is to be after the next step."""
        robot = self._plant.robots[self._design.name]
        with self._adding:
            joints = self._setpoints.step(now_s, time_step, self._joints)
            at_once, self._now_s = self._answers, now_s + time_step
        if joints is not None:
            robot.drive(joints, at_once=at_once)
            self._joints, self.sent = joints, self._design.arm.tool_of(joints)
        fingers, self._fingers = self._fingers, None
        if fingers is not None:
            robot.drive_fingers(*fingers)

    def publish(self, now: rospy.Time, *, with_state: bool) -> None:
        """Publish what was measured in the last step."""
        robot, prefix = self._plant.robots[self._design.name], self._design.prefix
        wrench = WrenchStamped()
        wrench.header.stamp, wrench.header.frame_id = now, prefix + HAND
        wrench.wrench.force = Vector3(*robot.read_wrist().tolist())
        self._wrench.publish(wrench)
        if with_state:
            positions, velocities = robot.joint_state
            message = JointState(position=positions, velocity=velocities)
            message.header.stamp = now
            message.name = [prefix + name for name in robot.joint_names]
            loads = robot.finger_loads()
            message.effort = [0.0] * (len(positions) - len(loads)) + loads
            self._states.publish(message)


class _Camera:
    """The topics of one camera, which takes pictures while a node subscribes to them."""

    def __init__(self, name: str, take: Callable[[], Picture]) -> None:
        self._name, self._take = name, take
        self._image = rospy.Publisher(f"{name}/image_raw", Image, queue_size=2)
        self._depth = rospy.Publisher(f"{name}/depth/image_raw", Image, queue_size=2)
        self._info = rospy.Publisher(f"{name}/camera_info", CameraInfo, queue_size=2)

    def publish(self, now: rospy.Time) -> None:
        """Publish a picture if a node subscribes to it."""
        if not self._image.get_num_connections() and not self._depth.get_num_connections():
            return
        picture, frame = self._take(), optical_frame(self._name)
        self._image.publish(image(picture.rgb, frame, now))
        self._info.publish(camera_info(picture.view, frame, now))
        if picture.depth is not None:
            self._depth.publish(depth_image(picture.depth, frame, now))


def _pose(pose: Pose) -> PoseMsg:
    return PoseMsg(Point(*pose.position.tolist()), Quaternion(*pose.quaternion.tolist()))


def main() -> int:
    """Run the drivers until ROS shuts down; returns the exit code."""
    join("robot_driver")
    try:
        pace = float(rospy.get_param("~pace", 0.5))
        if not PACES[0] <= pace <= PACES[1]:
            raise ValueError(f"pace is {pace}; allowed: {PACES[0]} to {PACES[1]}")
        materials = read_wire_materials()
        plant = SimulatedPlant(
            read_panel(Path(rospy.get_param("~panel")), materials),
            design=read_cell(str(rospy.get_param("~cell", "one_panda"))),
            seed=int(rospy.get_param("~seed", 0)),
        )
        driver = RobotDriver(plant, materials, pace)
    except (CellError, PanelError, OSError, ValueError) as error:
        rospy.logfatal("the drivers do not start: %s", error)
        return 1
    rospy.loginfo("the drivers are ready")
    try:
        return spin(driver.spin)
    finally:
        plant.close()
