"""Literals of the chart language: what `<param value>` and `ext:default` hold.

A literal is null, a boolean, a number, a string, a list or a dictionary, spelled as in JSON or as
in Python; lists and dictionaries nest at most `DEEPEST` levels. Text that is no literal is a
string. Nothing is ever evaluated.
"""

from __future__ import annotations

import ast
import json
import math
import re
import reprlib
from typing import TypeAlias

Literal: TypeAlias = (
    "bool | int | float | str | tuple[Literal, ...] | dict[str | int, Literal] | None"
)

DEEPEST = 50  # levels of a list or dictionary; Python itself refuses to parse 200
_WORDS = {"true": True, "True": True, "false": False, "False": False, "null": None, "None": None}
_INTEGER = re.compile(r"[+-]?(0|[1-9][0-9]{0,17})\Z")  # within 64 bits
_NUMBER = re.compile(r"[+-]?([0-9]+\.[0-9]*|\.[0-9]+|[0-9]+(?=[eE]))([eE][+-]?[0-9]+)?\Z")
# The FlexBE App counts brackets, quotes and '#' in parameter text without looking for strings, and
# ends a section of code at the word "def" between blanks. Escaped, they mean the same to Python.
_UNSAFE_IN_APP = re.compile(r"""[()\[\]{}#'"=]|(?<=\s)def(?=\s)""")


def parse_literal(text: str) -> Literal:
    """Return the value that a text spells."""
    spelled = text.strip()
    if spelled in _WORDS:
        return _WORDS[spelled]
    if _INTEGER.match(spelled):
        return int(spelled)
    if _NUMBER.match(spelled):
        number = float(spelled)
        return number if math.isfinite(number) else text
    if spelled[:1] in ("'", '"', "[", "{"):
        return _parse_structure(spelled, text)
    return text


def as_declared(text: str, wanted: str | None) -> Literal:
    """Return the value that a text spells where a type is declared.

    What is declared a string is the text as it stands, `5` and `true` too; only null stays null.
    """
    value = parse_literal(text)
    is_text = wanted == "string" and value is not None and not isinstance(value, str)
    return text if is_text else value


def _parse_structure(spelled: str, text: str) -> Literal:
    """Return the string, list or dictionary spelled as in JSON or Python, else the text itself."""
    for parse in (json.loads, _parse_python):
        try:
            return freeze(parse(spelled))
        except (ValueError, SyntaxError, TypeError, MemoryError, RecursionError):
            continue
    return text


def _parse_python(text: str) -> object:
    """Return what `ast.literal_eval` does, and read JSON's words too: `{'on': true}`."""
    tree = ast.parse(text, mode="eval")
    for parent in ast.walk(tree):
        for name, value in ast.iter_fields(parent):
            if isinstance(value, list):
                value[:] = [_as_constant(item) for item in value]
            else:
                setattr(parent, name, _as_constant(value))
    return ast.literal_eval(tree)


def _as_constant(node: object) -> object:
    """Return the constant for JSON's words, any other node as it is."""
    if isinstance(node, ast.Name) and node.id in _WORDS:
        return ast.Constant(_WORDS[node.id])
    return node


def freeze(value: object, depth: int = 0) -> Literal:
    """Return the value as a literal, its lists as tuples; it lies in so many lists already.

    Raises:
        TypeError: if it holds anything but the literals of the language, or is nested too deeply.
    """
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float) and math.isfinite(value):
        return value
    if depth < DEEPEST and isinstance(value, list | tuple):
        return tuple(freeze(item, depth + 1) for item in value)
    if depth < DEEPEST and isinstance(value, dict) and {*map(type, value)} <= {str, int}:
        return {key: freeze(item, depth + 1) for key, item in value.items()}
    raise TypeError(
        f"{reprlib.repr(value)} is no literal of a chart: null, a boolean, a finite number, a "
        "string, a list, or a dictionary with strings or integers as keys, of at most "
        f"{DEEPEST} levels"
    )


def format_literal(value: Literal, wanted: str | None = None) -> str:
    """Return the text that `as_declared` reads as this value."""
    if isinstance(value, str):
        is_plain = value.isprintable() and value != "" and as_declared(value, wanted) == value
        return value if is_plain or value == "" else json.dumps(value)
    if all(isinstance(key, str) for key in _keys_within(value)):
        return json.dumps(value)
    return python_literal(value)  # JSON has no integers as keys


def _keys_within(value: Literal) -> list[object]:
    """Return the keys of all dictionaries in a value."""
    if isinstance(value, tuple):
        return [key for item in value for key in _keys_within(item)]
    if isinstance(value, dict):
        return [*value, *(key for item in value.values() for key in _keys_within(item))]
    return []


def python_literal(value: Literal) -> str:
    """Return the Python expression for a value, on one line and harmless to the FlexBE App."""
    if isinstance(value, str):
        return quote(value)
    if isinstance(value, tuple):
        return "[" + ", ".join(map(python_literal, value)) + "]"
    if isinstance(value, dict):
        items = (f"{python_literal(key)}: {python_literal(item)}" for key, item in value.items())
        return "{" + ", ".join(items) + "}"
    return repr(value)


def quote(text: str) -> str:
    """Return a single-quoted Python string, harmless to the FlexBE App."""
    if text.isidentifier() and text.isascii():  # most are; the rest takes its time
        return f"'{text}'"
    backslashed = text.replace("\\", "\\\\")
    safe = _UNSAFE_IN_APP.sub(lambda found: f"\\x{ord(found[0][0]):02x}{found[0][1:]}", backslashed)
    return "'" + "".join(c if c.isprintable() else _escape(c) for c in safe) + "'"


def _escape(character: str) -> str:
    return ascii(character)[1:-1]


def type_of(value: Literal) -> str | None:
    """Return the language's name for a value's type; null has none and suits every type."""
    if value is None:
        return None
    names = {bool: "bool", int: "int", float: "float", str: "string", tuple: "list", dict: "dict"}
    return names[type(value)]
