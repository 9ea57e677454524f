"""Poses that charts give as numbers."""

import math
from collections.abc import Sequence

from geometry_msgs.msg import PoseStamped

PANEL_FRAME = "panel"


def panel_pose(numbers: Sequence[float]) -> PoseStamped:
    """Return the pose [x, y, z, yaw], [m, m, m, rad], in the panel frame.

    Raises:
        ValueError: if there are not four finite numbers.
    """
    if len(numbers) != 4 or not all(math.isfinite(number) for number in numbers):
        raise ValueError(f"a pose is [x, y, z, yaw] in finite numbers, found {numbers!r}")
    x, y, z, yaw = numbers
    pose = PoseStamped()
    pose.header.frame_id = PANEL_FRAME
    pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = x, y, z
    pose.pose.orientation.z, pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return pose
