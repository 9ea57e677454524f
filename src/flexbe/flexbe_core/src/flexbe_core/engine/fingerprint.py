"""Tell whether a value was changed in place.

A fingerprint is the list of the value's unchangeable parts, in the order of a walk through it.
The parts are kept, not copied: bytes of an image cost one reference. Taken again after the value
was lent out, an equal fingerprint means that nothing was written into it.

Seen: lists, tuples, sets, dicts, ROS messages, and whatever has a buffer (arrays, bytearrays).
Of a buffer beyond SAMPLED_BYTES only samples are compared. Other objects count as unchangeable,
as they do in stock FlexBE, which compares their repr.
"""

from __future__ import annotations

import zlib
from typing import Any

# Whatever users put into userdata.
Value = Any

Fingerprint = list[Value]

# [bytes] Up to here a buffer is summed whole, in about 20 us; beyond, this many bytes are sampled.
SAMPLED_BYTES = 1 << 16

# A list of more items than this is worth a look at whether it holds plain values only.
_LONG_LIST = 64

_PLAIN = frozenset({int, float, complex, bool, str, bytes, type(None)})

# Fields of a std_msgs/Header that publishing the message sets.
_SET_BY_PUBLISHING = frozenset({"seq", "frame_id"})


def fingerprint(value: Value) -> Fingerprint | None:
    """Return the fingerprint of a value, or None if it cannot be changed in place."""
    if type(value) in _PLAIN:
        return None
    parts: Fingerprint = []
    _walk(value, parts, set())
    return parts


def is_unchanged(before: Fingerprint, after: Fingerprint | None) -> bool:
    """Return whether two fingerprints of one value are equal."""
    return (
        after is not None
        and len(before) == len(after)
        and all(_same(old, new) for old, new in zip(before, after, strict=True))
    )


def _same(old: Value, new: Value) -> bool:
    return old is new or (type(old) is type(new) and bool(old == new))


def _walk(value: Value, parts: Fingerprint, seen: set[int]) -> None:
    kind = type(value)
    if kind in _PLAIN:
        parts.append(value)
        return
    if id(value) in seen:
        return
    seen.add(id(value))
    if kind in (list, tuple):
        if len(value) > _LONG_LIST and set(map(type, value)) <= _PLAIN:
            parts.append(tuple(value))
            return
        parts.append(len(value))
        for item in value:
            _walk(item, parts, seen)
    elif isinstance(value, dict):
        parts.append(tuple(value))
        for item in value.values():
            _walk(item, parts, seen)
    elif kind in (set, frozenset):
        parts.append(frozenset(value))
    elif hasattr(kind, "__slots__") and not hasattr(value, "__array_interface__"):
        skipped = _SET_BY_PUBLISHING if kind.__name__ == "Header" else frozenset()
        for name in kind.__slots__:
            if name not in skipped:
                _walk(getattr(value, name, None), parts, seen)
    else:
        _sum_buffer(value, parts)


def _sum_buffer(value: Value, parts: Fingerprint) -> None:
    try:
        view = memoryview(value).cast("B")
    except (TypeError, ValueError, BufferError):
        return  # no buffer, or one with gaps
    step = max(1, view.nbytes // SAMPLED_BYTES)
    parts.append((view.nbytes, zlib.adler32(view if step == 1 else view[::step].tobytes())))
