"""The device port: all that skills use of a robot and of the cell around it.

Lengths are in m, angles in rad, forces in N and times in s; poses, points and forces are in the
frame of the world. Skills command an arm once a tick: the cell's time advances by `tick_s`
whenever a skill yields.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Protocol

from remodel_skills.collision import HeldTip, Touch
from remodel_skills.force_control import ForceLoop
from remodel_work.camera import Picture, View
from remodel_work.geometry import Array
from remodel_work.obstacles import Obstacles
from remodel_work.panel import WireEnd
from remodel_work.robot.arm import ToolPose


class RobotArm(Protocol):
    """An arm with a force sensor at its wrist."""

    @property
    def tool(self) -> ToolPose:
        """The measured tool pose."""

    @property
    def force(self) -> Array:
        """The measured force of the hand on the wrist, its weight included, (3,)."""

    @property
    def hand_mass(self) -> float:
        """What the wrist carries [kg]."""

    def go(self, tool: ToolPose) -> None:
        """Be at a tool pose after a tick; raises AbilityError UNREACHABLE."""

    def go_joints(self, joints: Array) -> None:
        """Be in a posture after a tick, (joints,)."""

    def press(self, loop: ForceLoop) -> None:
        """Move under force control, at the rate of the arm's controller, until another command."""


class Gripper(Protocol):
    """Two fingers, which close until they feel their grip force."""

    @property
    def gap(self) -> float:
        """The measured distance between the pads."""

    @property
    def load(self) -> float:
        """The measured closing force of the weaker finger."""

    def open_to(self, opening: float) -> None:
        """Send each finger so far from the middle."""

    def close_on(self, thickness: float) -> None:
        """Close until the fingers stop on what they grip, about so thick, slowly before it."""


class Camera(Protocol):
    """A calibrated camera."""

    @property
    def view(self) -> View:
        """Where it is now, and its lens."""

    def take(self) -> Picture:
        """Take a picture, with depth if the camera measures it."""


class Fixture(Protocol):
    """What closes and opens a terminal's clamp: a screwdriver, a lever, or a person."""

    def close_clamp(self, component_id: str, terminal_id: str) -> bool:
        """Close a clamp; returns whether it stopped on something before the end of its travel."""

    def open_clamp(self, component_id: str, terminal_id: str) -> None:
        """Open a clamp."""


class Magazine(Protocol):
    """What presents wires, and takes them away: a magazine beside the plate, or a feeder."""

    def open_magazine(self, end: WireEnd) -> None:
        """Open the clips that hold an end; there are others for the other end."""

    def move_fork(self, x: float, y: float) -> None:
        """Bring the feeder's fork up around a wire, along the middle of a channel."""

    def lower_fork(self) -> None:
        """Draw the feeder's fork in."""

    def is_at_hand(self, wire_id: str) -> bool:
        """Return whether a wire can be handled as it lies; a simulator sets placed ones solid."""

    def take_up(self, wire_id: str, tools: Mapping[str, ToolPose]) -> PlacedEnds:
        """Make a placed wire one that can be handled again, no robot busy.

        Args:
            wire_id: which.
            tools: where each robot stands; its fingers are open afterwards.
        """

    def drop(self, over_bin: Array) -> None:
        """Take away what falls from an open hand over the scrap bin, (3,)."""


@dataclass(frozen=True, eq=False)
class PlacedEnds:
    """The ends of a placed wire.

    Attributes:
        expected: where the tip of each is, about, (3,).
        fixed: those in closed clamps.
    """

    expected: Mapping[WireEnd, Array]
    fixed: frozenset[WireEnd]


class CollisionCheck(Protocol):
    """Whether the arm would touch something on a path."""

    def first_touch(
        self,
        path: Callable[[float], ToolPose],
        length: float,
        *,
        obstacles: Sequence[Obstacles],
        finger_gap: float,
        held: HeldTip | None = None,
        allowed: Set[str] = frozenset(),
    ) -> Touch | None:
        """Return where a path comes too near to an obstacle first; None if it is free.

        Args:
            path: of the tool, from 0 to 1; raises UNREACHABLE where the arm does not reach.
            length: of the path, turns of the hand included as its corners move.
            obstacles: to be kept clear of.
            finger_gap: between the pads.
            held: what the hand holds.
            allowed: names of obstacles that may be touched.
        """


@dataclass(frozen=True)
class Device:
    """One robot, and what it shares with the others of its cell.

    Attributes:
        collision_check: of its motions; None: they are not checked.
        tick_s: time between two commands to the arm.
    """

    arm: RobotArm
    gripper: Gripper
    wrist_camera: Camera
    overhead_camera: Camera
    fixture: Fixture
    magazine: Magazine
    collision_check: CollisionCheck | None
    tick_s: float
