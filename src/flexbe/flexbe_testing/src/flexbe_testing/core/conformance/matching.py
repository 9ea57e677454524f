"""Compare messages with what was expected of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Fields = Mapping[str, Any]


def agrees(message: object, expected: Fields) -> bool:
    """Return whether a message has the expected fields; the others may be anything."""
    return all(_value(getattr(message, name)) == value for name, value in expected.items())


def shown(message: object, fields: Fields | None = None) -> str:
    """Return a message, or some of its fields, on one line."""
    names = list(fields) if fields else list(getattr(message, "__slots__", ()))
    values = ", ".join(f"{name}: {_value(getattr(message, name))!r}" for name in names)
    return f"{{{values}}}"


def _value(value: object) -> object:
    """Return a field with tuples as lists, which is how ROS delivers arrays of some types."""
    return list(value) if isinstance(value, tuple) else value
