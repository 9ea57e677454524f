"""Events as plain data, and back: what the production database keeps of a run."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from enum import Enum
from typing import get_args, get_origin, get_type_hints

from remodel_planner.core.supervision.events import Event
from remodel_planner.errors import OrderError

_KINDS = {kind.__name__: kind for kind in get_args(Event)}


def kind_of(event: Event) -> str:
    """Return the name of an event's kind."""
    return type(event).__name__


def data_of(event: Event) -> dict[str, object]:
    """Return an event's fields as plain data, for JSON."""
    return _plain(event)  # type: ignore[no-any-return]


def event_from(kind: str, data: Mapping[str, object]) -> Event:
    """Return the event that `data_of` has turned into plain data.

    Raises:
        OrderError: if there is no such kind, or a field is missing or of another type.
    """
    if kind not in _KINDS:
        raise OrderError(f"there is no event {kind!r}; there are {', '.join(_KINDS)}")
    try:
        return _built(_KINDS[kind], data)  # type: ignore[no-any-return]
    except (KeyError, TypeError, ValueError) as error:
        raise OrderError(f"event {kind} is malformed: {error!r}") from error


def _plain(value: object) -> object:
    if dataclasses.is_dataclass(value):
        return {f.name: _plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value


def _built(kind: object, value: object) -> object:
    """Return a value of a type: a dataclass, an enumeration, a tuple, or what JSON has."""
    if dataclasses.is_dataclass(kind):
        if not isinstance(value, Mapping):
            raise TypeError(f"{value!r} is no mapping")
        hints = get_type_hints(kind)
        unknown = set(value) - set(hints)
        if unknown:
            raise ValueError(f"unknown field {min(unknown)}")
        return kind(**{name: _built(hints[name], item) for name, item in value.items()})  # type: ignore[operator]
    if get_origin(kind) is tuple:
        if not isinstance(value, list):
            raise TypeError(f"{value!r} is no list")
        kinds = get_args(kind)
        inner = [kinds[0]] * len(value) if kinds[-1] is Ellipsis else kinds
        return tuple(_built(k, item) for k, item in zip(inner, value, strict=True))
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind(value)
    if kind is float and type(value) is int:
        return float(value)
    if type(value) is not kind:
        raise TypeError(f"{value!r} is not of type {getattr(kind, '__name__', kind)}")
    return value
