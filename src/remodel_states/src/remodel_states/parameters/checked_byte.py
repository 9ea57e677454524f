"""Whole numbers that fit into a goal's field of type uint8."""

from __future__ import annotations

_MOST = 255


def checked_byte(name: str, value: object) -> int:
    """Return the value of a parameter.

    Raises:
        ValueError: if it does not fit into a goal.
    """
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= _MOST:
        raise ValueError(f"{name} must be a whole number from 0 to {_MOST}, found {value!r}")
    return value
