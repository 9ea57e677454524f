"""Kinematics of a robot whose tool always points straight down, at a level panel.

The arms here have seven joints that turn and bend in turn. With joints 3 and 5 at zero such an arm
moves in one vertical plane through its base, turned by joint 1. Then a downward tool is a planar
two-link problem with one solution (elbow up), and joint 7 sets the tool's yaw alone. An arm on a
linear axis has the axis's position before the seven angles in its vector of joints: one joint more
than a place of the tool needs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose, wrap_angle
from remodel_work.robot.fingers import PANDA_FINGERS, Fingers


@dataclass(frozen=True)
class ToolPose:
    """The tool centre with the tool pointing down; world frame.

    Attributes:
        x, y, z: tool centre [m].
        yaw: direction of the hand's x axis [rad]; the fingers close across it. Not wrapped: a path
            turns from one value to the next the way the numbers say.
    """

    x: float
    y: float
    z: float
    yaw: float

    @property
    def position(self) -> Array:
        """The tool centre, (3,) [m]."""
        return np.array([self.x, self.y, self.z])

    def at(self, *, z: float) -> ToolPose:
        """Return the same pose at another height."""
        return ToolPose(self.x, self.y, z, self.yaw)

    def moved(self, direction: Array, distance: float) -> ToolPose:
        """Return the pose moved by a distance [m] along a unit vector, (3,)."""
        x, y, z = (float(v) for v in self.position + distance * direction)
        return ToolPose(x, y, z, self.yaw)

    def __str__(self) -> str:
        """Show millimetres and degrees."""
        return (
            f"x {self.x * 1e3:.0f}, y {self.y * 1e3:.0f}, z {self.z * 1e3:.0f} mm, "
            f"yaw {math.degrees(wrap_angle(self.yaw)):.0f} deg"
        )


class Kinematics(Protocol):
    """What an ability needs to know of a robot in its place; `Arm` and `Portal` are."""

    @property
    def base(self) -> tuple[float, float, float, float]:
        """(x, y, z) [m] and yaw [rad] of its base in the world."""

    @property
    def fingers(self) -> Fingers:
        """On its hand."""

    @property
    def axis(self) -> LinearAxis | None:
        """The axis that carries the base; None: it is bolted down."""

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lower and upper limits of all joints, (joints,) each [m, rad]."""

    @property
    def speeds(self) -> Array:
        """Greatest speeds of all joints, (joints,) [m/s, rad/s]; the last one turns the hand."""

    @property
    def world_from_base(self) -> Pose:
        """Where its base stands."""

    def joints_for(self, tool: ToolPose) -> Array:
        """Return the joints (joints,) for a tool pose; raises UNREACHABLE."""

    def reaches(self, tool: ToolPose) -> bool:
        """Return whether it reaches a tool pose."""

    def tool_of(self, joints: Array) -> ToolPose:
        """Return the tool pose of a posture, (joints,)."""

    def canonical_yaw(self, x: float, y: float, yaw: float) -> float | None:
        """Return the tool's yaw as the value for which its last joint is linear, or None."""

    def last_joint(self, x: float, y: float, canonical: float) -> float:
        """Return the last joint [rad] for a canonical yaw at a place."""


# The rule's corners are rounded over about so much of the tool's way [m].
ROUNDING_M = 0.06


@dataclass(frozen=True)
class LinearAxis:
    """An axis along y of the arm's base.

    Its position follows from the place of the tool alone, by a smooth rule, so that a straight line
    of the tool is one smooth motion of all joints, and a place always has the same posture:

    - The arm stands level with the tool, which it then reaches straight ahead.
    - What is nearer to the axis than the arm can fold it reaches obliquely: the arm stands aside by
      as much as the tool is too near, towards the end of the axis that has the longer travel.

    Attributes:
        lower, upper: limits of its position [m]; at 0 the arm stands where its base is given.
        speed: it moves no faster [m/s].
    """

    lower: float
    upper: float
    speed: float

    def position_for(self, x: float, y: float, near: float) -> float:
        """Return the axis's position for a place of the tool in the base's frame [m].

        `near`: the arm reaches what is so far away or further [m]. The hypotenuse over x and the
        step aside, near * sqrt(2) - x, is never shorter.
        """
        aside = _positive_part(near * math.sqrt(2.0) - x)
        position = y + (aside if self.upper > -self.lower else -aside)
        position = self.upper - _positive_part(self.upper - position)
        position = self.lower + _positive_part(position - self.lower)
        return min(self.upper, position)


