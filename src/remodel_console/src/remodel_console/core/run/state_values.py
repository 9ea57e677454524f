"""The userdata that states find and leave behind: shown, recorded, and given to a start."""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import yaml

from flexbe_core.engine.visit import Place

_LONGEST = 20_000  # characters of a value that is recorded; a picture is larger


class _MessageLoader(yaml.SafeLoader):  # type: ignore[misc]
    """Reads what a ROS message prints, whose numbers may be `3e-07`, which is no number in YAML."""


_MessageLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"-?[0-9.]+e[+-]?[0-9]+\Z"), [*"-0123456789"]
)


@dataclass(frozen=True)
class Value:
    """One value of userdata.

    Attributes:
        container: path of the container that has it, `/Place`; empty: the behavior itself.
        key: its name there.
        kind: name of its class.
        literal: the Python literal that stands for it; empty if none does.
    """

    container: str
    key: str
    kind: str
    literal: str

    @property
    def name(self) -> str:
        """Return the name by which a start at a state takes it."""
        return f"{self.container}/{self.key}" if self.container else self.key


@dataclass(frozen=True)
class StateValues:
    """What a state found when it became active, at a ROS time [s]."""

    time_s: float
    path: str
    values: tuple[Value, ...]

    def as_json(self) -> list[Any]:
        """Return what `from_json` reads."""
        rows = [[v.container, v.key, v.kind, v.literal] for v in self.values]
        return [round(self.time_s, 3), self.path, rows]

    @classmethod
    def from_json(cls, found: Any) -> StateValues:  # noqa: ANN401 - whatever a file has
        """Return recorded values.

        Raises:
            ValueError, TypeError: if it is something else.
        """
        time_s, path, rows = found
        values = (Value(*map(str, row)) for row in rows)
        return cls(float(time_s), str(path), tuple(values))


def values_around(path: str, known: Mapping[Place, tuple[str, str]]) -> tuple[Value, ...]:
    """Return the values of the behavior and of the containers around a state.

    Args:
        path: of the state, `/Place/Insert`.
        known: class and text of all values.
    """
    return tuple(
        Value(container, key, kind, literal_of(kind, text))
        for (container, key), (kind, text) in known.items()
        if path.startswith(f"{container}/")
    )


@dataclass(frozen=True)
class Row:
    """A value of a state, as text: as it was found, and as it was left behind; empty if neither."""

    key: str
    found: str = ""
    left: str = ""


def literal_of(kind: str, text: str) -> str:
    """Return the literal of a value that was printed; of a message, that of its fields.

    Args:
        kind: name of its class.
        text: as `str` returns it.
    """
    if len(text) > _LONGEST:
        return ""
    if kind == "str":
        return repr(text)
    try:
        ast.literal_eval(text)
    except (ValueError, SyntaxError, MemoryError, RecursionError, TypeError):
        return _fields_of(text)
    return text


def _fields_of(text: str) -> str:
    """Return the fields of a ROS message, which prints itself as YAML; empty of anything else."""
    try:
        fields = yaml.load(text, _MessageLoader)
    except yaml.YAMLError:
        return ""
    return repr(fields) if isinstance(fields, dict) else ""
