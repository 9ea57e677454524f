"""Read input values, which arrive as the text of Python literals."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from typing import Any


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