def _positive_part(value: float) -> float:
    """Return a value [m] where it is positive and zero elsewhere, rounded near zero."""
    return (value + math.hypot(value, ROUNDING_M)) / 2


@dataclass(frozen=True)
class ArmModel:
    """What arms of one type have in common.

    Attributes:
        name: of the type.
        shoulder_height: of joint 2 above the base [m].
        upper: shoulder to elbow, (along, across) [m].
        fore: elbow to wrist, (along, back across) [m].
        wrist_offset: from the wrist outward to the flange's axis [m].
        flange: from the wrist down to the flange [m].
        wrist_sign, wrist_zero: joint 6 is sign * (q2 - q4) + zero [rad] when the tool points down.
        yaw_zero: direction of the hand's x axis from the arm's plane when joint 7 is at zero [rad].
        lower, higher: limits of joints 1 to 7 [rad].
    """

    name: str
    shoulder_height: float
    upper: tuple[float, float]
    fore: tuple[float, float]
    wrist_offset: float
    flange: float
    wrist_sign: float
    wrist_zero: float
    yaw_zero: float
    lower: tuple[float, ...]
    higher: tuple[float, ...]

    @property
    def upper_m(self) -> float:
        """Straight distance from shoulder to elbow [m]."""
        return math.hypot(*self.upper)

    @property
    def upper_rad(self) -> float:
        """Angle between that straight line and the upper link [rad]."""
        return math.atan2(self.upper[1], self.upper[0])

    @property
    def fore_m(self) -> float:
        """Straight distance from elbow to wrist [m]."""
        return math.hypot(*self.fore)

    @property
    def fore_rad(self) -> float:
        """Angle between that straight line and the fore link [rad]."""
        return math.atan2(self.fore[1], self.fore[0])


# [rad/s]; the Panda's joints 1 to 4 allow 2.17.
JOINT_SPEED = 2.0
# The rule of a linear axis keeps the wrist so far beyond where the arm is folded entirely [m].
UNFOLDED_M = 0.03

# Lengths and soft limits: https://frankaemika.github.io/docs/control_parameters.html.
FRANKA_PANDA = ArmModel(
    name="franka_panda",
    shoulder_height=0.333,
    upper=(0.316, 0.0825),
    fore=(0.384, 0.0825),
    wrist_offset=0.088,
    flange=0.107,
    wrist_sign=1.0,
    wrist_zero=0.0,
    yaw_zero=math.pi / 4,
    lower=(-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973),
    higher=(2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973),
)
# LBR iiwa 7 R800 (KUKA's data sheet, and kuka_iiwa/model.urdf of pybullet_data): 170, 120 and 175
# degrees of its joints. The hand is bolted on so that its zero yaw is the Panda's.
KUKA_IIWA = ArmModel(
    name="kuka_iiwa",
    shoulder_height=0.360,
    upper=(0.420, 0.0),
    fore=(0.400, 0.0),
    wrist_offset=0.0,
    flange=0.126,
    wrist_sign=-1.0,
    wrist_zero=math.pi,
    yaw_zero=math.pi / 4,
    lower=(-2.9671, -2.0944, -2.9671, -2.0944, -2.9671, -2.0944, -3.0543),
    higher=(2.9671, 2.0944, 2.9671, 2.0944, 2.9671, 2.0944, 3.0543),
)
ARM_MODELS = {model.name: model for model in (FRANKA_PANDA, KUKA_IIWA)}


