"""Read a from-to list as a table: headings of one row or two, rows, and what columns mean.

Spreadsheets group their columns: a row of groups ("From", "To"; cells that span columns are empty
but for the first one) above a row of what each column of a group has ("Device", "Pin"). Others have
a row of units below the headings.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import dataclass, replace
from itertools import zip_longest

from remodel_production.core.imports.assembly import unique_name
from remodel_production.core.imports.documents import SEPARATOR, decode, is_spreadsheet, sheets_of
from remodel_production.core.imports.values import LeftOut
from remodel_production.core.imports.wire_list_headings import (
    fields_of,
    has_meaning,
    is_unit,
    names_contact,
    similar_heading,
    unit_in,
)
from remodel_production.core.imports.wire_list_mapping import ENDS, PIN_LIST, Field, WireListMapping
from remodel_production.errors import DesignError, blamed

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


_SEPARATORS = (";", "\t", ",", "|")
# Reports begin with titles; below that many lines, no headings are searched.
_HEADINGS_WITHIN = 30
_MOST_ROWS = 50_000
_MOST_LENGTH = 50_000  # characters of a cell
# What a cut list has, which states no ends.
_CUT = (Field.SECTION, Field.LENGTH)


@dataclass(frozen=True)
class Row:
    """A line of a list.

    Attributes:
        line: number of its first line in the file.
    """

    line: int
    cells: list[str]

    def cell(self, column: int | None) -> str:
        """Return what is in a column; empty if the row has none or ends before it."""
        return self.cells[column] if column is not None and column < len(self.cells) else ""

    def repeats(self, rows: Sequence[tuple[str, ...]]) -> bool:
        """Return whether this is one of some rows, as far as those have cells."""
        return any(
            tuple(self.cells[: len(row)]) == row and not any(self.cells[len(row) :]) for row in rows
        )


@dataclass(frozen=True)
class Table:
    """The rows under the headings.

    Attributes:
        headings: of which the second "Pin" is "Pin#2".
        columns: number of each field's column.
        listed: those fields of them that the mapping lists.
        heading_rows: of which the headings are made.
        first_line: of the rows, from 1.
        separator: of cells.
        repeated: how many of the headings repeat the others, for the second ends of a pin list.
    """

    mapping: WireListMapping
    headings: tuple[str, ...]
    columns: dict[Field, int]
    listed: frozenset[Field]
    heading_rows: tuple[tuple[str, ...], ...]
    first_line: int
    separator: str
    rows: tuple[Row, ...] = ()
    repeated: int = 0

    @property
    def names_both_ends(self) -> bool:
        """Whether there is a column of each end's component."""
        return all(whole in self.columns or part in self.columns for whole, part in ENDS)

    @property
    def is_usable(self) -> bool:
        """Whether there are both ends of a wire in a line, or one and the wire's name."""
        return self.names_both_ends or self.columns.keys() >= {*PIN_LIST}

    def cells(self, field: Field) -> list[str]:
        """Return the contents of a field's column."""
        column = self.columns.get(field)
        return [] if column is None else [row.cell(column) for row in self.rows]

    def unit(self, field: Field) -> str:
        """Return the unit that the heading of a field's column states; empty if none."""
        column = self.columns.get(field)
        return "" if column is None else unit_in(self.headings[column], field)


@dataclass(frozen=True)
class Source:
    """The text of a list.

    Attributes:
        assumed: of the file; empty if nothing was.
        sheet: of a workbook.
        separators: of its cells; empty if they are to be found.
        others: sheets beside it.
    """

    text: str
    assumed: str
    separators: tuple[str, ...] = ()
    others: tuple[LeftOut, ...] = ()
    sheet: str = ""

    def blamed(self) -> AbstractContextManager[None]:
        """Return what names the sheet in errors about it."""
        return blamed(f"sheet {self.sheet!r}") if self.sheet else nullcontext()


def has_headings(data: bytes, mappings: Sequence[WireListMapping]) -> bool:
    """Return whether the data is a list with the headings of one of the mappings."""
    try:
        _headed(data, mappings)
    except DesignError:
        return False
    return True


def read_table(data: bytes, mappings: Sequence[WireListMapping]) -> tuple[Table, Source]:
    """Return the list by the mapping that fits best, and the text that it is in.

    Raises:
        DesignError: if no mapping fits, or the rows cannot be read.
    """
    table, source = _headed(data, mappings)
    with source.blamed():
        return replace(table, rows=tuple(_rows(source.text, table))), source


