"""The space that arms take, and who may move when: capsules, claims, and traffic."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence, Set
from dataclasses import dataclass, field
from typing import Protocol

from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array
from remodel_work.obstacles import Obstacles
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