@dataclass(frozen=True)
class Arm:
    """An arm in its place, with fingers on its hand.

    Attributes:
        model: its type.
        base: (x, y, z) [m] and yaw [rad] of its base in the world; the base is level.
        lower, higher: limits of joints 1 to 7 in this place [rad]; empty: the model's.
        fingers: on the Panda's hand, which every arm carries.
        axis: that carries the base; None: it is bolted down.
    """

    model: ArmModel
    base: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    lower: tuple[float, ...] = ()
    higher: tuple[float, ...] = ()
    fingers: Fingers = PANDA_FINGERS
    axis: LinearAxis | None = None

    @cached_property
    def limits(self) -> tuple[Array, Array]:
        """Lower and upper limits of all joints, (7,) each [rad], of an axis first [m]."""
        lower, higher = self.lower or self.model.lower, self.higher or self.model.higher
        if self.axis is not None:
            lower, higher = (self.axis.lower, *lower), (self.axis.upper, *higher)
        return np.array(lower), np.array(higher)

    @cached_property
    def speeds(self) -> Array:
        """Greatest speeds of all joints, (7,) [rad/s], of an axis first [m/s]."""
        return np.array([*([] if self.axis is None else [self.axis.speed]), *[JOINT_SPEED] * 7])

    @cached_property
    def near_m(self) -> float:
        """How near to its first joint's axis the arm reaches, the wrist level with the shoulder."""
        model = self.model
        lower, _ = self.limits
        bend = min(math.pi, -float(lower[-4]) - model.upper_rad - model.fore_rad)
        upper, fore = model.upper_m, model.fore_m
        wrist = math.sqrt(upper**2 + fore**2 + 2 * upper * fore * math.cos(bend))
        return wrist + model.wrist_offset + UNFOLDED_M

    @property
    def world_from_base(self) -> Pose:
        """Where its base stands, that of its axis if it has one."""
        return Pose.level(*self.base)

    def first_joint_at(self, postures: Array) -> tuple[Array, Array, float]:
        """Return x and y of the first joint in postures, (..., joints) to (...) [m], and its z."""
        x, y, z, yaw = self.base
        travel = np.zeros(postures.shape[:-1]) if self.axis is None else postures[..., 0]
        return x - travel * math.sin(yaw), y + travel * math.cos(yaw), z

    def _from_first_joint(self, x: float, y: float) -> tuple[float, float]:
        """Return a place from the first joint when the tool is there, along the base's axes [m]."""
        ahead, aside = self._in_base(x, y)
        return ahead, aside - self._travel_to(x, y)

    def _travel_to(self, x: float, y: float) -> float:
        """Return the position of the axis for a place of the tool [m]; 0 without an axis."""
        if self.axis is None:
            return 0.0
        return self.axis.position_for(*self._in_base(x, y), near=self.near_m)

    def _in_base(self, x: float, y: float) -> tuple[float, float]:
        """Return a place on the level plane in the base's frame [m]."""
        base_x, base_y, _, yaw = self.base
        c, s = math.cos(yaw), math.sin(yaw)
        dx, dy = x - base_x, y - base_y
        return c * dx + s * dy, c * dy - s * dx

    def joints_for(self, tool: ToolPose) -> Array:
        """Return the arm's joint angles (7,) [rad] for a tool pose, before them an axis's [m].

        Raises:
            AbilityError: UNREACHABLE, with the joint or distance that stands against it.
        """
        model = self.model
        upper_m, fore_m = model.upper_m, model.fore_m
        x, y = self._from_first_joint(tool.x, tool.y)
        azimuth = math.atan2(y, x)
        out = math.hypot(x, y) - model.wrist_offset
        up = tool.z - self.base[2] + self.fingers.tool_m + model.flange - model.shoulder_height
        distance = math.hypot(out, up)
        cosine = (distance**2 - upper_m**2 - fore_m**2) / (2 * upper_m * fore_m)
        if not -1.0 <= cosine <= 1.0:
            raise AbilityError(
                Code.UNREACHABLE,
                f"no arm posture reaches {tool}: the wrist would be {distance:.3f} m from the "
                f"shoulder, the arm spans {abs(upper_m - fore_m):.3f} to {upper_m + fore_m:.3f} m",
            )
        bend = math.acos(cosine)
        lean = math.atan2(out, up) - math.atan2(
            fore_m * math.sin(bend), upper_m + fore_m * math.cos(bend)
        )
        q2 = lean - model.upper_rad
        q4 = -(bend + model.upper_rad + model.fore_rad)
        q6 = model.wrist_sign * (q2 - q4) + model.wrist_zero
        q7 = wrap_angle(azimuth + model.yaw_zero - (tool.yaw - self.base[3]))
        joints = np.array([azimuth, q2, 0.0, q4, 0.0, q6, q7])
        lower, higher = (limits[-7:] for limits in self.limits)
        beyond = np.flatnonzero((joints < lower) | (joints > higher))
        if beyond.size:
            i = int(beyond[0])
            raise AbilityError(
                Code.UNREACHABLE,
                f"no arm posture reaches {tool}: joint {i + 1} would stand at {joints[i]:.2f} rad, "
                f"allowed {lower[i]:.2f} to {higher[i]:.2f}",
            )
        if self.axis is None:
            return joints
        return np.array([self._travel_to(tool.x, tool.y), *joints])

    def reaches(self, tool: ToolPose) -> bool:
        """Return whether the arm reaches a tool pose within its joint limits."""
        try:
            self.joints_for(tool)
        except AbilityError:
            return False
        return True

    def tool_of(self, joints: Array) -> ToolPose:
        """Return the tool pose of a downward posture, (joints,) with joints 3 and 5 at zero."""
        q1, q2, _, q4, _, _, q7 = joints[-7:]
        model = self.model
        fore = q2 - q4
        out = (
            model.wrist_offset
            + model.upper_m * math.sin(q2 + model.upper_rad)
            + model.fore_m * math.sin(fore - model.fore_rad)
        )
        up = (
            model.shoulder_height
            + model.upper_m * math.cos(q2 + model.upper_rad)
            + model.fore_m * math.cos(fore - model.fore_rad)
        )
        x, y, z = self.first_joint_at(joints)
        yaw = self.base[3]
        heading = yaw + q1
        return ToolPose(
            float(x) + out * math.cos(heading),
            float(y) + out * math.sin(heading),
            z + up - model.flange - self.fingers.tool_m,
            heading + model.yaw_zero - q7,
        )

    def canonical_yaw(self, x: float, y: float, yaw: float) -> float | None:
        """Return the tool's yaw as the value for which joint 7 is linear, or None beyond limits.

        Two canonical yaws differ by the turn that joint 7 really makes, be it the long way round.
        """
        zero = self._zero_yaw(x, y)
        q7 = wrap_angle(zero - yaw)
        lower, higher = self.limits
        if not lower[-1] <= q7 <= higher[-1]:
            return None
        return zero - q7

    def last_joint(self, x: float, y: float, canonical: float) -> float:
        """Return joint 7 [rad] for a canonical yaw at a place."""
        return self._zero_yaw(x, y) - canonical

    def _zero_yaw(self, x: float, y: float) -> float:
        """Return the tool's yaw at a place when joint 7 is at zero [rad]."""
        return self._heading(x, y) + self.model.yaw_zero

    def _heading(self, x: float, y: float) -> float:
        """Return the direction of the arm's plane for a place, in the world [rad]."""
        here_x, here_y = self._from_first_joint(x, y)
        return self.base[3] + math.atan2(here_y, here_x)


PANDA_AT_ORIGIN = Arm(FRANKA_PANDA)
