"""Events as plain data, and back: what the production database keeps of a run.

A run has tens of thousands of events, so the fields of a type are determined once.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from enum import Enum
from functools import cache
from types import NoneType, UnionType
from typing import Union, cast, get_args, get_origin, get_type_hints

from remodel_production.errors import OrderError
from remodel_supervision.core.runs.events import Event

_KINDS = {kind.__name__: kind for kind in get_args(Event)}
_PLAIN = frozenset({str, int, float, bool, NoneType})

_Build = Callable[[object], object]


def kind_of(event: Event) -> str:
    """Return the name of an event's kind."""
    return type(event).__name__


def data_of(event: Event) -> dict[str, object]:
    """Return an event's fields as plain data, for JSON."""
    return cast("dict[str, object]", plain(event))


def event_from(kind: str, data: Mapping[str, object]) -> Event:
    """Return the event that `data_of` has turned into plain data.

    Raises:
        OrderError: if there is no such kind, or a field is missing or of another type.
    """
    if kind not in _KINDS:
        raise OrderError(f"there is no event {kind!r}; there are {', '.join(_KINDS)}")
    try:
        return cast("Event", built(_KINDS[kind], data))
    except (KeyError, TypeError, ValueError) as error:
        raise OrderError(f"event {kind} is malformed: {error!r}") from error


def plain(value: object) -> object:
    """Return a value as plain data: dataclasses as mappings, enumerations as their values."""
    if type(value) in _PLAIN:
        return value
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, tuple):
        return [plain(item) for item in value]
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    kind: type = type(value)
    return {name: plain(getattr(value, name)) for name in _names(kind)}


def built(kind: object, value: object) -> object:
    """Return a value of a type from plain data.

    Args:
        kind: a dataclass, an enumeration, a tuple, a mapping of texts, one of them or None, or what
            JSON has.
        value: as `plain` has returned it; fields with a default may be left out.

    Raises:
        TypeError: if a part has another type, or a field is missing.
        ValueError: if there is an unknown field or member.
    """
    return _builder(kind)(value)


@cache
def _names(kind: type) -> tuple[str, ...]:
    return tuple(f.name for f in dataclasses.fields(kind))


@cache
def _builder(kind: object) -> _Build:
    """Return the function that builds values of a type."""
    origin, arguments = get_origin(kind), get_args(kind)
    if dataclasses.is_dataclass(kind):
        return _of_dataclass(cast("type", kind))
    if origin is tuple:
        if arguments[-1] is Ellipsis:
            return _of_any_length(_builder(arguments[0]))
        return _of_fixed_length([_builder(argument) for argument in arguments])
    if origin in (Union, UnionType):
        return _optional(_builder(next(a for a in arguments if a is not NoneType)))
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return _of_mapping(_builder(arguments[1]))
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind
    return _of_plain(cast("type", kind))


def _of_dataclass(kind: type) -> _Build:
    hints = get_type_hints(kind)
    builders = {name: _builder(hints[name]) for name in _names(kind)}

    def build(value: object) -> object:
        if not isinstance(value, Mapping):
            raise TypeError(f"{value!r} is no mapping")
        try:
            return kind(**{name: builders[name](item) for name, item in value.items()})
        except KeyError as error:
            raise ValueError(f"unknown field {error.args[0]}") from error

    return build


def _of_any_length(item: _Build) -> _Build:
    return lambda value: tuple([item(each) for each in _listed(value)])


def _of_fixed_length(items: list[_Build]) -> _Build:
    def build(value: object) -> object:
        return tuple(b(item) for b, item in zip(items, _listed(value), strict=True))

    return build


def _listed(value: object) -> list[object]:
    if not isinstance(value, list):
        raise TypeError(f"{value!r} is no list")
    return value


def _optional(build: _Build) -> _Build:
    return lambda value: None if value is None else build(value)


def _of_mapping(item: _Build) -> _Build:
    def build(value: object) -> object:
        if not isinstance(value, Mapping):
            raise TypeError(f"{value!r} is no mapping")
        return {name: item(each) for name, each in value.items()}

    return build


def _of_plain(kind: type) -> _Build:
    def build(value: object) -> object:
        if type(value) is kind:
            return value
        if kind is float and type(value) is int:
            return float(value)
        raise TypeError(f"{value!r} is not of type {getattr(kind, '__name__', kind)}")

    return build
