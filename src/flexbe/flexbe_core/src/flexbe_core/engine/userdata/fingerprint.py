"""Detect whether a value was changed in place.

A fingerprint is the list of the value's unchangeable parts, in the order of a walk through it.
The parts are kept, not copied: bytes of an image cost one reference. Taken again after the value
was lent out, an equal fingerprint means that nothing was written into it.

A list of many objects of one class, such as the poses of a path, is walked attribute by attribute
in place of object by object: what they have in one attribute is one part.

Supported: lists, tuples, sets, dicts, ROS messages, and objects with a buffer (arrays,
bytearrays). Of a buffer beyond SAMPLED_BYTES only samples are compared. Other objects count as
unchangeable, as they do in stock FlexBE, which compares their repr.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from operator import attrgetter
from typing import Any

# Users may put any object into userdata.
Value = Any

Fingerprint = list[Value]

# [bytes] Up to here a buffer is summed whole, in about 20 us; beyond, this many bytes are sampled.
SAMPLED_BYTES = 1 << 16

# A list of more items than this is worth a check whether it holds plain values only.
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
        if len(value) > _LONG_LIST:
            _walk_together(value, parts, seen, frozenset())
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
    elif _has_slots(kind):
        for name in _changeable_slots(kind):
            _walk(getattr(value, name, None), parts, seen)
    else:
        _sum_buffer(value, parts)


def _walk_together(
    values: Sequence[Value], parts: Fingerprint, seen: set[int], around: frozenset[type]
) -> None:
    """Walk through many values at once, as long as they are of one class.

    Args:
        values: what all objects of a list have in one attribute; at first the list itself.
        parts: gets the parts.
        seen: ids of the values that were walked through one by one.
        around: classes of the objects that hold the values; one that holds itself is walked
            through object by object, which ends.
    """
    kinds = tuple(map(type, values))
    classes = set(kinds)
    parts.append(kinds)
    if classes <= _PLAIN:
        parts.append(tuple(values))
        return
    kind = kinds[0]
    columns = _columns(values, kind) if len(classes) == 1 and kind not in around else None
    if columns is None:
        for value in values:
            _walk(value, parts, seen)
    else:
        for column in columns:
            _walk_together(column, parts, seen, around | {kind})


def _columns(values: Sequence[Value], kind: type) -> list[list[Value]] | None:
    """Return what objects of one class have in each attribute; None if some lack one."""
    if not _has_slots(kind):
        return None
    try:
        return [list(map(attrgetter(name), values)) for name in _changeable_slots(kind)]
    except AttributeError:
        return None


def _has_slots(kind: type) -> bool:
    return hasattr(kind, "__slots__") and not hasattr(kind, "__array_interface__")


def _changeable_slots(kind: Any) -> list[str]:  # noqa: ANN401 - a class that has slots
    skipped = _SET_BY_PUBLISHING if kind.__name__ == "Header" else frozenset()
    return [name for name in kind.__slots__ if name not in skipped]


def _sum_buffer(value: Value, parts: Fingerprint) -> None:
    try:
        view = memoryview(value).cast("B")
    except (TypeError, ValueError, BufferError):
        return  # no buffer, or one with gaps
    step = max(1, view.nbytes // SAMPLED_BYTES)
    parts.append((view.nbytes, zlib.adler32(view if step == 1 else view[::step].tobytes())))
