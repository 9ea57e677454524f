"""The device port: all that skills use of a robot and of the cell around it.

Lengths are in m, angles in rad, forces in N and times in s; poses, points and forces are in the
frame of the world. Skills command an arm once a tick: the cell's time advances by `tick_s`
whenever a skill yields.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

from remodel_skills.force_control import ForceLoop
from remodel_work.camera import Picture, View
from remodel_work.cell.cell_design import CellDesign
from remodel_work.cell.presenting import Presentation
from remodel_work.geometry import Array
from remodel_work.panel import Panel, WireEnd
from remodel_work.robot.arm import ToolPose
from remodel_work.routes import ParkedWire


class RobotArm(Protocol):
    """An arm with a force sensor at its wrist."""

    @property
    def tool(self) -> ToolPose:
        """The measured tool pose."""

    @property
    def force(self) -> Array:
        """The measured force of the wrist on the hand, its weight included, (3,)."""

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

    def close_on(self, thickness: float, slow_before: float) -> None:
        """Close until the fingers stop on what they grip, about so thick, slowly before it.

        `slow_before`: from so much more than its thickness between the pads.
        """


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


@dataclass(frozen=True)
class Device:
    """One robot, and what it shares with the others of its cell.

    Attributes:
        tick_s: time between two commands to the arm.
        lead_s: how much later than a tick the arm follows commands; pushes follow at once.
    """

    arm: RobotArm
    gripper: Gripper
    wrist_camera: Camera
    overhead_cameras: tuple[Camera, ...]
    fixture: Fixture
    magazine: Magazine
    tick_s: float
    lead_s: float = 0.0


class Plant(Protocol):
    """A whole cell: its robots, the board that it holds, and its time."""

    design: CellDesign
    tick_s: float

    @property
    def panel(self) -> Panel:
        """What it holds, with its own fixtures, as drawn: components may stand elsewhere."""

    @property
    def loaded(self) -> Panel:
        """The panel that was asked for."""

    @property
    def parked(self) -> Mapping[str, ParkedWire]:
        """The wires that have their place, by name."""

    def device_of(self, robot: str) -> Device:
        """Return a robot of the design, with what it shares with the others."""

    def find_problems(self, panel: Panel) -> tuple[str, ...]:
        """Return why the cell cannot hold a panel, one sentence each; none: it can."""

    def load(self, panel: Panel, placed: Mapping[str, ParkedWire] = MappingProxyType({})) -> None:
        """Hold a panel, with the wires that lie on it; raises PanelError, and nothing changes."""

    def feed(self, wire_id: str, channel_id: str, tools: Mapping[str, ToolPose]) -> Presentation:
        """Present a wire of which no piece is in the cell; the one before has its place.

        Args:
            wire_id: which.
            channel_id: where a feeder lays it; a cell with a magazine has no use for it.
            tools: where each robot stands; its fingers are open afterwards.
        """

    def shapes(self) -> dict[str, ParkedWire]:
        """Return the wires that lie in the cell, by name, the one that is handled among them."""

    def park(self) -> None:
        """Note that the wire that was handled last has its place."""

    def photograph(self, camera: str) -> Picture:
        """Take a picture for people, by a camera of the design: also while a skill runs."""

    def tick(self) -> None:
        """Let the time between two commands pass."""

    def rest(self, seconds: float) -> None:
        """Let robots and wires come to rest for a time."""

    def close(self) -> None:
        """Leave the cell."""
