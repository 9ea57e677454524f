"""What a start request carries: changes of the source, and input values."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flexbe_onboard.errors import StartError


@dataclass(frozen=True)
class Modification:
    """A replacement of characters [begin, end) of the unmodified text."""

    begin: int
    end: int
    content: str


def modified(text: str, modifications: Sequence[Modification]) -> str:
    """Return the text with all modifications.

    Raises:
        StartError: if they are not in ascending order, overlap or reach beyond the text.
    """
    parts, position = [], 0
    for index, change in enumerate(modifications):
        if not position <= change.begin <= change.end <= len(text):
            raise StartError(
                f"modification {index} replaces characters {change.begin} to {change.end}; it must "
                f"begin at {position} or later, behind the one before, and end by {len(text)}"
            )
        parts += [text[position : change.begin], change.content]
        position = change.end
    return "".join([*parts, text[position:]])


# Read input values, which arrive as the text of Python literals


class AttributeDict(dict[str, Any]):
    """A dict whose values can be read as attributes too, as states of stock FlexBE expect."""

    def __getattr__(self, key: str) -> Any:  # noqa: ANN401 - whatever was sent
        """Return the value of a key."""
        try:
            return self[key]
        except KeyError as error:
            raise AttributeError(f"no value named {key!r}") from error


def read_inputs(keys: Sequence[str], values: Sequence[str]) -> dict[str, Any]:
    """Return the inputs of a start request; empty keys are skipped."""
    return {key: read_value(value) for key, value in zip(keys, values, strict=False) if key}


def read_value(text: str) -> Any:  # noqa: ANN401 - whatever was sent
    """Return the value of a literal; other text stays a string. Nothing is evaluated."""
    try:
        return _with_attributes(ast.literal_eval(text))
    except (ValueError, SyntaxError, MemoryError, RecursionError, TypeError):
        return text


def _with_attributes(value: Any) -> Any:  # noqa: ANN401 - likewise
    if isinstance(value, dict):
        return AttributeDict({key: _with_attributes(item) for key, item in value.items()})
    if isinstance(value, list):
        return [_with_attributes(item) for item in value]
    return value
