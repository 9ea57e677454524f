"""Frames on tf."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import rospy
from geometry_msgs.msg import TransformStamped
from tf2_ros import StaticTransformBroadcaster

from remodel_work.geometry import WORLD, Pose


def optical_frame(camera: str) -> str:
    """Return the name of a camera's optical frame."""
    return f"{camera}_optical"


class FixedFrames:
    """Publishes frames that do not move, those of goals among them."""

    def __init__(self, now: Callable[[], rospy.Time]) -> None:
        """Advertise the topic."""
        self._now = now
        self._published: dict[str, TransformStamped] = {}
        self._broadcaster = StaticTransformBroadcaster()

    def __call__(self, frames: Mapping[str, Pose], parent: str = WORLD) -> None:
        """Publish frames in their parent, besides those published before."""
        for child, pose in frames.items():
            self._published[child] = transform(parent, child, pose, self._now())
        # Later subscribers get the last message only: it has all of them.
        self._broadcaster.sendTransform(list(self._published.values()))


def transform(parent: str, child: str, pose: Pose, stamp: rospy.Time) -> TransformStamped:
    """Return a frame in its parent as a message."""
    message = TransformStamped()
    message.header.frame_id, message.header.stamp = parent, stamp
    message.child_frame_id = child
    translation, rotation = message.transform.translation, message.transform.rotation
    translation.x, translation.y, translation.z = (float(v) for v in pose.position)
    rotation.x, rotation.y, rotation.z, rotation.w = (float(v) for v in pose.quaternion)
    return message
