"""Goals that are invalid, whatever the ability."""

from __future__ import annotations

import math
from collections.abc import Iterator

from genpy import Message

from remodel_states.core.contract_times import CLOCKS_DIFFER_S, LATE_S


def why_invalid(goal: Message) -> str:
    """Return why a goal is invalid; empty if it is valid."""
    if not goal.id:
        return "id is empty; it must name the goal"
    if not 0 < goal.timeout < math.inf:
        return f"timeout must be a positive number, found {goal.timeout}"
    for name in goal.__slots__:
        if any(not math.isfinite(number) for number in _numbers(getattr(goal, name))):
            return f"{name} holds NaN or infinity"
    return ""


def why_late(sent_s: float, now_s: float, timeout_s: float) -> str:
    """Return why a goal has arrived too late to begin; empty if it has not.

    Args:
        sent_s: [s] ROS time of the goal's id; 0 if its client gave none.
        now_s: [s] ROS time.
        timeout_s: [s] of the goal.
    """
    late_s, most_s = now_s - sent_s, min(timeout_s, LATE_S) + CLOCKS_DIFFER_S
    if not sent_s or late_s <= most_s:
        return ""
    return (
        f"sent {late_s:.1f} s ago, so its client has given it up; allowed: {most_s:g} s. The "
        "server was stalled, or the clocks of the two machines differ"
    )


def _numbers(value: object) -> Iterator[float]:
    """Yield the floating-point numbers in a field of a message, however deep."""
    if isinstance(value, float):
        yield value
    elif isinstance(value, list | tuple):
        for item in value:
            yield from _numbers(item)
    elif isinstance(value, Message):
        for name in value.__slots__:
            yield from _numbers(getattr(value, name))
