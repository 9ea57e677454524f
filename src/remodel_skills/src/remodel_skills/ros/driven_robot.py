"""A robot behind its drivers' topics, as a device of the port.

All runs in the thread that owns the cell: rospy's threads only store messages. While that thread
waits for the next tick, it answers each wrench with the next step of a push or pull, so the control
is as fast as the sensor publishes.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import rospy
from geometry_msgs.msg import Point, PoseStamped, Quaternion, WrenchStamped
from roslib.message import get_message_class
from sensor_msgs.msg import Image, JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from remodel_skills.edge.robot_file import POSE, CameraTopics, RobotTopics
from remodel_skills.force_control import ForceLoop
from remodel_states.core.codes import Code
from remodel_vision.ros.image_message import depth_of, read_image
from remodel_work.camera import Picture, View
from remodel_work.cell.cell_design import RobotDesign
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.fingers import CAMERA_MOUNT

# What says nothing for so long, of the wall's time, has stopped [s].
SILENCE_S = 5.0
# A push without a new force for so long, by the stamps, is one that feels nothing [s].
NUMB_S = 0.1
# A picture arrives within this time [s of the wall]; a renderer takes its time.
PICTURE_S = 20.0
# A picture is read at once from its connection [bytes].
BUFFER = 2**24
# Fingers that were sent further than they are by this have stopped on something [m].
STOPPED_M = 0.0005


class Inbox:
    """Wakes the owner's thread when a message has come."""

    def __init__(self) -> None:
        """Begin empty."""
        self.arrived = threading.Condition()

    def put(self, store: Callable[[Any], None]) -> Callable[[Any], None]:
        """Return a callback that stores a message, and wakes who waits."""

        def keep(message: Any) -> None:  # noqa: ANN401 - a message of any type
            with self.arrived:
                store(message)
                self.arrived.notify_all()

        return keep


class Sensors:
    """What the drivers of one robot publish.

    Attributes:
        stamp_s: of the newest joint states [s].
        wrench: stamp [s] and force (3,) [N] of the newest wrench, as published but for its sign.
        filtered: the force, low-passed, (3,) [N].
    """

    def __init__(self, inbox: Inbox, topics: RobotTopics) -> None:
        """Subscribe."""
        self._topics = topics
        self._joints: dict[str, float] = {}
        self._efforts: dict[str, float] = {}
        self.stamp_s = 0.0
        self.wrench: tuple[float, Array] | None = None
        self.filtered = np.zeros(3)
        rospy.Subscriber(topics.wrench[0], WrenchStamped, inbox.put(self._felt), queue_size=20)
        for topic in sorted({topics.joint_states, topics.fingers_topic}):
            rospy.Subscriber(topic, JointState, inbox.put(self._moved), queue_size=20)

    @property
    def missing(self) -> list[str]:
        """What has not been heard of yet: topic and what it should have."""
        topics = self._topics
        silent = [
            f"{topic}: joint {name}"
            for topic, names in (
                (topics.joint_states, topics.joints),
                (topics.fingers_topic, topics.fingers),
            )
            for name in names
            if name not in self._joints
        ]
        if self.wrench is None:
            silent.append(f"{topics.wrench[0]}: geometry_msgs/WrenchStamped")
        return silent

    def _moved(self, message: JointState) -> None:
        self._joints.update(zip(message.name, message.position, strict=False))
        self._efforts.update(zip(message.name, message.effort, strict=False))
        if self._topics.joints[0] in message.name:
            self.stamp_s = message.header.stamp.to_sec()

    def _felt(self, message: WrenchStamped) -> None:
        force, stamp_s = message.wrench.force, message.header.stamp.to_sec()
        value: Array = float(self._topics.wrench[2]) * np.array([force.x, force.y, force.z])
        share = 1.0
        if self.wrench is not None and self._topics.filter_s > 0:
            share = min(1.0, max(0.0, stamp_s - self.wrench[0]) / self._topics.filter_s)
        self.filtered = self.filtered + share * (value - self.filtered)
        self.wrench = stamp_s, value

    @property
    def joints(self) -> Array:
        """The measured joints of the arm, (joints,)."""
        return np.array([self._joints[name] for name in self._topics.joints])

    @property
    def fingers(self) -> list[float]:
        """The measured distance of each finger from the middle [m]."""
        return [self._joints[name] for name in self._topics.fingers]

    @property
    def finger_loads(self) -> list[float] | None:
        """The measured closing force of each finger [N]; None: it is not measured."""
        efforts = [self._efforts.get(name) for name in self._topics.fingers]
        measured = [effort for effort in efforts if effort is not None]
        return measured if len(measured) == len(efforts) else None


