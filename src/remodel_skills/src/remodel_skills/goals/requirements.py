"""What the fields of a goal must be, whatever the state of the cell."""

from __future__ import annotations

import math

import numpy as np

from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd, unit_x

# A tool pose may tilt so much and still counts as level [rad].
LEVEL_RAD = math.radians(2.0)


def require(condition: bool, message: str) -> None:
    """Raise INVALID_GOAL with a message unless the condition holds."""
    if not condition:
        raise AbilityError(Code.INVALID_GOAL, message)


def require_number(name: str, value: float, low: float, high: float, unit: str) -> None:
    """Raise INVALID_GOAL unless a field is a finite number within limits."""
    allowed = f"allowed: {low:g} to {high:g} {unit}"
    require(math.isfinite(value), f"{name} is {value}; {allowed}")
    require(low <= value <= high, f"{name} is {value:g} {unit}; {allowed}")


def require_pose(name: str, pose: Pose) -> None:
    """Raise INVALID_GOAL unless a pose is finite, and level with a unit quaternion."""
    require(bool(np.isfinite(pose.position).all()), f"{name}: position is not finite")
    require(bool(np.isfinite(pose.quaternion).all()), f"{name}: orientation is not finite")
    norm = float(np.linalg.norm(pose.quaternion))
    require(abs(norm - 1) < 1e-3, f"{name}: the quaternion's length is {norm:.3f}; it must be 1")
    tilt = math.asin(float(np.clip(unit_x(pose)[2], -1, 1)))
    require(
        abs(tilt) < LEVEL_RAD,
        f"{name}: its x axis is tilted by {math.degrees(tilt):.1f} deg; it must be level",
    )


def require_robot(name: str) -> None:
    """Raise INVALID_GOAL when no robot is named; whether the cell has it, the cell knows."""
    require(bool(name.strip()), "robot_name is empty; it must name the robot that does it")


def parse_end(text: str) -> WireEnd:
    """Return the end named "a" or "b"."""
    require(text in ("a", "b"), f"cable_end is {text!r}; allowed: 'a', 'b'")
    return WireEnd(text)
