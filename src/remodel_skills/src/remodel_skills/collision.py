"""What an arm holds, and what it would touch on a path."""

from __future__ import annotations

from dataclasses import dataclass

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
