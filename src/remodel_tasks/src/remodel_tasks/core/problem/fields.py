"""Read the fields of a parsed JSON document, and name exactly the one that is not as required."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from remodel_production.errors import InstanceError

# Lengths [mm] and durations [ticks] beyond these (100 m, 2.8 h) are no panel's; up to them, the
# sums of a thousand wires stay exact in the kernel's 32 bits.
GREATEST = 100_000
GREATEST_TIME = 1_000_000_000


class Fields:
    """A JSON object at a known place in its document."""

    def __init__(self, data: object, where: str) -> None:
        """Take the object, and its place such as `wires[3]`; InstanceError if it is no object."""
        if not isinstance(data, Mapping):
            raise InstanceError(
                f"{where or 'the document'}: expected an object, found {_show(data)}"
            )
        self._data = data
        self.where = where

    def place(self, key: str) -> str:
        """Return the place of a field."""
        return f"{self.where}.{key}" if self.where else key

    def fail(self, key: str, expected: str) -> InstanceError:
        """Return the error that a field is not what was expected."""
        found = _show(self._data[key]) if key in self._data else "nothing"
        return InstanceError(f"{self.place(key)}: expected {expected}, found {found}")

    def value(self, key: str) -> Any:  # noqa: ANN401 - any JSON value
        """Return a field that must be there."""
        if key not in self._data:
            raise self.fail(key, "a value")
        return self._data[key]

    def text(self, key: str) -> str:
        """Return a field that is text."""
        value = self.value(key)
        if not isinstance(value, str):
            raise self.fail(key, "text")
        return value

    def number(self, key: str, least: int = 0, greatest: int = GREATEST) -> int:
        """Return a field that is an integer in a range."""
        value = self.value(key)
        if not _is_integer(value) or not least <= value <= greatest:
            raise self.fail(key, f"an integer from {least} to {greatest}")
        return int(value)

    def flag(self, key: str) -> bool:
        """Return a field that is true or false."""
        value = self.value(key)
        if not isinstance(value, bool):
            raise self.fail(key, "true or false")
        return value

    def pair(self, key: str, least: int = -GREATEST) -> tuple[int, int]:
        """Return a field that is two integers, such as a position in mm."""
        value = self.value(key)
        if not (
            isinstance(value, list)
            and len(value) == 2
            and all(_is_integer(item) and least <= item <= GREATEST for item in value)
        ):
            raise self.fail(key, f"two integers from {least} to {GREATEST}")
        return (value[0], value[1])

    def pairs(self, key: str) -> tuple[tuple[int, int], ...]:
        """Return a field that is a list of at least two pairs of integers, such as a path in mm."""
        value = self.value(key)
        if not isinstance(value, list) or len(value) < 2:
            raise self.fail(key, "a list of at least two positions")
        places = Fields({str(i): place for i, place in enumerate(value)}, self.place(key))
        return tuple(places.pair(str(i)) for i in range(len(value)))

    def plain(self, key: str) -> str | float | bool:
        """Return a field that is a text, a finite number, or true or false."""
        value = self.value(key)
        if not isinstance(value, str | int | float) or (
            isinstance(value, float) and not math.isfinite(value)
        ):
            raise self.fail(key, "a text, a number, or true or false")
        return value

    def choice(self, key: str, choices: tuple[str, ...]) -> str:
        """Return a field that is one of some words."""
        value = self.value(key)
        if value not in choices:
            raise self.fail(key, "one of " + ", ".join(choices))
        return str(value)

    def objects(self, key: str) -> list[Fields]:
        """Return a field that is a list of objects."""
        value = self.value(key)
        if not isinstance(value, list):
            raise self.fail(key, "a list")
        return [Fields(item, f"{self.place(key)}[{i}]") for i, item in enumerate(value)]

    def texts(self, key: str) -> tuple[str, ...]:
        """Return a field that is a list of texts."""
        value = self.value(key)
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise self.fail(key, "a list of texts")
        return tuple(value)

    def inner(self, key: str) -> Fields:
        """Return a field that is an object."""
        return Fields(self.value(key), self.place(key))

    def has(self, key: str) -> bool:
        """Return whether a field is there and not null."""
        return self._data.get(key) is not None

    def only(self, *keys: str) -> None:
        """Refuse fields of other names.

        Raises:
            InstanceError: naming the first one.
        """
        for key in self._data:
            if key not in keys:
                raise InstanceError(
                    f"{self.place(key)}: no such field; there are {', '.join(keys)}"
                )

    def keys(self) -> tuple[str, ...]:
        """Return the names of the fields."""
        return tuple(self._data)


def _is_integer(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _show(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
