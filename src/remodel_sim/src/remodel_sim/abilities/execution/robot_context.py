"""What an ability may use.

The arm, its sensors, the cameras, the clamps' drives, the panel's drawing and the belief state.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Set
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from remodel_sim.abilities.execution.observers import Image, Observers
from remodel_sim.core.belief.belief_state import NO_CHANNEL, BeliefState, Feed, Grip
from remodel_sim.core.robot.traffic import Traffic
from remodel_sim.physics.collision_check import HeldTip, Touch
from remodel_sim.physics.plant import Plant
from remodel_sim.physics.robot import TOUCH_GAP, Controller, Robot
from remodel_states.core.codes import Code
from remodel_vision.board.standing import standing_wires
from remodel_work.camera import Picture, View
from remodel_work.cell.cell_design import RobotDesign
from remodel_work.cell.feeding import resting_place
from remodel_work.cell.magazine import plan_presentation
from remodel_work.cell.scrap_bin import bin_of
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose
from remodel_work.layout import WORLD_FROM_PANEL
from remodel_work.obstacles import Obstacles, panel_obstacles
from remodel_work.panel import Panel, PanelWire, WireEnd
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.arm_volume import volume_of
from remodel_work.robot.fingers import Fingers

# Commands to the arm and checks of its sensors [1/s].
TICK_HZ = 120.0

# The fingers are slow from so much before what they grip [m].
TOUCH_BEFORE_M = 0.002

T = TypeVar("T")
# An ability is a generator: each `yield` lets the cell advance by one tick; what it returns is its
# result.
Steps = Generator[None, None, T]


class AbilityResult(Protocol):
    """What an ability returns: what it did, and fields named as in its action's result."""

    message: str


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
    """The abilities' only access to the plant, for one robot of the cell.

    Nothing here returns ground truth.

    Attributes:
        name: of the robot.
        busy: whether the robot does something.
        keeps_wire: whether its closed eyelet keeps the live wire in its duct.
        robots: the contexts of all robots of the cell, by name.
        arm: its kinematics.
        home: where the empty hand waits, out of the overhead camera's picture.
        belief: what the cell believes from its own actions and observations.
        progress: of the ability that runs.
        tick_s: time between two commands to the arm [s].
        empty_force: what the wrist felt, world frame (3,) [N], when the hand was last empty: the
            hand always points down, so its weight reads the same everywhere.
        free_force: the same when it last pushed nothing: with a wire in it, that may pull at it.
    """

    def __init__(
        self,
        plant: Plant,
        design: RobotDesign,
        belief: BeliefState,
        robots: Mapping[str, RobotContext],
        traffic: Traffic,
        observers: Observers,
    ) -> None:
        """Take over a robot of a freshly built plant."""
        self._plant = plant
        self._design = design
        self._camera = design.camera.name
        self._observers = observers
        self.name, self.arm, self.home = design.name, design.arm, design.home
        self.belief = belief
        self.busy = self.keeps_wire = False
        self.robots = robots
        self._traffic = traffic
        self.progress = Progress()
        # Panel, located components, and the obstacles that follow from them; a picture, and the
        # wires that it shows among these.
        self._known: tuple[Panel, dict[str, Pose], Obstacles] | None = None
        self._wires: tuple[Picture, Obstacles, Obstacles] | None = None
        self.steps_per_tick = max(1, round(1.0 / (TICK_HZ * plant.world.time_step)))
        self.tick_s = self.steps_per_tick * plant.world.time_step
        self.commanded = self.home
        self.stand()
        self.empty_force = self.free_force = self.force
        self.fingers_open_to = self._robot.finger_gap / 2

    @property
    def _robot(self) -> Robot:
        """The arm and its sensors; the plant rebuilds them for every wire."""
        return self._plant.robots[self.name]

    @property
    def fingers(self) -> Fingers:
        """What its hand grips with."""
        return self.arm.fingers

    @property
    def peers(self) -> list[RobotContext]:
        """The cell's other robots."""
        return [context for name, context in self.robots.items() if name != self.name]

    def begin(self) -> None:
        """Note that the robot begins to do something."""
        self.busy, self.progress = True, Progress()

    def end(self) -> None:
        """Note that the robot has stopped, and release all space but that of its posture."""
        self.busy = False
        self.wait_for(None)
        self.stand()

    def claim(self, postures: Array) -> RobotContext | None:
        """Claim the space of a path, (n, joints); return the robot in the way, if there is one."""
        if len(self.robots) == 1:
            return None
        other = self._traffic.claim(self.name, volume_of(self.arm, postures))
        return None if other is None else self.robots[other]

    def take_space(self, postures: Array) -> None:
        """Claim the space of a path, (n, joints), which its caller has seen to be free."""
        self._traffic.stand(self.name, volume_of(self.arm, postures))

    def first_touch(
        self, path: Callable[[float], ToolPose], length: float, allowed: Set[str]
    ) -> Touch | None:
        """Return what of the panel a path would touch first; None: nothing, or it is not checked.

        What is drawn counts, and the wires that lay there before the live one was touched.

        Args:
            path: of the tool, from 0 to 1.
            length: of it [m].
            allowed: names of obstacles that may be touched.
        """
        check = self._plant.collision_checks.get(self.name)
        if check is None:
            return None
        drawn = self._panel_obstacles()
        return check.first_touch(
            path,
            length,
            obstacles=(drawn, self._seen_wires(drawn)),
            finger_gap=self.finger_gap,
            held=self._held_tip(),
            allowed=allowed,
        )

    def _panel_obstacles(self) -> Obstacles:
        """Return what stands on the plate, as drawn or as last located."""
        known = self._known
        if known is None or known[0] is not self.panel or known[1] != self.belief.seen:
            obstacles = panel_obstacles(self.panel, self.belief.seen)
            self._known = known = self.panel, dict(self.belief.seen), obstacles
        return known[2]

    def _seen_wires(self, drawn: Obstacles) -> Obstacles:
        """Return the wires that stand out of what is drawn, as the overhead camera saw them."""
        picture = self.belief.board_before
        if picture is None:
            return Obstacles()
        if self._wires is None or self._wires[0] is not picture or self._wires[1] is not drawn:
            self._wires = picture, drawn, standing_wires(picture, self.panel, drawn)
        return self._wires[2]

    def _held_tip(self) -> HeldTip | None:
        grip = self.belief.grip
        if grip is None:
            return None
        return HeldTip(self.wire.id, self.wire.radius, grip.distance, grip.height, grip.flip)

    def has_room(self, tool: ToolPose) -> bool:
        """Return whether no other robot obstructs the arm at a tool pose."""
        return self.has_way(self.arm.joints_for(tool))

    def has_way(self, postures: Array) -> bool:
        """Return whether no other robot obstructs the arm in postures, (joints,) or (n, joints)."""
        if len(self.robots) == 1:
            return True
        return self._traffic.in_the_way(self.name, volume_of(self.arm, postures)) is None

    def stand(self) -> None:
        """Release all claimed space but that of the commanded posture."""
        here = volume_of(self.arm, self.arm.joints_for(self.commanded))
        self._traffic.stand(self.name, here)

    def wait_for(self, other: RobotContext | None) -> None:
        """Note which robot this one waits for."""
        self._traffic.waits_for.pop(self.name, None)
        if other is not None:
            self._traffic.waits_for[self.name] = other.name

    def waits_for(self, other: RobotContext) -> bool:
        """Return whether the robot waits for another one."""
        return self._traffic.waits_for.get(self.name) == other.name

    @property
    def panel(self) -> Panel:
        """The panel as drawn: components may stand elsewhere."""
        return self._plant.panel

    @property
    def has_labels(self) -> bool:
        """Whether the panel's components carry labels."""
        return self._plant.design.labels

    @property
    def wire(self) -> PanelWire:
        """The live wire as ordered."""
        if self.belief.feed is None:
            raise ValueError("no wire has been fed")
        return self.panel.wire(self.belief.feed.wire_id)

    def arm_restarted(self) -> None:
        """Note that the arm stands where it was sent, its fingers open."""
        self.fingers_open_to = self._robot.finger_gap / 2

    def report(self, message: str, share: float) -> None:
        """Report what is being done, and its progress from 0 to 1."""
        self.progress = Progress(message, max(self.progress.share, share))

    def drive(self, tool: ToolPose) -> None:
        """Command a tool pose near contact; raises UNREACHABLE, or ROBOT_IN_THE_WAY and stops."""
        self._check_space(tool)
        self.follow(tool)

    def drive_by(self, controller: Controller, tool: ToolPose) -> None:
        """Let a controller drive the arm at each step of the physics, near a tool pose.

        Until another command; raises UNREACHABLE or ROBOT_IN_THE_WAY.
        """
        self._check_space(tool)
        self._robot.drive_by(controller)
        self.commanded = tool

    def _check_space(self, tool: ToolPose) -> None:
        if len(self.robots) > 1:
            here = volume_of(self.arm, self.arm.joints_for(tool))
            other = self._traffic.in_the_way(self.name, here)
            if other is not None:
                raise AbilityError(
                    Code.ROBOT_IN_THE_WAY,
                    f"{other} is in the way of {self.name}, which stands at {self.commanded}",
                )

    def follow(self, tool: ToolPose) -> None:
        """Command a tool pose on a path whose space is claimed; raises UNREACHABLE."""
        self._robot.drive(self.arm.joints_for(tool), self.steps_per_tick)
        self.commanded = tool

    def drive_joints(self, joints: Array) -> None:
        """Command the arm's joints; joints 3 and 5 stay at zero."""
        self._robot.drive(joints, self.steps_per_tick)
        self.commanded = self.arm.tool_of(joints)

    def drive_fingers(self, opening: float) -> None:
        """Send each finger to a distance from the middle [m]."""
        self._robot.drive_fingers(opening)
        self.fingers_open_to = opening

    def close_fingers(self, thickness: float) -> None:
        """Close the fingers until they stop on what they grip, about so thick [m]."""
        self._robot.drive_fingers(0.0, max(TOUCH_GAP, thickness + TOUCH_BEFORE_M))
        self.fingers_open_to = 0.0

    @property
    def tool(self) -> ToolPose:
        """The measured tool pose."""
        return self._robot.tool

    @property
    def finger_gap(self) -> float:
        """The measured distance between the pads [m]."""
        return self._robot.finger_gap

    @property
    def finger_load(self) -> float:
        """The measured closing force of the weaker finger [N]."""
        return self._robot.finger_load

    @property
    def hand_mass(self) -> float:
        """What the wrist carries [kg]."""
        return self._robot.hand_mass

    @property
    def force(self) -> Array:
        """The measured force of the hand on the wrist, world frame, (3,) [N].

        Holds the hand's weight.
        """
        robot = self._robot
        return robot.world_from_hand.rotation @ robot.wrist_force

    @property
    def overhead_view(self) -> View:
        """Where the overhead camera is."""
        return self._plant.design.overhead

    @property
    def wrist_view(self) -> View:
        """Where the wrist camera is, by the arm's own measure."""
        return self._plant.wrist_view(self.name)

    def take_overhead_picture(self) -> Picture:
        """Take a colour and depth picture of the whole plate."""
        picture = self._plant.take_overhead_picture()
        self.belief.note_board(picture)
        return self._observed("overhead", picture)

    def take_wrist_picture(self) -> Picture:
        """Take a picture from the hand, with depth if its camera measures it."""
        return self._observed(self._camera, self._plant.take_wrist_picture(self.name))

    def _observed(self, camera: str, picture: Picture) -> Picture:
        if self._observers.on_observation is not None:
            self._observers.on_observation(camera, picture, None)
        return picture

    def show(self, camera: str, picture: Picture, drawing: Image) -> None:
        """Show what was found in a picture of a camera, "overhead" or "wrist": this robot's."""
        if self._observers.on_observation is not None:
            name = self._camera if camera == "wrist" else camera
            self._observers.on_observation(name, picture, drawing)

    def show_frames(self, frames: Mapping[str, Pose]) -> None:
        """Show poses in the world, by the names of their frames."""
        if self._observers.on_frames is not None:
            self._observers.on_frames(frames)

    @property
    def scrap_bin(self) -> ToolPose:
        """Where the hand drops wires into the scrap bin; raises UNREACHABLE when there is none."""
        return bin_of(self._design, self.panel)

    def make_live(self, wire_id: str) -> None:
        """Make a wire that was parked live again, so that it can be handled; a live one is.

        The world is rebuilt for it, so every other robot must be idle; raises BUSY.
        """
        live = self._plant.live
        if live is not None and live.wire.id == wire_id:
            return
        for other in self.peers:
            if other.busy:
                raise AbilityError(
                    Code.BUSY,
                    f"{other.name} is busy, and {wire_id!r} can be handled again only while it is "
                    "not; try again",
                )
        tools = {name: context.commanded for name, context in self.robots.items()}
        parked = self._plant.revive(wire_id, tools)
        wire = self.panel.wire(wire_id)
        feed, places = self._as_presented(wire)
        expected = {
            end: np.array([*parked.nodes[node, :2], wire.radius])
            for end, node in ((WireEnd.A, 0), (WireEnd.B, -1))
        }
        lay_at = {end: Grip.of_tip(end, place) for end, place in places.items()}
        for context in self.robots.values():
            context.arm_restarted()
            context.belief.resume_wire(feed, expected, parked.fixed, lay_at)

    def _as_presented(self, wire: PanelWire) -> tuple[Feed, dict[WireEnd, Pose]]:
        """Return how a wire was presented, and where its ends go when they are extracted.

        One from the magazine has no channel to lie in: its ends stay before their terminals.
        """
        feeder, magazine = self._plant.design.feeder, self._plant.design.magazine
        if magazine is not None:
            direction = plan_presentation(magazine, self.panel, wire).direction
            openings = {end: self.panel.panel_from_socket(*wire.goes_to(end)) for end in WireEnd}
            places = {end: WORLD_FROM_PANEL @ opening for end, opening in openings.items()}
            return Feed(wire.id, NO_CHANNEL, direction), places
        assert feeder is not None, "a cell has a feeder or a magazine"
        lying = {end: resting_place(self.panel, wire, end, feeder.overlap) for end in WireEnd}
        channel = self.panel.channel_in_front_of(
            self.panel.panel_from_socket(*wire.goes_to(WireEnd.A)).position
        )
        feed = Feed(wire.id, channel.id, lying[WireEnd.A][1])
        return feed, {end: place for end, (place, _) in lying.items()}

    def drop_wire(self) -> None:
        """Let what the open hand had over the scrap bin fall: it leaves the world."""
        self._plant.drop(self.tool.position)

    def end_wire(self) -> None:
        """Note that no piece of the live wire is left."""
        wire_id = self.wire.id
        for context in self.robots.values():
            context.belief.end_wire(wire_id)

    def open_magazine(self, end: WireEnd) -> None:
        """Open the magazine's clips that hold an end; it has others for the other end."""
        self._plant.open_magazine(end)

    def move_fork(self, x: float, y: float) -> None:
        """Bring the feeder's fork up around a wire, world frame [m].

        It runs along the middle of a channel.
        """
        self._plant.move_fork(x, y)

    def lower_fork(self) -> None:
        """Draw the feeder's fork in."""
        self._plant.lower_fork()

    def close_clamp(self, component_id: str, terminal_id: str) -> bool:
        """Close a terminal's clamp.

        Returns whether its screw stopped on something before the end of its travel.
        """
        return self._plant.close_clamp(component_id, terminal_id)

    def open_clamp(self, component_id: str, terminal_id: str) -> None:
        """Open a terminal's clamp."""
        self._plant.open_clamp(component_id, terminal_id)
