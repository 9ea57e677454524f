"""Two recorded runs side by side: which of their steps are the same, and where they part first.

A step is a state that was entered, a task that began or ended, a failure, a decision or an answer.
Two steps are the same if they say the same about the same task and state, whenever they happened
and whatever was measured.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from difflib import SequenceMatcher
from itertools import zip_longest

from remodel_console.core.use_case.record import Record
from remodel_run.record import Entry, Kind, entry_words

_KINDS = (Kind.TASK, Kind.STATE, Kind.FAILURE, Kind.DECISION, Kind.OPERATOR)


@dataclass(frozen=True)
class Step:
    """A step of one run: the index of its entry, when it was in the run [s], and its words."""

    index: int
    offset_s: float
    words: str


@dataclass(frozen=True)
class Row:
    """What stands beside each other; None: this run has no such step."""

    left: Step | None
    right: Step | None
    is_same: bool


@dataclass(frozen=True)
class Comparison:
    """The steps of two runs.

    Attributes:
        rows: in the order in which they happened.
        first: index of the first row that differs; None if the runs took the same steps.
    """

    rows: tuple[Row, ...]
    first: int | None


def compare(left: Record, right: Record) -> Comparison:
    """Return the steps of two runs side by side."""
    rows = tuple(_rows(left, right))
    first = next((place for place, row in enumerate(rows) if not row.is_same), None)
    return Comparison(rows, first)


def _rows(left: Record, right: Record) -> Iterator[Row]:
    sides = [[e for e in record.entries if e.kind in _KINDS] for record in (left, right)]
    ours, theirs = sides
    keys = [[_key(entry) for entry in side] for side in sides]
    start = _same_at_first(*keys)  # most of two long runs; the matcher needs the square of it
    for one, other in zip(ours[:start], theirs[:start], strict=True):
        yield Row(_step(left, one), _step(right, other), is_same=True)
    matcher = SequenceMatcher(None, keys[0][start:], keys[1][start:], autojunk=False)
    for tag, i1, i2, j1, j2 in matcher.get_opcodes():
        steps = [_step(left, entry) for entry in ours[start + i1 : start + i2]]
        others = [_step(right, entry) for entry in theirs[start + j1 : start + j2]]
        for step, beside in zip_longest(steps, others):
            yield Row(step, beside, is_same=tag == "equal")


def _same_at_first(ours: list[object], theirs: list[object]) -> int:
    pairs = enumerate(zip(ours, theirs, strict=False))
    return next((i for i, (a, b) in pairs if a != b), min(len(ours), len(theirs)))


def _key(entry: Entry) -> object:
    """Return what makes a step the same: of a failure not its text, which has measurements."""
    text = (entry.fault, entry.error_code) if entry.kind is Kind.FAILURE else entry.text
    return entry.kind, entry.task, entry.behavior, entry.state_path, text


def _step(record: Record, entry: Entry) -> Step:
    words = entry_words(entry)
    about = f"{entry.task}: {words}" if entry.task else words
    return Step(entry.position - 1, record.offset_s(entry), about)
