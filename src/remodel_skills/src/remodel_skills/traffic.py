"""Which space of the cell each robot has for itself.

A robot claims the space of its whole path before it moves, and that of its posture when it is
stopped. No robot gets space too near to another's, so robots that keep to their claims
do not collide.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from remodel_work.robot.arm_volume import Volume, gap_between


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
        for other, room in self._others(robot):
            if gap_between(volume, room) < self.margin_m:
                return other
        return None

    def _others(self, robot: str) -> Iterable[tuple[str, Volume]]:
        return ((other, room) for other, room in self.claims.items() if other != robot)
