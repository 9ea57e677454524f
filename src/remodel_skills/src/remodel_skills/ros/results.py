"""What abilities find out, as fields of their results."""

from __future__ import annotations

import rospy
from genpy import Message
from geometry_msgs.msg import Point, PoseStamped, Quaternion
from remodel_msgs.msg import CableObservation

from remodel_skills.abilities.detect_cable import CableDetected
from remodel_skills.robot_context import AbilityResult
from remodel_work.geometry import WORLD, Pose
from remodel_work.robot.arm import ToolPose


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
        truncated=False,  # a wire that leaves the picture fails
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
