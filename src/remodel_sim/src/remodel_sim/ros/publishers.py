"""What the cell publishes besides results: pictures, joint states, forces and frames."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import rospy
from geometry_msgs.msg import TransformStamped, Vector3, WrenchStamped
from sensor_msgs.msg import CameraInfo, Image, JointState
from tf2_ros import StaticTransformBroadcaster, TransformBroadcaster

from remodel_sim.physics.plant import Plant
from remodel_sim.physics.robot_description import (
    HAND,
    RAIL,
    foot_link,
    robot_description,
)
from remodel_sim.ros.conversions import camera_info
from remodel_sim.ros.sim_clock import SimClock
from remodel_skills.goal_checks import PANEL, WORLD
from remodel_vision.ros.image_message import image
from remodel_work.camera import Picture
from remodel_work.cell.cell_design import CellDesign, RobotDesign
from remodel_work.geometry import Pose
from remodel_work.robot.fingers import CAMERA_MOUNT
from remodel_work.robot.kinematics import Kinematics

# Joint states, forces and frames are published this often [s of simulated time].
STATE_PERIOD_S = 0.04


class Pictures:
    """Publishes every picture, and latched what was found in it."""

    def __init__(self, design: CellDesign, clock: SimClock) -> None:
        """Advertise the topics of the cameras that abilities use."""
        self._clock = clock
        self._raw, self._info, self._found = {}, {}, {}
        for camera in ("overhead", *(robot.camera.name for robot in design.robots)):
            topic = f"cell/{camera}"
            self._raw[camera] = rospy.Publisher(f"{topic}/image_raw", Image, queue_size=2)
            self._info[camera] = rospy.Publisher(f"{topic}/camera_info", CameraInfo, queue_size=2)
            self._found[camera] = rospy.Publisher(
                f"{topic}/detections", Image, queue_size=2, latch=True
            )

    def __call__(self, camera: str, picture: Picture, drawing: np.ndarray | None) -> None:
        """Publish a picture, or what was found in it."""
        frame, stamp = optical_frame(camera), self._clock.now
        if drawing is not None:
            self._found[camera].publish(image(drawing, frame, stamp))
            return
        self._raw[camera].publish(image(picture.rgb, frame, stamp))
        self._info[camera].publish(camera_info(picture.view, frame, stamp))


def optical_frame(camera: str) -> str:
    """Return the name of a camera's optical frame."""
    return f"{camera}_optical"


class FixedFrames:
    """Publishes frames that do not move, those of goals among them."""

    def __init__(self, clock: SimClock) -> None:
        """Advertise the topic."""
        self._clock = clock
        self._published: dict[str, TransformStamped] = {}
        self._broadcaster = StaticTransformBroadcaster()

    def __call__(self, frames: Mapping[str, Pose], parent: str = WORLD) -> None:
        """Publish frames in their parent, besides those published before."""
        for child, pose in frames.items():
            self._published[child] = _transform(parent, child, pose, self._clock.now)
        # Later subscribers get the last message only: it has all of them.
        self._broadcaster.sendTransform(list(self._published.values()))


class RobotState:
    """Publishes joint states, the forces at the wrists, and frames."""

    def __init__(self, plant: Plant, clock: SimClock, fixed: FixedFrames) -> None:
        """Publish the frames that never move, once."""
        self._plant = plant
        self._clock = clock
        self._published_s = 0.0
        robots = {robot.name: _described(robot) for robot in plant.design.robots}
        rospy.set_param("cell/robots", robots)
        self._joints = rospy.Publisher("/joint_states", JointState, queue_size=5)
        self._wrenches = {
            robot.name: rospy.Publisher(
                f"cell/{robot.camera.name}/wrench", WrenchStamped, queue_size=5
            )
            for robot in plant.design.robots
        }
        self._moving = TransformBroadcaster()
        overhead = plant.design.overhead.world_from_camera
        fixed({PANEL: plant.panel.world_from_panel, optical_frame("overhead"): overhead})
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
                [_transform(WORLD, frame, pose, self._clock.now) for frame, pose in moving.items()]
            )
        self._joints.publish(message)


def _described(robot: RobotDesign) -> dict[str, str]:
    """Return what a viewer draws a robot by: its URDF, and what precedes its names elsewhere."""
    return {"description": robot_description(robot.arm), "prefix": robot.prefix}


def _foot(arm: Kinematics) -> str:
    """Return the link of a robot that is bolted down."""
    return foot_link(arm) if arm.axis is None else RAIL


def _transform(parent: str, child: str, pose: Pose, stamp: rospy.Time) -> TransformStamped:
    message = TransformStamped()
    message.header.frame_id, message.header.stamp = parent, stamp
    message.child_frame_id = child
    translation, rotation = message.transform.translation, message.transform.rotation
    translation.x, translation.y, translation.z = (float(v) for v in pose.position)
    rotation.x, rotation.y, rotation.z, rotation.w = (float(v) for v in pose.quaternion)
    return message
