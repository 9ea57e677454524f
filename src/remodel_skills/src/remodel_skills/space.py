"""The space that arms take, and who may move when; what a robot must not touch.

That is the panel as drawn or last located, and wires that were seen.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence, Set
from dataclasses import dataclass, field
from typing import Protocol

from remodel_skills.belief_state import BeliefState
from remodel_skills.device import Device
from remodel_states.core.codes import Code
from remodel_vision.standing import standing_wires
from remodel_work.camera import Picture
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose
from remodel_work.obstacles import Obstacles, panel_obstacles
from remodel_work.panel import Panel, PanelWire
from remodel_work.robot.arm import Kinematics, ToolPose
from remodel_work.robot.arm_volume import Volume, gap_between, volume_of


@dataclass(frozen=True)
class HeldTip:
    """The straight end of a wire ahead of the hand.

    Attributes:
        name: of the wire.
        radius: [m].
        distance: from the tool centre to the tip [m].
        height: of the wire's axis above the tool centre [m].
        flip: direction of the tip relative to the hand's x axis [rad].
    """

    name: str
    radius: float
    distance: float
    height: float
    flip: float


@dataclass(frozen=True)
class Touch:
    """Where a motion comes too near to something.

    Attributes:
        part: of the robot, or what it holds.
        solid: the obstacle's name.
        tool: where the tool is then.
        gap: between the two [m]; negative where they would overlap.
    """

    part: str
    solid: str
    tool: ToolPose
    gap: float

    def __str__(self) -> str:
        """Say which part would touch what, where and by how much."""
        verb = "would overlap" if self.gap < 0 else "would come as near as"
        how = f"{verb} {abs(self.gap) * 1e3:.1f} mm"
        joined = "with" if self.gap < 0 else "to"
        return f"{self.part} {how} {joined} {self.solid}, the tool at {self.tool}"


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

    def close(self) -> None:
        """Release what it holds."""


class Space:
    """What one robot claims; a cell of one robot has it all."""

    def __init__(
        self, name: str, arm: Kinematics, traffic: Traffic, robots: Collection[str]
    ) -> None:
        """Claim nothing yet; `robots` are the names of all of the cell."""
        self._name, self._arm, self._traffic, self._robots = name, arm, traffic, robots

    def claim(self, postures: Array) -> str | None:
        """Claim the space of a path, (n, joints); return which robot is in the way, if any."""
        if len(self._robots) == 1:
            return None
        return self._traffic.claim(self._name, volume_of(self._arm, postures))

    def take(self, postures: Array) -> None:
        """Claim the space of a path, (n, joints), which its caller has seen to be free."""
        self._traffic.stand(self._name, volume_of(self._arm, postures))

    def has_room(self, tool: ToolPose) -> bool:
        """Return whether no other robot obstructs the arm at a tool pose."""
        return self.has_way(self._arm.joints_for(tool))

    def has_way(self, postures: Array) -> bool:
        """Return whether no other robot obstructs the arm in postures, (joints,) or (n, joints)."""
        if len(self._robots) == 1:
            return True
        return self._traffic.in_the_way(self._name, volume_of(self._arm, postures)) is None

    def check(self, tool: ToolPose, now_at: ToolPose) -> None:
        """Raise ROBOT_IN_THE_WAY when another robot obstructs the arm at a tool pose."""
        if len(self._robots) > 1:
            here = volume_of(self._arm, self._arm.joints_for(tool))
            other = self._traffic.in_the_way(self._name, here)
            if other is not None:
                raise AbilityError(
                    Code.ROBOT_IN_THE_WAY,
                    f"{other} is in the way of {self._name}, which stands at {now_at}",
                )

    def stand(self, tool: ToolPose) -> None:
        """Release all claimed space but that of the arm at a tool pose."""
        self._traffic.stand(self._name, volume_of(self._arm, self._arm.joints_for(tool)))

    def wait_for(self, other: str | None) -> None:
        """Note which robot this one waits for."""
        self._traffic.waits_for.pop(self._name, None)
        if other is not None:
            self._traffic.waits_for[self._name] = other

    def waits_for(self, other: str) -> bool:
        """Return whether the robot waits for another one."""
        return self._traffic.waits_for.get(self._name) == other


@dataclass
class Traffic:
    """The claims of a cell's robots.

    Attributes:
        margin_m: between the spaces of two robots [m].
        claims: the space that each robot has, by its name.
        waits_for: whom a robot waits for.
    """

    margin_m: float
    claims: dict[str, Volume] = field(default_factory=dict)
    waits_for: dict[str, str] = field(default_factory=dict)

    def stand(self, robot: str, volume: Volume) -> None:
        """Give a robot the space that its posture occupies, and release the rest."""
        self.claims[robot] = volume

    def claim(self, robot: str, volume: Volume) -> str | None:
        """Give a robot the space of a path, or return the robot that is in the way."""
        other = self.in_the_way(robot, volume)
        if other is None:
            self.claims[robot] = volume
        return other

    def in_the_way(self, robot: str, volume: Volume) -> str | None:
        """Return the robot whose space is too near to another's; None if there is none."""
        for other, room in self.claims.items():
            if other != robot and gap_between(volume, room) < self.margin_m:
                return other
        return None


class Scene:
    """The obstacles of one robot's motions, as the cell believes them to be."""

    def __init__(
        self, device: Device, panel: Panel, belief: BeliefState, check: CollisionCheck | None
    ) -> None:
        """Begin with what is drawn; `check` of the robot's motions, None: they are not checked."""
        self._device, self._panel, self._belief, self._check = device, panel, belief, check
        # Located components, and the obstacles that follow from them; pictures, and the wires that
        # they show among these.
        self._drawn: tuple[dict[str, Pose], Obstacles] | None = None
        self._wires: tuple[tuple[Picture, ...], Obstacles, Obstacles] | None = None

    @property
    def wire(self) -> PanelWire:
        """The live wire as ordered."""
        if self._belief.feed is None:
            raise ValueError("no wire has been fed")
        return self._panel.wire(self._belief.feed.wire_id)

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
        if self._check is None:
            return None
        drawn = self._panel_obstacles()
        return self._check.first_touch(
            path,
            length,
            obstacles=(drawn, self._seen_wires(drawn)),
            finger_gap=self._device.gripper.gap,
            held=self._held_tip(),
            allowed=allowed,
        )

    def _panel_obstacles(self) -> Obstacles:
        """Return what stands on the plate, as drawn or as last located."""
        seen = self._belief.seen
        if self._drawn is None or self._drawn[0] != seen:
            self._drawn = dict(seen), panel_obstacles(self._panel, seen)
        return self._drawn[1]

    def _seen_wires(self, drawn: Obstacles) -> Obstacles:
        """Return the wires that stand out of what is drawn, as the overhead cameras saw them."""
        pictures = tuple(self._belief.untouched)
        if not pictures:
            return Obstacles()
        if self._wires is None or self._wires[0] != pictures or self._wires[1] is not drawn:
            self._wires = pictures, drawn, standing_wires(pictures, self._panel, drawn)
        return self._wires[2]

    def _held_tip(self) -> HeldTip | None:
        grip = self._belief.grip
        if grip is None:
            return None
        wire = self.wire
        return HeldTip(wire.id, wire.radius, grip.distance, grip.height, grip.flip)
