"""The headings of a table, which may take one row or two.

Spreadsheets group their columns: a row of groups ("From", "To"; cells that span columns are empty
but for the first one) above a row of what each column of a group has ("Device", "Pin"). Others have
a row of units below the headings.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest

from remodel_production.core.imports.wire_lists.headings import fields_of, has_meaning, is_unit

# Longer rows, and rows with longer cells, are no headings.
_MOST_HEADINGS = 500
_MOST_SIGNS = 200
_MOST_LINES = 40  # of one row, whose cells may have line breaks
_NO_UNIT = frozenset({"", "-", "--", "\N{EN DASH}", "\N{EM DASH}"})


@dataclass(frozen=True)
class HeadingRows:
    """The headings of a table.

    Attributes:
        cells: of the headings.
        lines: that they take.
        rows: of which they are made; a table may repeat them, such as on each page.
    """

    cells: tuple[str, ...]
    lines: int
    rows: tuple[tuple[str, ...], ...]


def headings_at(lines: Sequence[str], first: int, separator: str) -> HeadingRows:
    """Return the headings that begin at a line.

    A second row counts as headings if it holds nothing but units, or if more columns have a meaning
    with it than without it, and most of its cells have words of headings.
    """
    above, taken = _record(lines, first, separator)
    below, more = _record(lines, first + taken, separator)
    alone = HeadingRows(tuple(above), taken, (_trimmed(above),))
    both = (_trimmed(above), _trimmed(below))
    if not (any(above) and any(below)):
        return alone
    if _are_units(below):
        units = [f"[{text.strip('[]() ')}]" if text not in _NO_UNIT else "" for text in below]
        return HeadingRows(_joined(above, units), taken + more, both)
    together = _joined(list(_spread(above, below)), below)
    known, known_together = (len(fields_of(each)) for each in (above, together))
    own = sum(has_meaning(text) for text in below if text)
    if known_together > known and 2 * own >= sum(map(bool, below)):
        return HeadingRows(together, taken + more, both)
    return alone


def _record(lines: Sequence[str], first: int, separator: str) -> tuple[list[str], int]:
    """Return the cells that begin at a line, none if they are no headings, and their lines."""
    reader = csv.reader(iter(lines[first : first + _MOST_LINES]), delimiter=separator)
    try:
        cells = next(reader, [])
    except csv.Error:
        return [], 1
    if len(cells) > _MOST_HEADINGS or any(len(cell) > _MOST_SIGNS for cell in cells):
        return [], 1
    return [" ".join(cell.split()) for cell in cells], max(1, reader.line_num)


def _are_units(cells: Sequence[str]) -> bool:
    stated = [cell for cell in cells if cell not in _NO_UNIT]
    return bool(stated) and all(map(is_unit, stated))


def _spread(above: Sequence[str], below: Sequence[str]) -> Iterator[str]:
    """Yield the group of each column: that on the left of an empty cell, unless it ends there."""
    group = ""
    for own, part in zip_longest(above, below, fillvalue=""):
        if own or not part:
            group = own if part else ""
            yield own
        else:
            yield group


def _joined(above: Sequence[str], below: Sequence[str]) -> tuple[str, ...]:
    return tuple(f"{a} {b}".strip() for a, b in zip_longest(above, below, fillvalue=""))


def _trimmed(cells: Sequence[str]) -> tuple[str, ...]:
    """Return cells without the empty ones at the end."""
    filled = [i for i, cell in enumerate(cells) if cell]
    return tuple(cells[: filled[-1] + 1 if filled else 0])
