"""How often a state that has returned None is executed again."""

from __future__ import annotations

from dataclasses import dataclass

# [s] Stock FlexBE executes a state at 10 Hz unless it sets a rate of its own.
DEFAULT_PERIOD_S = 0.1


@dataclass(frozen=True)
class Rate:
    """A polling rate.

    Attributes:
        period_s: [s] ROS time between two executions, > 0.
    """

    period_s: float = DEFAULT_PERIOD_S

    @classmethod
    def from_hz(cls, hz: float) -> Rate:
        """Return the rate of `hz` executions per second.

        Raises:
            ValueError: if hz is not a positive number.
        """
        if not 0 < hz < float("inf"):
            raise ValueError(f"a rate must be a positive number of Hz, found {hz!r}")
        return cls(1.0 / hz)


def period_s(rate: object) -> float:
    """Return the period that a state's `_rate` asks for.

    States of stock FlexBE may put a rospy.Rate there; anything else means the default.
    """
    if isinstance(rate, Rate):
        return rate.period_s
    to_sec = getattr(getattr(rate, "sleep_dur", None), "to_sec", None)
    seconds = float(to_sec()) if to_sec is not None else 0.0
    return seconds if seconds > 0 else DEFAULT_PERIOD_S


def is_over(rate: object) -> bool:
    """Return whether the period of a rate of a user's own class, with only `remaining`, is over.

    Tests of states use such rates to have every tick execute the state.
    """
    remaining = getattr(rate, "remaining", None)
    if remaining is None or hasattr(rate, "sleep_dur"):
        return False
    return bool(remaining().to_sec() <= 0)
