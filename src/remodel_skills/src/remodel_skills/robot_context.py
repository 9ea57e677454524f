"""What an ability may use of one robot of the cell, who observes it, and how it is run."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from remodel_skills.belief_state import BeliefState
from remodel_skills.device import Device
from remodel_skills.force_control import ForceLoop
from remodel_skills.parameters import Parameters
from remodel_skills.space import CollisionCheck, Scene, Space, Traffic
from remodel_work.camera import Picture, View, best_view, overhead_name
from remodel_work.cell.cell_design import CellDesign, RobotDesign
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Panel, PanelWire
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.fingers import Fingers

Image = npt.NDArray[np.uint8]
# Called after every observation: camera, picture, and what was found drawn into it (None before it
# is known).
OnObservation = Callable[[str, Picture, Image | None], None]

# Called with poses in the world, by the names of their frames, that a goal asks to be shown.
OnFrames = Callable[[Mapping[str, Pose]], None]


@dataclass(frozen=True)
class Observers:
    """Callbacks that receive what abilities observe and intend; they change nothing.

    Attributes:
        on_observation: called after every observation.
        on_frames: called with the poses that a goal asks to show.
    """

    on_observation: OnObservation | None = None
    on_frames: OnFrames | None = None

    def show_frames(self, frames: Mapping[str, Pose]) -> None:
        """Show poses in the world, by the names of their frames."""
        if self.on_frames is not None:
            self.on_frames(frames)


class Cameras:
    """The cameras of one robot; the observers receive every picture."""

    def __init__(
        self, device: Device, wrist: str, belief: BeliefState, observers: Observers
    ) -> None:
        """Take pictures by a device, whose wrist camera has a name."""
        self._device, self._wrist = device, wrist
        self._belief, self._observers = belief, observers

    def overhead_view(self, points: Array) -> View:
        """Return where the overhead camera is that shows points (n, 3) [m] best."""
        return self._device.overhead_cameras[self._best(points)].view

    @property
    def wrist_view(self) -> View:
        """Where the wrist camera is, by the arm's own measure."""
        return self._device.wrist_camera.view

    def take_overhead_picture(self, points: Array) -> Picture:
        """Take a colour and depth picture by the camera that shows points (n, 3) [m] best.

        Before the live wire is touched, each of the others takes one, too, for comparisons later.
        """
        best = self._best(points)
        belief = self._belief
        if belief.feed is not None and not belief.is_touched:
            for number, camera in enumerate(self._device.overhead_cameras):
                if number != best and belief.board_before(camera.view) is None:
                    self._take_from_above(number)
        return self._take_from_above(best)

    def take_overhead_pictures(self, points: Array | None = None) -> tuple[Picture, ...]:
        """Take pictures by those cameras that each show one of points (n, 3) [m] best.

        None: by all of them, which together show the whole plate.
        """
        numbers = set(range(len(self._device.overhead_cameras)))
        if points is not None:
            numbers = {self._best(point[None]) for point in points}
        return tuple(self._take_from_above(number) for number in sorted(numbers))

    def _best(self, points: Array) -> int:
        return best_view([camera.view for camera in self._device.overhead_cameras], points)

    def _take_from_above(self, number: int) -> Picture:
        picture = self._device.overhead_cameras[number].take()
        self._belief.note_board(picture)
        return self._observed(overhead_name(number), picture)

    def take_wrist_picture(self) -> Picture:
        """Take a picture from the hand, with depth if its camera measures it."""
        return self._observed(self._wrist, self._device.wrist_camera.take())

    def _observed(self, camera: str, picture: Picture) -> Picture:
        if self._observers.on_observation is not None:
            self._observers.on_observation(camera, picture, None)
        return picture

    def show(self, camera: str, picture: Picture, drawing: Image) -> None:
        """Show what was found in a picture of a camera, "overhead" or "wrist": this robot's.

        Of several overhead cameras people see one picture after the other at the same place.
        """
        if self._observers.on_observation is not None:
            name = self._wrist if camera == "wrist" else camera
            self._observers.on_observation(name, picture, drawing)


T = TypeVar("T")
# An ability is a generator: each `yield` lets the cell advance by one tick; what it returns is its
# result.
Steps = Generator[None, None, T]


@dataclass
class Progress:
    """The progress of an ability; its share never decreases.

    Attributes:
        message: the step being done.
        share: 0 to 1.
    """

    message: str = ""
    share: float = 0.0


