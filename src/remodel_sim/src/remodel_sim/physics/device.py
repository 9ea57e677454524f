"""A robot of the simulated cell as a device of the port `remodel_skills.device`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from remodel_sim.physics.robot import TOUCH_GAP, Robot
from remodel_skills.force_control import ForceLoop
from remodel_work.camera import Picture, View
from remodel_work.cell.cell_design import RobotDesign
from remodel_work.geometry import Array
from remodel_work.robot.arm import ToolPose


class _Plant(Protocol):
    """Where robots are; it builds them for every wire."""

    steps_per_tick: int

    @property
    def robots(self) -> Mapping[str, Robot]:
        """By name."""


class SimulatedArm:
    """The arm of a robot in the plant, which rebuilds it for every wire."""

    def __init__(self, plant: _Plant, design: RobotDesign) -> None:
        """Name the robot."""
        self._plant, self._name, self._arm = plant, design.name, design.arm

    @property
    def _robot(self) -> Robot:
        return self._plant.robots[self._name]

    @property
    def tool(self) -> ToolPose:
        """The measured tool pose."""
        return self._robot.tool

    @property
    def force(self) -> Array:
        """The measured force of the wrist on the hand, low-passed, world frame, (3,) [N]."""
        robot = self._robot
        return robot.world_from_hand.rotation @ robot.wrist_force

    @property
    def hand_mass(self) -> float:
        """What the wrist carries [kg]."""
        return self._robot.hand_mass

    def go(self, tool: ToolPose) -> None:
        """Be at a tool pose after a tick; raises AbilityError UNREACHABLE."""
        self.go_joints(self._arm.joints_for(tool))

    def go_joints(self, joints: Array) -> None:
        """Be in a posture after a tick, (joints,)."""
        self._robot.drive(joints, self._plant.steps_per_tick)

    def press(self, loop: ForceLoop) -> None:
        """Move under force control at each step of the physics, until another command."""
        self._robot.drive_by(loop.step)


class SimulatedGripper:
    """The fingers of a robot in the plant."""

    def __init__(self, plant: _Plant, name: str) -> None:
        """Name the robot."""
        self._plant, self._name = plant, name

    @property
    def _robot(self) -> Robot:
        return self._plant.robots[self._name]

    @property
    def gap(self) -> float:
        """The measured distance between the pads [m]."""
        return self._robot.finger_gap

    @property
    def load(self) -> float:
        """The measured closing force of the weaker finger [N]."""
        return self._robot.finger_load

    def open_to(self, opening: float) -> None:
        """Send each finger to a distance from the middle [m]."""
        self._robot.drive_fingers(opening)

    def close_on(self, thickness: float, slow_before: float) -> None:
        """Close until the fingers stop on what they grip, about so thick, slowly before it [m]."""
        self._robot.drive_fingers(0.0, max(TOUCH_GAP, thickness + slow_before))


@dataclass(frozen=True)
class SimulatedCamera:
    """A camera of the plant, by what it sees from and what it sees."""

    see_from: Callable[[], View]
    see: Callable[[], Picture]

    @property
    def view(self) -> View:
        """Where it is now."""
        return self.see_from()

    def take(self) -> Picture:
        """Take a picture."""
        return self.see()
