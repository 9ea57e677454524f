"""What an arm holds, what it would touch on a path, and who finds that out."""

from __future__ import annotations

from collections.abc import Callable, Sequence, Set
from dataclasses import dataclass
from typing import Protocol

from remodel_work.obstacles import Obstacles
from remodel_work.robot.arm import ToolPose


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
