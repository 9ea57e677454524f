"""Poses in goal messages."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose

# A ROS message: the core imports none, and generated messages have no types.
Message: TypeAlias = Any

WORLD = "world"
PANEL = "panel"


def pose_from(name: str, message: Message, board: Pose) -> Pose:
    """Return the pose of a field of type geometry_msgs/PoseStamped in the world frame.

    It may be given in the world's frame (which an empty name means) or in that of the panel, which
    is at `board`.

    Raises:
        AbilityError: if it is given in another one.
    """
    frame = message.header.frame_id.lstrip("/")
    if frame not in ("", WORLD, PANEL):
        raise AbilityError(
            Code.INVALID_GOAL,
            f"{name} is given in frame {frame!r}; allowed: {WORLD!r}, {PANEL!r}",
        )
    p, q = message.pose.position, message.pose.orientation
    pose = Pose(np.array([p.x, p.y, p.z]), np.array([q.x, q.y, q.z, q.w]))
    return board @ pose if frame == PANEL else pose
