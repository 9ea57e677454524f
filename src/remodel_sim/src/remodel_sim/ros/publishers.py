"""What the cell publishes besides results: pictures, joint states, forces and frames."""

from __future__ import annotations

import numpy as np
import rospy
from geometry_msgs.msg import TransformStamped, Vector3, WrenchStamped
from sensor_msgs.msg import CameraInfo, Image, JointState
from tf2_ros import StaticTransformBroadcaster, TransformBroadcaster

from remodel_sim.core.camera import Picture
from remodel_sim.core.geometry import Pose
from remodel_sim.core.layout import WORLD_FROM_PANEL
from remodel_sim.physics.plant import OVERHEAD, Plant
from remodel_sim.physics.robot import JOINT_NAMES
from remodel_sim.physics.robot_description import CAMERA_MOUNT
from remodel_sim.ros.conversions import PANEL, WORLD, camera_info, image
from remodel_sim.ros.sim_clock import SimClock

# Joint states, forces and frames are told this often [s of simulated time].
STATE_PERIOD_S = 0.04
HAND = "panda_hand"
OPTICAL_FRAMES = {"overhead": "overhead_optical", "wrist": "wrist_optical"}


class Pictures:
    """Publishes every look, and latched what was found in it."""

    def __init__(self, clock: SimClock) -> None:
        """Advertise the topics of both cameras."""
        self._clock = clock
        self._raw, self._info, self._found = {}, {}, {}
        for camera in OPTICAL_FRAMES:
            topic = f"cell/{camera}"
            self._raw[camera] = rospy.Publisher(f"{topic}/image_raw", Image, queue_size=2)
            self._info[camera] = rospy.Publisher(f"{topic}/camera_info", CameraInfo, queue_size=2)
            self._found[camera] = rospy.Publisher(
                f"{topic}/detections", Image, queue_size=2, latch=True
            )

    def __call__(self, camera: str, picture: Picture, drawing: np.ndarray | None) -> None:
        """Publish a look, or what was found in it."""
        frame, stamp = OPTICAL_FRAMES[camera], self._clock.now
        if drawing is not None:
            self._found[camera].publish(image(drawing, frame, stamp))
            return
        self._raw[camera].publish(image(picture.rgb, frame, stamp))
        self._info[camera].publish(camera_info(picture.view, frame, stamp))


class RobotState:
    """Publishes joint states, the force at the wrist, and frames."""

    def __init__(self, plant: Plant, clock: SimClock) -> None:
        """Tell the frames that never move, once."""
        self._plant = plant
        self._clock = clock
        self._told_s = 0.0
        self._joints = rospy.Publisher("/joint_states", JointState, queue_size=5)
        self._wrench = rospy.Publisher("cell/wrist/wrench", WrenchStamped, queue_size=5)
        self._moving = TransformBroadcaster()
        self._fixed = StaticTransformBroadcaster()
        lens = Pose(np.array(CAMERA_MOUNT), np.array([0.0, 0.0, 0.0, 1.0]))
        self._fixed.sendTransform(
            [
                _transform(WORLD, PANEL, WORLD_FROM_PANEL, clock.now),
                _transform(WORLD, "panda_link0", Pose.level(0, 0, 0), clock.now),
                _transform(
                    WORLD, OPTICAL_FRAMES["overhead"], OVERHEAD.world_from_camera, clock.now
                ),
                _transform(HAND, OPTICAL_FRAMES["wrist"], lens, clock.now),
            ]
        )

    def __call__(self) -> None:
        """Publish when it is time."""
        if self._clock.now_s - self._told_s < STATE_PERIOD_S:
            return
        self._told_s = self._clock.now_s
        message = JointState()
        message.header.stamp = self._clock.now
        message.name = JOINT_NAMES
        message.position, message.velocity = self._plant.robot.joint_state
        self._joints.publish(message)
        wrench = WrenchStamped()
        wrench.header.frame_id, wrench.header.stamp = HAND, self._clock.now
        wrench.wrench.force = Vector3(*self._plant.robot.wrist_force)
        self._wrench.publish(wrench)
        hand = self._plant.robot.world_from_hand
        self._moving.sendTransform(_transform(WORLD, HAND, hand, self._clock.now))


def _transform(parent: str, child: str, pose: Pose, stamp: rospy.Time) -> TransformStamped:
    message = TransformStamped()
    message.header.frame_id, message.header.stamp = parent, stamp
    message.child_frame_id = child
    translation, rotation = message.transform.translation, message.transform.rotation
    translation.x, translation.y, translation.z = (float(v) for v in pose.position)
    rotation.x, rotation.y, rotation.z, rotation.w = (float(v) for v in pose.quaternion)
    return message