def headings_table(data: bytes) -> tuple[Table, Source]:
    """Return the headings with the most meaning of a file in which not both ends are found.

    And the text, or the sheet of a workbook, that they are in.

    Raises:
        DesignError: if no line of it has cells.
    """
    mapping = WireListMapping("", {}, has_synonyms=True)
    tables = [
        (table, source)
        for source in _sources(data, "", "", _sheets(data))
        for separator in source.separators or _SEPARATORS
        for table in _tables(source.text, mapping, separator)
        if len(table.headings) > 1
    ]
    if not tables:
        raise DesignError("no line of it has cells: a CSV file with a line of headings is needed")
    return max(tables, key=lambda found: (len(found[0].columns), len(found[0].headings)))


def similar_headings(headings: Sequence[str]) -> str:
    """Return which headings may be misspelt, and for what; empty if none."""
    similar = {heading: similar_heading(heading) for heading in headings}
    return ", ".join(f"{heading!r} to {near!r}" for heading, near in similar.items() if near)


def without_ends(data: bytes) -> str:
    """Return why a file that is no wire list is none; empty if it has nothing of one."""
    try:
        table, source = headings_table(data)
    except DesignError:
        return ""
    where = f" in sheet {source.sheet!r}" if source.sheet else ""
    known = {field.value: table.headings[column] for field, column in table.columns.items()}
    similar = similar_headings([h for i, h in enumerate(table.headings) if h])
    text = ""
    if known:
        found = ", ".join(f"{heading!r} as {field}" for field, heading in known.items())
        missing = [
            f"{whole.value} or {part.value}"
            for whole, part in ENDS
            if whole not in table.columns and part not in table.columns
        ]
        text = f"; read as headings{where}: {found}; missing: {' and '.join(missing)}"
        if len(missing) == len(ENDS) and any(field in table.columns for field in _CUT):
            text += (
                "; a cut list states how wires are cut, not where they end: import the list of the "
                "connections"
            )
    return text + (f"; similar: {similar}" if similar else "")


def _headed(data: bytes, mappings: Sequence[WireListMapping]) -> tuple[Table, Source]:
    """Return the list, without its rows, by the mapping that fits best."""
    best: tuple[tuple[int, ...], Table, Source] | None = None
    sheets = _sheets(data)
    for mapping in mappings:
        for source in _sources(data, mapping.encoding, mapping.sheet, sheets):
            own = (mapping.separator,) if mapping.separator else _SEPARATORS
            for separator in source.separators or own:
                tables = _tables(source.text, mapping, separator)
                table = next((each for each in tables if each.is_usable), None)
                if table is None:
                    continue
                body = source.text.splitlines()[table.first_line - 1 :]
                fit = (
                    any(map(str.strip, body)),
                    table.names_both_ends,
                    len(table.columns),
                    *_known(table),
                )
                if best is None or fit > best[0]:
                    best = fit, table, source
    if best is None:
        raise DesignError(
            f"no line of the first {_HEADINGS_WITHIN} has the headings of a wire list; found "
            f"{_first_line(data)[:120]!r}; {_wanted(mappings)}{without_ends(data)}; give the "
            "columns with --mapping, which --print-mapping drafts"
        )
    return best[1], best[2]


def _first_line(data: bytes) -> str:
    """Return the headings with the most meaning, or else the first line that is not empty."""
    try:
        table, source = headings_table(data)
    except DesignError:
        source, first = next(_sources(data, "", "", _sheets(data))), 1
    else:
        first = table.first_line - 1
    lines = (line for line in source.text.splitlines()[first - 1 :] if line.strip())
    return next(lines, "")


def _known(table: Table) -> tuple[int, int, bool]:
    """Return how much of a list a mapping lists: ends above all, by which programs differ most.

    Of mappings that list none, one with metric units is the better one.
    """
    ends = sum(bool({whole, part} & {*table.listed}) for whole, part in ENDS)
    is_metric = table.mapping.section_unit == "mm2" and table.mapping.length_unit == "mm"
    return ends, len(table.listed) if ends else 0, is_metric


