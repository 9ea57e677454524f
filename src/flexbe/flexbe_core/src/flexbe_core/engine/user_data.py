"""Userdata as one state may see it, and what can go wrong in a run.

The first three errors are stock FlexBE's: users catch them by name, and they share no base but
Exception.

A view has a store of its own on top of a reference (another view, or a dict). Reading tries the
store first, then the reference through the remapping. Writing an output key writes both.

    own key --remap--> key of the container          (missing in the map: the same name)

An input key that is not an output key may be read, never changed: its fingerprint is taken when it
is lent out and compared when the view is closed. Values are lent by reference and never copied.
"""

from __future__ import annotations

import zlib
from collections.abc import Collection, Mapping, Sequence
from operator import attrgetter
from typing import Any


class StateError(Exception):
    """A state is used in a way that its definition does not allow."""


class StateMachineError(Exception):
    """A container is built or used incorrectly."""


class UserDataError(Exception):
    """Userdata is read or written against its declaration."""


class BehaviorFailure(Exception):  # noqa: N818 - a failure of the behavior, not an error in it
    """A state could not continue, and no operator is present to help: the run ends.

    Attributes:
        path: path of the state or container that could not continue.
        cause: what it raised.
    """

    def __init__(self, path: str, cause: Exception) -> None:
        super().__init__(f"{path or 'the root container'}: {type(cause).__name__}: {cause}")
        self.path = path
        self.cause = cause


_set = object.__setattr__


class UserData:
    """The data that a state or container sees.

    Keys are attributes or items. Names that start with an underscore are attributes of the object.
    """

    # A behavior of thousands of states makes thousands of views; __dict__ is for users.
    __slots__ = (
        "__dict__",
        "_data",
        "_input_keys",
        "_lent",
        "_output_keys",
        "_reference",
        "_remap",
    )

    _data: dict[str, Value]
    _lent: dict[str, tuple[Value, Fingerprint | None]]
    _reference: UserData | dict[str, Value]
    _input_keys: Collection[str] | None
    _output_keys: Collection[str] | None
    _remap: Mapping[str, str]

    def __init__(
        self,
        reference: UserData | dict[str, Value] | None = None,
        input_keys: Collection[str] | None = None,
        output_keys: Collection[str] | None = None,
        remap: Mapping[str, str] | None = None,
    ) -> None:
        """Make a view on `reference` through `remap`.

        Args:
            reference: where values come from and go to.
            input_keys: keys that may be read; None means all.
            output_keys: keys that may be written; None means all, into the own store only.
            remap: own key -> key in the reference.
        """
        _set(self, "_data", {})
        _set(self, "_lent", {})
        _set(self, "_reference", {} if reference is None else reference)
        _set(self, "_input_keys", input_keys)
        _set(self, "_output_keys", output_keys)
        _set(self, "_remap", remap or {})

    def __call__(
        self,
        reference: UserData | dict[str, Value] | None = None,
        add_from: UserData | None = None,
        update_from: UserData | None = None,
        remove_key: str | None = None,
    ) -> None:
        """Change the view itself.

        Args:
            reference: read from this from now on.
            add_from: copy the keys of its store that are missing in the own one.
            update_from: copy all keys of its store.
            remove_key: remove this key from the own store.
        """
        if reference is not None:
            self._reference = reference
        if add_from is not None:
            for key, value in add_from._data.items():
                self._data.setdefault(key, value)
        if update_from is not None:
            self._data.update(update_from._data)
        if remove_key is not None:
            self._data.pop(remove_key, None)

    def __contains__(self, key: str) -> bool:
        if key in self._data:
            return True
        if self._input_keys is not None and key not in self._input_keys:
            return False
        return self._remap.get(key, key) in self._reference

    def __getitem__(self, key: str) -> Value:
        """Return a value.

        Raises:
            UserDataError: if the key is not declared as input, or has not been written.
        """
        data = self._data
        if key in data:
            return data[key]
        if key not in self:
            raise UserDataError(self._why_unreadable(key))
        value = self._reference[self._remap.get(key, key)]
        if self._output_keys is not None and key not in self._output_keys:
            data[key] = value
            self._lent[key] = (value, fingerprint(value))
        return value

    def __setitem__(self, key: str, value: Value) -> None:
        self._data[key] = value
        if self._output_keys is not None and key in self._output_keys:
            self._reference[self._remap.get(key, key)] = value

    def __getattr__(self, key: str) -> Value:
        """Return a value, see __getitem__."""
        if key.startswith("_"):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {key!r}")
        return self[key]

    def __setattr__(self, key: str, value: Value) -> None:
        """Write a value, see __setitem__.

        Raises:
            UserDataError: if the key is not declared as output.
        """
        if key.startswith("_"):
            _set(self, key, value)
            return
        if self._output_keys is not None and key not in self._output_keys:
            declared = ", ".join(self._output_keys) or "none"
            raise UserDataError(f"key {key!r} is not declared as output; declared: {declared}")
        self[key] = value

    def __enter__(self) -> UserData:
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: object) -> None:
        if kind is None:
            self._check()

    def __len__(self) -> int:
        return len(self._data) + len(self._reference)

    def __str__(self) -> str:
        own = ", ".join(f"{key}={value!r}" for key, value in self._data.items())
        return f"UserData({own})" + (f" on {self._reference}" if len(self._reference) else "")

    __repr__ = __str__

    def _close(self) -> None:
        """Check what was lent and forget the own store, so that the view is as new.

        Raises:
            UserDataError: if an input was changed in place.
        """
        try:
            if self._lent:
                self._check()
        finally:
            self._forget()

    def _forget(self) -> None:
        self._data.clear()
        self._lent.clear()

    def _check(self) -> None:
        for key, (value, before) in self._lent.items():
            now = self._data.get(key, value)
            if now is value and (before is None or is_unchanged(before, fingerprint(value))):
                continue
            raise UserDataError(
                f"input key {key!r} was changed; declare it as output too, or change a copy"
            )

    def _why_unreadable(self, key: str) -> str:
        if self._input_keys is not None and key not in self._input_keys:
            declared = ", ".join(self._input_keys) or "none"
            return f"key {key!r} is not declared as input; declared: {declared}"
        source = self._remap.get(key, key)
        where = f" (it is remapped to {source!r})" if source != key else ""
        return f"there is no data for key {key!r}{where}; nothing has written it yet"


# Detect whether a value was changed in place.
#
# A fingerprint is the list of the value's unchangeable parts, in the order of a walk through it.
# The parts are kept, not copied: bytes of an image cost one reference. Taken again after the value
# was lent out, an equal fingerprint means that nothing was written into it.
#
# A list of many objects of one class, such as the poses of a path, is walked attribute by attribute
# in place of object by object: what they have in one attribute is one part.
#
# Supported: lists, tuples, sets, dicts, ROS messages, and objects with a buffer (arrays,
# bytearrays). Of a buffer beyond SAMPLED_BYTES only samples are compared. Other objects count as
# unchangeable, as they do in stock FlexBE, which compares their repr.


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
