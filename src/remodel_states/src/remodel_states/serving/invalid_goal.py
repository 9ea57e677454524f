"""Goals that are invalid, whatever the ability."""

from __future__ import annotations

import math
from collections.abc import Iterator

from genpy import Message


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
