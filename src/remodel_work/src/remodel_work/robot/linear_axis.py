"""A linear axis below an arm: where it carries the arm for a place of the tool.

With the axis an arm has one joint more than a place of the tool needs. The position of the axis
follows from the place alone, by a smooth rule, so that a straight line of the tool is one smooth
motion of all joints, and a place always has the same posture:

- The arm stands level with the tool, which it then reaches straight ahead.
- What is nearer to the axis than the arm can fold it reaches obliquely: the arm stands aside by as
  much as the tool is too near, towards the end of the axis that has the longer travel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

# The rule's corners are rounded over about so much of the tool's way [m].
ROUNDING_M = 0.06


@dataclass(frozen=True)
class LinearAxis:
    """An axis along y of the arm's base.

    Attributes:
        lower, upper: limits of its position [m]; at 0 the arm stands where its base is given.
        speed: it moves no faster [m/s].
    """

    lower: float
    upper: float
    speed: float

    def position_for(self, x: float, y: float, near: float) -> float:
        """Return the axis's position for a place of the tool in the base's frame [m].

        `near`: the arm reaches what is so far away or further [m]. The hypotenuse over x and the
        step aside, near * sqrt(2) - x, is never shorter.
        """
        aside = _positive_part(near * math.sqrt(2.0) - x)
        position = y + (aside if self.upper > -self.lower else -aside)
        position = self.upper - _positive_part(self.upper - position)
        position = self.lower + _positive_part(position - self.lower)
        return min(self.upper, position)


def _positive_part(value: float) -> float:
    """Return a value [m] where it is positive and zero elsewhere, rounded near zero."""
    return (value + math.hypot(value, ROUNDING_M)) / 2
