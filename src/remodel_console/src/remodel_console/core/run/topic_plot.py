"""Plots of topics: which fields of a message are numbers, and the last minute of one of them.

A plot is written as in Foxglove: the topic, a point, and the field, such as
`/cell/wrist/wrench.wrench.force.z` or `/joint_states.position[3]`. Names of topics have no points.
"""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Callable, Iterator, Sequence

WINDOW_S = 60.0
_BIN_S = 0.2  # of whose samples the least and the greatest are kept, so that no peak is lost
_MOST_LISTED = 8  # fields that an error names
_LONGEST_ARRAY = 16  # elements of an array of fixed length that are offered one by one

_BYTES = ("byte", "char", "int8", "uint8")  # arrays of these are pictures and other data
_NUMBERS = (
    *_BYTES, "bool", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64"
)  # fmt: skip
_OTHERS = ("string", "time", "duration")

# Returns (name, type) of each field of a message type, such as ("position", "float64[]").
FieldsOf = Callable[[str], Sequence[tuple[str, str]]]


def split_plot(plot: str) -> tuple[str, str]:
    """Return the topic and the field of a plot.

    Raises:
        ValueError: if it is not written as one.
    """
    topic, _, field = plot.partition(".")
    if not re.fullmatch(r"/[\w/]+", topic) or not re.fullmatch(r"[\w.\[\]]+", field):
        raise ValueError(
            f"'{plot}' is no plot; write /TOPIC.FIELD, such as /joint_states.position[3]"
        )
    return topic, field


def number_fields(kind: str, fields_of: FieldsOf) -> Iterator[str]:
    """Yield the fields of a message type that are numbers; of a list the first element."""
    for name, type_name in fields_of(kind):
        base, bracket, length = type_name.rstrip("]").partition("[")
        if base in _OTHERS or (bracket and base in _BYTES):
            continue
        count = min(int(length), _LONGEST_ARRAY) if length else 1
        for index in range(count):
            place = f"{name}[{index}]" if bracket else name
            if base in _NUMBERS:
                yield place
            else:
                yield from (f"{place}.{inner}" for inner in number_fields(base, fields_of))


def check_field(field: str, kind: str, known: Sequence[str]) -> None:
    """Refuse what is no number of a message type; an element of a list may have any index.

    Args:
        field: such as `position[3]`.
        kind: the message type.
        known: its `number_fields`.

    Raises:
        ValueError: if it is none.
    """
    if _shape(field) not in map(_shape, known):
        listed = ", ".join(known[:_MOST_LISTED]) or "none"
        more = f" and {len(known) - _MOST_LISTED} more" if len(known) > _MOST_LISTED else ""
        raise ValueError(f"{kind} has no number '{field}'; its numbers: {listed}{more}")


def _shape(field: str) -> str:
    return re.sub(r"\[\d+\]", "[]", field)


def number_in(message: object, field: str) -> float:
    """Return a field of a message.

    Raises:
        IndexError: if a list in it is shorter.
    """
    value = message
    for step in field.split("."):
        name, _, index = step.rstrip("]").partition("[")
        value = getattr(value, name)
        if index:
            value = value[int(index)]
    return float(value)  # type: ignore[arg-type]


class Samples:
    """The last minute of a value; of each fifth of a second its least and its greatest."""

    def __init__(self) -> None:
        """Begin without any."""
        self._bins: deque[list[tuple[float, float]]] = deque()

    def add(self, time_s: float, value: float) -> None:
        """Add a sample, not before the last one; NaN and infinity are left out."""
        if not math.isfinite(value):
            return
        sample = (time_s, value)
        if self._bins and time_s // _BIN_S == self._bins[-1][0][0] // _BIN_S:
            samples = [*self._bins[-1], sample]
            ends = {min(samples, key=lambda s: s[1]), max(samples, key=lambda s: s[1])}
            self._bins[-1] = sorted(ends)
        else:
            self._bins.append([sample])
            self._forget(time_s)

    def _forget(self, now_s: float) -> None:
        while self._bins and self._bins[0][-1][0] < now_s - WINDOW_S:
            self._bins.popleft()

    def points(self, now_s: float) -> list[tuple[float, float]]:
        """Return (seconds before now, at most 0; value) of the samples of the last minute."""
        self._forget(now_s)
        return [(round(t - now_s, 2), value) for each in tuple(self._bins) for t, value in each]