class DrivenArm:
    """An arm behind topics.

    Attributes:
        sensors: what its drivers publish.
    """

    def __init__(
        self, inbox: Inbox, design: RobotDesign, topics: RobotTopics, tick_s: float
    ) -> None:
        """Subscribe, and advertise the commands, `tick_s` apart [s]."""
        self._topics, self._arm, self._tick_s = topics, design.arm, tick_s
        self.sensors = Sensors(inbox, topics)
        self._controlled_s = 0.0
        self._loop: ForceLoop | None = None
        topic, kind = topics.motion
        self._sends_poses = kind == POSE
        message = PoseStamped if self._sends_poses else JointTrajectory
        self._motion = rospy.Publisher(topic, message, queue_size=2)

    @property
    def tool(self) -> ToolPose:
        """The measured tool pose."""
        return self._arm.tool_of(self.sensors.joints)

    @property
    def world_from_hand(self) -> Pose:
        """The measured hand: half a turn about x, then the tool's yaw, above the tool centre."""
        tool = self.tool
        up = np.array([0.0, 0.0, self._arm.fingers.tool_m])
        c, s = math.cos(tool.yaw / 2), math.sin(tool.yaw / 2)
        return Pose(tool.position + up, np.array([c, s, 0.0, 0.0]))

    def _in_world(self, force: Array) -> Array:
        frame = self._topics.wrench[1]
        if frame == "hand":
            return self.world_from_hand.rotation @ force
        return self._arm.world_from_base.rotation @ force if frame == "base" else force

    @property
    def force(self) -> Array:
        """The measured force of the wrist on the hand, low-passed, world frame, (3,) [N]."""
        return self._in_world(self.sensors.filtered)

    @property
    def hand_mass(self) -> float:
        """What the wrist carries [kg]."""
        return self._topics.hand_mass

    def go(self, tool: ToolPose) -> None:
        """Be at a tool pose after a tick; raises AbilityError UNREACHABLE."""
        self.go_joints(self._arm.joints_for(tool))

    def go_joints(self, joints: Array) -> None:
        """Be in a posture after a tick, (joints,)."""
        self._loop = None
        self._send(joints, self.sensors.stamp_s, self._tick_s + self._topics.lead_s)

    def press(self, loop: ForceLoop) -> None:
        """Move under force control, a step for each wrench, until another command."""
        if self._loop is None:
            self._controlled_s = self.sensors.wrench[0] if self.sensors.wrench else 0.0
        self._loop = loop

    def control(self) -> None:
        """Answer the newest wrench with the next step of a push or pull."""
        if self._loop is None or self.sensors.wrench is None:
            return
        stamp_s, force = self.sensors.wrench
        passed_s = stamp_s - self._controlled_s
        if passed_s <= 0.0:
            return
        self._controlled_s = stamp_s
        joints = self._loop.step(self._in_world(force), passed_s)
        self._send(joints, stamp_s, passed_s)

    @property
    def is_numb(self) -> bool:
        """Whether it pushes or pulls, and no force has arrived for a while."""
        if self._loop is None or self.sensors.wrench is None:
            return False
        return self.sensors.stamp_s - self.sensors.wrench[0] > NUMB_S

    def _send(self, joints: Array, now_s: float, within_s: float) -> None:
        """Send the arm to a posture, to be there within a time [s]."""
        at = rospy.Time.from_sec(now_s + within_s)
        if self._sends_poses:
            self._motion.publish(self._pose(joints, at))
            return
        message = JointTrajectory(joint_names=list(self._topics.joints))
        message.header.stamp = rospy.Time.from_sec(now_s)
        point = JointTrajectoryPoint(positions=joints.tolist())
        point.time_from_start = rospy.Duration.from_sec(within_s)
        message.points = [point]
        self._motion.publish(message)

    def _pose(self, joints: Array, at: rospy.Time) -> PoseStamped:
        tool = self._arm.tool_of(joints)
        c, s = math.cos(tool.yaw / 2), math.sin(tool.yaw / 2)
        pose = Pose(tool.position, np.array([c, s, 0.0, 0.0]))
        frame, name = self._topics.frame
        if frame == "base":
            pose = self._arm.world_from_base.inverse() @ pose
        message = PoseStamped()
        message.header.stamp, message.header.frame_id = at, name
        message.pose.position = Point(*pose.position.tolist())
        message.pose.orientation = Quaternion(*pose.quaternion.tolist())
        return message


