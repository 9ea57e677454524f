"""What is wrong with a table of abilities or faults, or with a document by its JSON schema."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import jsonschema


class TableError(Exception):
    """A table of abilities or faults cannot be read or contradicts another one.

    Attributes:
        problems: every problem: its place in the file, what was found, and what is allowed.
    """

    def __init__(self, file: str, problems: Sequence[str]) -> None:
        """List every problem at once."""
        lines = "\n".join(f"  - {problem}" for problem in problems)
        count = f"{len(problems)} problem{'s' if len(problems) != 1 else ''}"
        super().__init__(f"{file}: {count}:\n{lines}")
        self.problems = tuple(problems)


# Explain where a document does not have the form of a JSON schema


_ALLOWED = {
    "type": "a value of type {}",
    "minimum": "{} or more",
    "maximum": "{} or less",
    "exclusiveMinimum": "more than {}",
    "minItems": "{} entries or more",
    "maxItems": "{} entries or fewer",
    "minProperties": "{} entries or more",
    "pattern": "text that matches {}",
}


def schema_problems(parsed: object, schema: dict[str, Any]) -> Iterator[str]:
    """Yield each problem: its place in the document, what was found and what is allowed."""
    import jsonschema  # loads a web client, and most commands check no document

    errors = jsonschema.Draft7Validator(schema).iter_errors(parsed)
    for error in sorted(errors, key=lambda error: [str(part) for part in error.absolute_path]):
        # Of alternatives (anyOf), the one that fits best.
        deepest = jsonschema.exceptions.best_match([error])
        yield f"{_place(deepest) or 'the file'}: {_explanation(deepest)}"
    yield from _not_finite(parsed, "")


def _place(error: jsonschema.ValidationError) -> str:
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in error.absolute_path)
    return "".join(parts).lstrip(".")


def _explanation(error: jsonschema.ValidationError) -> str:
    """Return what was found and what is allowed."""
    found, rule = error.instance, error.validator_value
    if error.validator == "required":
        missing = ", ".join(name for name in rule if name not in found)
        return f"found {', '.join(found) or 'nothing'}; missing: {missing}"
    if error.validator == "additionalProperties":
        allowed = error.schema["properties"]
        unknown = ", ".join(str(name) for name in found if name not in allowed)
        return f"found {unknown}; allowed: {', '.join(allowed)}"
    if error.validator == "enum":
        return f"found {found!r}; allowed: {', '.join(map(str, rule))}"
    if error.validator in _ALLOWED:
        return f"found {found!r}; allowed: {_ALLOWED[error.validator].format(rule)}"
    return str(error.message)


def _not_finite(value: object, place: str) -> Iterator[str]:
    """Yield the numbers that a schema accepts although they are NaN or infinite."""
    if isinstance(value, float) and not math.isfinite(value):
        yield f"{place}: found {value}; allowed: a finite number"
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from _not_finite(item, f"{place}.{key}".lstrip("."))
    elif isinstance(value, list):
        for i, item in enumerate(value):
            yield from _not_finite(item, f"{place}[{i}]")
