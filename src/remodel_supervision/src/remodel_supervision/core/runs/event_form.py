"""Events as plain data, and back: what the production database keeps of a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import cast, get_args

import msgspec

from remodel_production.errors import OrderError
from remodel_supervision.core.runs.events import Event

_KINDS = {kind.__name__: kind for kind in get_args(Event)}


def kind_of(event: Event) -> str:
    """Return the name of an event's kind."""
    return type(event).__name__


def data_of(event: Event) -> dict[str, object]:
    """Return an event's fields as plain data, for JSON: enumerations as their values."""
    return cast("dict[str, object]", msgspec.to_builtins(event))


def event_from(kind: str, data: Mapping[str, object]) -> Event:
    """Return the event that `data_of` has turned into plain data.

    Fields with a default may be left out.

    Raises:
        OrderError: if there is no such kind, or a field is missing, unknown or of another type.
    """
    if kind not in _KINDS:
        raise OrderError(f"there is no event {kind!r}; there are {', '.join(_KINDS)}")
    try:
        event = cast("Event", msgspec.convert(data, _KINDS[kind]))
    except msgspec.ValidationError as error:
        raise OrderError(f"event {kind} is malformed: {error}") from error
    # msgspec ignores names that are no field of a dataclass.
    if unknown := list(_unknown(data, msgspec.to_builtins(event))):
        raise OrderError(f"event {kind} is malformed: unknown field {', '.join(unknown)}")
    return event


def _unknown(data: object, known: object) -> Iterator[str]:
    """Yield the names of mappings in plain data that the same data of an event does not have."""
    if isinstance(data, Mapping) and isinstance(known, Mapping):
        for name, value in data.items():
            if name in known:
                yield from _unknown(value, known[name])
            else:
                yield name
    elif isinstance(data, list) and isinstance(known, list | tuple):
        for value, same in zip(data, known, strict=True):
            yield from _unknown(value, same)