def _wanted(mappings: Sequence[WireListMapping]) -> str:
    if any(mapping.has_synonyms for mapping in mappings):
        return "needed are headings such as From Device, From Pin, To Device, To Pin"
    own = "; ".join(
        ", ".join("/".join(names) for names in mapping.columns.values()) for mapping in mappings
    )
    return f"the mapping's headings: {own}"


def _sheets(data: bytes) -> Mapping[str, str] | None:
    """Return the sheets of a workbook, which take seconds to read; None for a text."""
    return sheets_of(data) if is_spreadsheet(data) else None


def _sources(
    data: bytes, encoding: str, wanted: str, sheets: Mapping[str, str] | None
) -> Iterator[Source]:
    """Yield the text of a file, or of each sheet of a workbook, or of the one that is wanted."""
    if sheets is None:
        text, assumed = decode(data, encoding)
        yield Source(text, f"the file is no UTF-8: read as {assumed}" if assumed else "")
        return
    if wanted and wanted not in sheets:
        raise DesignError(f"no sheet {wanted!r}; the workbook has {', '.join(map(repr, sheets))}")
    for title, text in sheets.items():
        if wanted not in ("", title):
            continue
        others = tuple(
            LeftOut(
                f"sheet {other!r}", f"sheet {title!r} is read; `sheet` in a mapping chooses another"
            )
            for other in sheets
            if other != title and sheets[other].strip()
        )
        yield Source(text, f"sheet {title!r} is read", (SEPARATOR,), others, sheet=title)


def _tables(text: str, mapping: WireListMapping, separator: str) -> Iterator[Table]:
    """Yield a table, without its rows, for each line that may be the headings."""
    lines = text.splitlines(keepends=True)
    for skipped in range(min(_HEADINGS_WITHIN, len(lines))):
        found = headings_at(lines, skipped, separator)
        headings = _numbered(found.cells)
        listed = mapping.found_in(headings)
        columns = _with_synonyms(listed, found.cells) if mapping.has_synonyms else listed
        yield Table(
            mapping,
            tuple(headings),
            columns,
            listed=frozenset(listed),
            heading_rows=found.rows,
            first_line=skipped + found.lines + 1,
            separator=separator,
        )


def _numbered(headings: Sequence[str]) -> list[str]:
    """Return headings without repeats: the second "Pin" becomes "Pin#2"."""
    numbered: list[str] = []
    for heading in (each.strip() for each in headings):
        numbered.append(unique_name(heading, numbered) if heading else "")
    return numbered


def _with_synonyms(listed: dict[Field, int], headings: Sequence[str]) -> dict[Field, int]:
    """Return the columns that a mapping lists, and those that the words of others name.

    A pin or a cavity is a terminal rather than what a list calls one, which is the contact there.
    """
    usual = fields_of(headings)
    for field in (Field.FROM_TERMINAL, Field.TO_TERMINAL):
        if field in listed and field in usual and names_contact(headings[listed[field]]):
            listed = {**listed, field: usual[field]}
    taken = set(listed.values())
    return {**{field: i for field, i in usual.items() if i not in taken}, **listed}


def readable_rows(source: Source, table: Table) -> Iterator[Row]:
    """Yield the rows of a list above the first one that cannot be read."""
    with suppress(DesignError):
        yield from _rows(source.text, table)


def _rows(text: str, table: Table) -> Iterator[Row]:
    lines_before = table.first_line - 1
    body = "".join(text.splitlines(keepends=True)[lines_before:])
    reader = csv.reader(io.StringIO(body, newline=""), delimiter=table.separator, strict=True)
    line = table.first_line
    try:
        for count, cells in enumerate(reader, start=1):
            if count > _MOST_ROWS:
                raise DesignError(f"line {line}: more than {_MOST_ROWS} lines: split the list")
            if any(len(cell) > _MOST_LENGTH for cell in cells):
                raise DesignError(f"line {line}: a cell is longer than {_MOST_LENGTH} characters")
            width = len(table.headings)
            if any(cell.strip() for cell in cells[width:]):
                raise DesignError(
                    f"line {line}: {len(cells)} cells found; there are {width} headings: quote "
                    "cells that contain the separator"
                )
            if any(cell.strip() for cell in cells):
                yield Row(line, [" ".join(cell.split()) for cell in cells])
            line = lines_before + reader.line_num + 1
    except csv.Error as error:
        raise DesignError(
            f"line {line}: is no CSV: {error}; a cell with a quote is quoted, with the quote twice"
        ) from error
