"""Parameters of states that need a check or a conversion before they fit into a goal."""

from __future__ import annotations

import math
from collections.abc import Sequence

from geometry_msgs.msg import PoseStamped

_MOST = 255  # of a goal's field of type uint8
PANEL_FRAME = "panel"


def checked_byte(name: str, value: object) -> int:
    """Return the value of a parameter, a whole number that fits into a goal's uint8.

    Raises:
        ValueError: if it does not fit into a goal.
    """
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= _MOST:
        raise ValueError(f"{name} must be a whole number from 0 to {_MOST}, found {value!r}")
    return value


def panel_pose(numbers: Sequence[float]) -> PoseStamped:
    """Return the pose [x, y, z, yaw], [m, m, m, rad], in the panel frame.

    Raises:
        ValueError: if there are not four finite numbers.
    """
    is_list = isinstance(numbers, list | tuple) and len(numbers) == 4
    if not is_list or not all(isinstance(n, int | float) and math.isfinite(n) for n in numbers):
        raise ValueError(f"a pose is [x, y, z, yaw] in finite numbers, found {numbers!r}")
    x, y, z, yaw = numbers
    pose = PoseStamped()
    pose.header.frame_id = PANEL_FRAME
    pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = x, y, z
    pose.pose.orientation.z, pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return pose