class RobotContext:
    """One robot: its device, what the cell believes, the space that it claims, and what it does.

    Nothing here returns ground truth.

    Attributes:
        name: of the robot.
        device: its sensors and actuators.
        cell: the design of the cell.
        design: of the robot in it.
        arm: its kinematics.
        home: where the empty hand waits, out of the overhead camera's picture.
        robots: the contexts of all robots of the cell, by name.
        panel: as drawn: components may stand elsewhere.
        belief: what the cell believes from its own actions and observations.
        scene: what the robot must not touch.
        space: what it claims among the other robots.
        observers: who receives what abilities observe and intend.
        parameters: the numbers of its skills.
        cameras: its pictures, which the observers receive as well.
        tick_s: time between two commands to the arm [s].
        lead_ticks: so many ticks later than one tick a motion follows its commands.
        busy: whether the robot does something.
        progress: of the ability that runs.
        keeps_wire: whether its closed eyelet keeps the live wire in its duct.
        commanded: where the tool was sent.
        fingers_open_to: how far each finger was sent from the middle [m].
        empty_force: what the wrist felt, world frame (3,) [N], when the hand was last empty: the
            hand always points down, so its weight reads the same everywhere.
        free_force: the same when it last pushed nothing: with a wire in it, that may pull at it.
    """

    def __init__(
        self,
        device: Device,
        cell: CellDesign,
        design: RobotDesign,
        panel: Panel,
        belief: BeliefState,
        robots: Mapping[str, RobotContext],
        traffic: Traffic,
        observers: Observers,
        parameters: Parameters,
        check: CollisionCheck | None = None,
    ) -> None:
        """Take over a robot of a cell in which nothing has happened yet.

        `check` is of its motions; None: they are not checked.
        """
        self.device, self.cell, self.design = device, cell, design
        self.name, self.arm, self.home = design.name, design.arm, design.home
        self.robots, self.panel, self.belief = robots, panel, belief
        self.scene = Scene(device, panel, belief, check)
        self.space = Space(design.name, design.arm, traffic, robots)
        self.observers, self.parameters = observers, parameters
        self.cameras = Cameras(device, design.camera.name, belief, observers)
        self.tick_s = device.tick_s
        self.lead_ticks = math.ceil(device.lead_s / device.tick_s - 1e-6)
        self.busy = self.keeps_wire = False
        self.progress = Progress()
        self.commanded = self.home
        self.space.stand(self.home)
        self.empty_force = self.free_force = device.arm.force
        self.arm_restarted()

    @property
    def fingers(self) -> Fingers:
        """What its hand grips with."""
        return self.arm.fingers

    @property
    def peers(self) -> list[RobotContext]:
        """The cell's other robots."""
        return [context for name, context in self.robots.items() if name != self.name]

    @property
    def wire(self) -> PanelWire:
        """The live wire as ordered."""
        return self.scene.wire

    def begin(self) -> None:
        """Note that the robot begins to do something."""
        self.busy, self.progress = True, Progress()

    def end(self) -> None:
        """Note that the robot has stopped, and release all space but that of its posture."""
        self.busy = False
        self.space.wait_for(None)
        self.space.stand(self.commanded)

    def report(self, message: str, share: float) -> None:
        """Report what is being done, and its progress from 0 to 1."""
        self.progress = Progress(message, max(self.progress.share, share))

    def follow(self, tool: ToolPose) -> None:
        """Command a tool pose on a path whose space is claimed; raises UNREACHABLE."""
        self.device.arm.go(tool)
        self.commanded = tool

    def drive(self, tool: ToolPose) -> None:
        """Command a tool pose near contact; raises UNREACHABLE, or ROBOT_IN_THE_WAY and stops."""
        self.space.check(tool, self.commanded)
        self.follow(tool)

    def press(self, loop: ForceLoop, tool: ToolPose) -> None:
        """Let the arm's controller move near a tool pose under force control.

        Until another command; raises UNREACHABLE or ROBOT_IN_THE_WAY.
        """
        self.space.check(tool, self.commanded)
        self.device.arm.press(loop)
        self.commanded = tool

    def drive_joints(self, joints: Array) -> None:
        """Command the arm's joints; joints 3 and 5 stay at zero."""
        self.device.arm.go_joints(joints)
        self.commanded = self.arm.tool_of(joints)

    def drive_fingers(self, opening: float) -> None:
        """Send each finger to a distance from the middle [m]."""
        self.device.gripper.open_to(opening)
        self.fingers_open_to = opening

    def close_fingers(self, thickness: float) -> None:
        """Close the fingers until they stop on what they grip, about so thick [m]."""
        self.device.gripper.close_on(thickness, self.parameters.tool.slow_before_m)
        self.fingers_open_to = 0.0

    def arm_restarted(self) -> None:
        """Note that the arm stands where it was sent, its fingers open."""
        self.fingers_open_to = self.device.gripper.gap / 2


def occupy(contexts: Sequence[RobotContext], steps: Steps[T]) -> Steps[T]:
    """Run an ability's steps, its robots marked busy until it ends."""
    for context in contexts:
        context.begin()
    try:
        return (yield from steps)
    finally:
        for context in contexts:
            context.end()


def run(tick: Callable[[], None], steps: Steps[T]) -> T:
    """Run steps to their end, a tick of the cell after each, and return their result.

    Raises what they raise.
    """
    while True:
        try:
            next(steps)
        except StopIteration as done:
            return done.value
        tick()
