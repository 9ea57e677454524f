"""Cable Tree Wiring, after Koehler et al., Constraints 2021 (arXiv 2011.12862).

A harness has ends 1 to k. Ends i and i + b, for i up to b, are the two ends of cable i; the others
belong to cables with one end in this harness.

Of that format, what such files use: assignments of integers, lists `[1, 2]` and tables
`[| 1, 2 | 3, 4 |]`, comments from `%` to the end of the line.

This checks what the kernel finds, and is its plain reference.

A round anneals from the best order so far, or from a new one in which cables, taken by chance, have
their ends one right after the other as far as possible. The number of cables stored decides the
cost, and annealing alone rarely finds out of which cables to store; gathering does, and annealing
does the rest. Work is counted in moves, so that the same seed and limit give the same order on
every machine that is not too slow for them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from remodel_production.errors import InstanceError


@dataclass(frozen=True)
class CableTree:
    """A harness whose ends are to be inserted one after another.

    Attributes:
        ends: k.
        cables: b, those with two ends in the harness.
        atomic: (x, y): x before y.
        disjunctive: (a, b, c, d): a before b, or c before d.
        soft: (x, y): x should come before y.
        direct: x: if x comes before the other end of its cable, that one follows at once.
    """

    ends: int
    cables: int
    atomic: tuple[tuple[int, int], ...]
    disjunctive: tuple[tuple[int, int, int, int], ...]
    soft: tuple[tuple[int, int], ...]
    direct: tuple[int, ...]

    def __post_init__(self) -> None:
        """Refuse ends that are not there.

        Raises:
            InstanceError: naming the constraint.
        """
        if self.ends < 0 or not 0 <= 2 * self.cables <= self.ends:
            raise InstanceError(
                f"k = {self.ends}, b = {self.cables}: expected 0 <= 2 b <= k, since each two-sided "
                "cable has two ends"
            )
        for name, rows in (
            ("AtomicConstraints", self.atomic),
            ("DisjunctiveConstraints", self.disjunctive),
            ("SoftAtomicConstraints", self.soft),
            ("DirectSuccessors", tuple((end,) for end in self.direct)),
        ):
            for number, row in enumerate(rows, 1):
                for end in row:
                    if not 1 <= end <= self.ends:
                        raise InstanceError(
                            f"{name}, row {number}: no end {end}; ends are 1 to {self.ends}"
                        )

    def other_end(self, end: int) -> int | None:
        """Return the other end of a two-sided cable, None for a one-sided one."""
        if end > 2 * self.cables:
            return None
        return end + self.cables if end <= self.cables else end - self.cables


@dataclass(frozen=True)
class Constraint:
    """A row of a table of hard constraints.

    Attributes:
        table: its name in the file.
        row: from 1, as in the file.
        ends: of the row.
    """

    table: str
    row: int
    ends: tuple[int, ...]

    def __str__(self) -> str:
        if self.table == "AtomicConstraints":
            text = "end {} before end {}".format(*self.ends)
        elif self.table == "DisjunctiveConstraints":
            text = "end {} before end {}, or end {} before end {}".format(*self.ends)
        else:
            text = (
                f"the other end of its cable follows end {self.ends[0]} at once if it comes later"
            )
        return f"{self.table}, row {self.row}: {text}"


def constraints_of(tree: CableTree) -> list[Constraint]:
    """Return the hard constraints of a cable tree; the direct successors come last."""
    tables = (
        ("AtomicConstraints", tree.atomic),
        ("DisjunctiveConstraints", tree.disjunctive),
        ("DirectSuccessors", tuple((end,) for end in tree.direct)),
    )
    return [
        Constraint(name, number, row) for name, rows in tables for number, row in enumerate(rows, 1)
    ]


def with_constraints(tree: CableTree, kept: Sequence[Constraint]) -> CableTree:
    """Return a cable tree with no hard constraints but those."""
    atomic, disjunctive, direct = [], [], []
    for each in kept:
        match each.ends:
            case (x, y):
                atomic.append((x, y))
            case (a, b, c, d):
                disjunctive.append((a, b, c, d))
            case (end,):
                direct.append(end)
    return replace(tree, atomic=tuple(atomic), disjunctive=tuple(disjunctive), direct=tuple(direct))


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


@dataclass(frozen=True)
class OrderCost:
    """What an order costs; the parts in the order of their importance.

    Attributes:
        stored: cables whose ends are not inserted one right after the other.
        open: the most cables that hang open at the insertion of another cable's end.
        longest: time between the ends of a cable, at its longest, less one.
        soft: violated soft constraints.
        total: stored k^3 + open k^2 + longest k + soft.
    """

    stored: int
    open: int
    longest: int
    soft: int
    total: int


def cost_of(tree: CableTree, order: Sequence[int]) -> OrderCost:
    """Return the cost of an order of the ends 1 to k."""
    place = {end: i for i, end in enumerate(order)}
    spans = [
        tuple(sorted((place[cable], place[cable + tree.cables])))
        for cable in range(1, tree.cables + 1)
    ]
    stored = sum(last - first > 1 for first, last in spans)
    times = [time for span in spans for time in span]
    hanging = max((sum(first < t < last for first, last in spans) for t in times), default=0)
    longest = max((last - first - 1 for first, last in spans), default=0)
    soft = sum(place[x] > place[y] for x, y in tree.soft)
    k = tree.ends
    total = ((stored * k + hanging) * k + longest) * k + soft
    return OrderCost(stored, hanging, longest, soft, total=total)


def violations(tree: CableTree, order: Sequence[int]) -> Iterator[str]:
    """Yield the constraints that an order violates, a line each."""
    if sorted(order) != list(range(1, tree.ends + 1)):
        yield f"not an order of the ends 1 to {tree.ends}"
        return
    place = {end: i for i, end in enumerate(order)}
    for x, y in tree.atomic:
        if place[x] >= place[y]:
            yield f"end {x} does not come before end {y}"
    for a, b, c, d in tree.disjunctive:
        if place[a] >= place[b] and place[c] >= place[d]:
            yield f"neither does end {a} come before end {b}, nor end {c} before end {d}"
    for x in tree.direct:
        other = tree.other_end(x)
        if other is not None and place[x] < place[other] != place[x] + 1:
            yield f"end {x} comes first, but end {other} does not follow at once"


@dataclass(frozen=True)
class Recipe:
    """Temperatures, and what each part of the cost weighs while annealing.

    With their true weights, k to k^3, the parts would freeze one after the other; with these, a
    plan may pay with one for another. The best order is chosen by the true cost.

    Attributes:
        weights: of violated constraints, stored cables, open cables, the longest time, violated
            soft constraints.
    """

    start_temperature: float
    end_temperature: float
    weights: tuple[float, float, float, float, float]


# Found on the public instances of 64 to 198 ends; each is the best for some of them.
_RECIPES = (
    Recipe(4.0, 0.05, (50.0, 8.0, 3.0, 0.5, 0.2)),
    Recipe(10.0, 0.03, (100.0, 30.0, 5.0, 0.5, 0.1)),
    Recipe(10.0, 0.05, (50.0, 8.0, 3.0, 0.5, 0.2)),
    Recipe(10.0, 0.03, (50.0, 30.0, 10.0, 1.0, 0.1)),
)


@dataclass(frozen=True)
class Round:
    """One annealing run.

    Attributes:
        gathers: new orders to gather before, of which the best is annealed; 0: anneal the best.
        most_nodes: of the search that completes a gathered order.
    """

    recipe: Recipe
    moves: int
    gathers: int
    most_nodes: int


_MOVES_PER_END = 4_000
# Beyond this a search has found what it will find.
_MOST_MOVES_PER_PAIR = 5_000
# What gathering takes, as moves for each end; the least that was measured is 200, the most 1400.
_GATHER_PER_END = 1_000
_FIRST_GATHERS = 12
# The first gathers get no more than this part of the work.
_FIRST_SHARE = 0.3
# Every third round starts from a new order.
_RESTART = 3
_FEW_NODES, _MANY_NODES = 100, 1_000


def moves_per_second(ends: int) -> float:
    """Return the moves that a search is given for a second.

    55 to 75 % of what one core of an AMD EPYC of 2024 makes.
    """
    return 2.2e7 / math.sqrt(ends)


def rounds(ends: int, limit_s: float) -> Iterator[Round]:
    """Yield the rounds of a search of that length."""
    left = min(limit_s * moves_per_second(ends), _MOST_MOVES_PER_PAIR * ends * ends)
    gather = _GATHER_PER_END * ends
    first_gathers = min(_FIRST_GATHERS, int(left * _FIRST_SHARE / gather))
    moves = max(1, min(_MOVES_PER_END * ends, int(left / 4)))
    turn = 0
    while left > 0:
        gathers = first_gathers if turn == 0 else int(turn % _RESTART == 0)
        nodes = _MANY_NODES if turn % (2 * _RESTART) == 0 else _FEW_NODES
        yield Round(_RECIPES[turn % len(_RECIPES)], moves, gathers, nodes)
        left -= moves + gathers * gather
        turn += 1
