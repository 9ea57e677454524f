"""Read a cable tree from MiniZinc data (.dzn).

Of that format, what such files use: assignments of integers, lists `[1, 2]` and tables
`[| 1, 2 | 3, 4 |]`, comments from `%` to the end of the line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from remodel_cable_tree.core.problem import CableTree
from remodel_production.errors import InstanceError

_TOKEN = re.compile(
    r"(?P<blank>\s+|%[^\n]*)|(?P<name>[A-Za-z_]\w*)|(?P<number>-?\d{1,9}(?!\w))|(?P<sign>\[\||\|\]|[][|,;=])"
)
_NUMBERS = ("k", "b")
_TABLES = {"AtomicConstraints": 2, "DisjunctiveConstraints": 4, "SoftAtomicConstraints": 2}
_LIST = "DirectSuccessors"
_NAMES = (*_NUMBERS, *_TABLES, _LIST)


@dataclass(frozen=True)
class _Token:
    text: str
    line: int
    column: int

    def error(self, expected: str) -> InstanceError:
        found = f"`{self.text}`" if self.text else "the end"
        return InstanceError(
            f"line {self.line}, column {self.column}: expected {expected}, found {found}"
        )


def parse_cable_tree(text: str) -> CableTree:
    """Return the cable tree that a file's text describes.

    Raises:
        InstanceError: with line and column, or naming what is missing or inconsistent.
    """
    tokens = _Reader(text)
    values: dict[str, list[list[int]]] = {}
    while tokens.next.text:
        token = tokens.take("a name")
        name = token.text
        if name not in _NAMES:
            raise token.error("one of " + ", ".join(_NAMES))
        if name in values:
            raise token.error(f"each name once; {name} is assigned twice")
        tokens.expect("=")
        values[name] = _value(tokens, name)
        tokens.expect(";")
    missing = [name for name in _NAMES if name not in values]
    if missing:
        raise InstanceError(f"nothing is assigned to {', '.join(missing)}")
    return CableTree(
        values["k"][0][0],
        values["b"][0][0],
        tuple((x, y) for x, y in values["AtomicConstraints"]),
        tuple((a, b, c, d) for a, b, c, d in values["DisjunctiveConstraints"]),
        soft=tuple((x, y) for x, y in values["SoftAtomicConstraints"]),
        direct=tuple(values[_LIST][0]),
    )


def _value(tokens: _Reader, name: str) -> list[list[int]]:
    if name in _NUMBERS:
        return [[tokens.number()]]
    if name == _LIST:
        tokens.expect("[")
        row = list(tokens.numbers_until("]"))
        tokens.expect("]")
        return [row]
    rows = []
    tokens.expect("[|")
    while tokens.next.text != "|]":
        at = tokens.next
        row = list(tokens.numbers_until("|", "|]"))
        if row and len(row) != _TABLES[name]:
            raise at.error(f"a row of {_TABLES[name]} numbers")
        if row:
            rows.append(row)
        if tokens.next.text == "|":
            tokens.expect("|")
    tokens.expect("|]")
    return rows


class _Reader:
    def __init__(self, text: str) -> None:
        self._tokens = _tokens(text)
        self.next = next(self._tokens)

    def take(self, expected: str) -> _Token:
        token = self.next
        if not token.text:
            raise token.error(expected)
        self.next = next(self._tokens)
        return token

    def expect(self, sign: str) -> _Token:
        if self.next.text != sign:
            raise self.next.error(f"`{sign}`")
        return self.take(sign)

    def number(self) -> int:
        try:
            value = int(self.next.text)
        except ValueError as error:
            raise self.next.error("an integer") from error
        self.take("an integer")
        return value

    def numbers_until(self, *ends: str) -> Iterator[int]:
        while self.next.text not in ends:
            yield self.number()
            if self.next.text not in ends:
                self.expect(",")


def _tokens(text: str) -> Iterator[_Token]:
    position, line, line_start = 0, 1, 0
    while position < len(text):
        match = _TOKEN.match(text, position)
        token = _Token(text[position : position + 10], line, position - line_start + 1)
        if match is None:
            raise token.error(
                "an integer of at most 9 digits, a name or one of `[| | |] [ ] , ; =`"
            )
        if match.lastgroup != "blank":
            yield _Token(match.group(), line, position - line_start + 1)
        lines = match.group().count("\n")
        if lines:
            line += lines
            line_start = position + match.group().rindex("\n") + 1
        position = match.end()
    end = _Token("", line, position - line_start + 1)
    while True:
        yield end