class DrivenGripper:
    """Two fingers behind a topic."""

    def __init__(self, arm: DrivenArm, design: RobotDesign, topics: RobotTopics) -> None:
        """Advertise the commands; raises AbilityError where the type's package is missing."""
        self._sensors, self._design, self._topics = arm.sensors, design, topics
        self._sent = design.arm.fingers.opening / 2
        topic, kind = topics.gripper
        message = get_message_class(kind)
        if message is None:
            raise AbilityError(
                Code.INTERNAL,
                f"{topic}: message {kind} is not installed; install the ROS package "
                f"{kind.partition('/')[0]}",
            )
        self._message = message
        self._commands = rospy.Publisher(topic, message, queue_size=2)

    @property
    def gap(self) -> float:
        """The measured distance between the pads [m]."""
        return sum(self._sensors.fingers)

    @property
    def load(self) -> float:
        """The closing force of the weaker finger [N].

        Fingers that measure none have their grip force when they have stopped on something.
        """
        efforts = self._sensors.finger_loads
        if efforts is not None:
            return min(efforts)
        stopped = min(self._sensors.fingers) > self._sent + STOPPED_M
        return self._design.gripper.grip_force if stopped else 0.0

    def open_to(self, opening: float) -> None:
        """Send each finger to a distance from the middle [m]."""
        self._send([(opening, self._topics.finger_speeds[0])])

    def close_on(self, thickness: float, slow_before: float) -> None:
        """Close until the fingers stop on what they grip, about so thick, slowly before it [m]."""
        fast, slow = self._topics.finger_speeds
        self._send([((thickness + slow_before) / 2, fast), (0.0, slow)])

    def _send(self, ways: list[tuple[float, float]]) -> None:
        """Send each finger to distances from the middle [m], each at a speed [m/s]."""
        self._sent = ways[-1][0]
        if self._topics.gripper[1] == "control_msgs/GripperCommandActionGoal":
            goal = self._message()
            goal.goal.command.position = self._sent
            goal.goal.command.max_effort = self._design.gripper.grip_force
            self._commands.publish(goal)
            return
        message = JointTrajectory(joint_names=list(self._topics.fingers))
        here, after_s = max(self._sensors.fingers), 0.0
        for there, speed in ways:
            after_s += abs(there - here) / speed
            point = JointTrajectoryPoint(positions=[there] * 2)
            point.time_from_start = rospy.Duration.from_sec(after_s)
            message.points.append(point)
            here = there
        self._commands.publish(message)


class DrivenCamera:
    """A camera behind topics, which are subscribed to while a picture is taken."""

    def __init__(self, inbox: Inbox, topics: CameraTopics, see_from: Callable[[], View]) -> None:
        """Name the topics; `see_from` returns where the camera is now."""
        self._inbox, self._topics, self._see_from = inbox, topics, see_from

    @property
    def view(self) -> View:
        """Where it is now."""
        return self._see_from()

    def take(self) -> Picture:
        """Take the next picture; raises AbilityError INTERNAL when none comes."""
        view, measures_depth = self._see_from(), self._topics.depth is not None
        colour: dict[rospy.Time, Image] = {}
        depth: dict[rospy.Time, Image] = {}
        topics = {self._topics.image: colour}
        if self._topics.depth is not None:
            topics[self._topics.depth] = depth
        subscribers = [
            rospy.Subscriber(topic, Image, self._inbox.put(_keeper(to)), buff_size=BUFFER)
            for topic, to in topics.items()
        ]

        def taken() -> list[rospy.Time]:
            return [at for at in colour if not measures_depth or at in depth]

        try:
            with self._inbox.arrived:
                if not self._inbox.arrived.wait_for(taken, PICTURE_S):
                    raise AbilityError(
                        Code.INTERNAL,
                        f"no picture on {' and '.join(topics)} within {PICTURE_S:g} s; is the "
                        "camera's driver running?",
                    )
                at = taken()[0]
        finally:
            for subscriber in subscribers:
                subscriber.unregister()
        rgb = read_image(colour[at])
        if rgb.shape[:2] != (view.lens.height, view.lens.width):
            raise AbilityError(
                Code.INTERNAL,
                f"{self._topics.image}: {rgb.shape[1]} x {rgb.shape[0]} px; the design of the cell "
                f"has {view.lens.width} x {view.lens.height}",
            )
        return Picture(rgb, None if at not in depth else depth_of(depth[at]), view)


def _keeper(pictures: dict[rospy.Time, Image]) -> Callable[[Image], None]:
    """Return what stores pictures by their stamps."""

    def keep(message: Image) -> None:
        pictures[message.header.stamp] = message

    return keep


def wrist_view(arm: DrivenArm, design: RobotDesign) -> View:
    """Return where the camera on a hand is."""
    mount = Pose(np.array(CAMERA_MOUNT), np.array([0.0, 0.0, 0.0, 1.0]))
    return View(design.camera.lens, arm.world_from_hand @ mount)
