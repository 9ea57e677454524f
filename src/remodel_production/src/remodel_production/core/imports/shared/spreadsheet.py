"""Read the sheets of an XLSX workbook as lines of cells, as a list of a CSV file has them.

Formulas count by the value that the program which wrote the workbook has computed. A cell that
spans others stands for all of them. Untrusted: what unpacks to more than a workbook of the longest
list is refused before it is read, as are document types, which can declare entities.
"""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from datetime import date, time
from itertools import islice, zip_longest
from typing import TYPE_CHECKING, TypeAlias

from remodel_production.errors import DesignError

if TYPE_CHECKING:
    from openpyxl.worksheet._read_only import ReadOnlyWorksheet
    from openpyxl.worksheet.worksheet import Worksheet

    _Sheet: TypeAlias = Worksheet | ReadOnlyWorksheet

SEPARATOR = "\t"
# A cell that is a date, and a formula without a value, begin with these, which no text does.
DATE, FORMULA = "\ue000", "\ue001"
_PART = "xl/workbook.xml"
_OLE = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
_ODS = b"application/vnd.oasis.opendocument.spreadsheet"
_MOST_UNPACKED = 500_000_000
_MOST_SPANNED = 50_000_000  # of a workbook that is read whole
_MOST_ROWS = 51_000
_MOST_COLUMNS = 500


def is_spreadsheet(data: bytes) -> bool:
    """Return whether the data is an XLSX workbook, by the parts of its archive."""
    if not data.startswith(b"PK\x03\x04"):
        return False
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return _PART in archive.namelist()
    except zipfile.BadZipFile:
        return False


def other_spreadsheet(data: bytes) -> str:
    """Return what kind of spreadsheet that is not read the data is; empty if it is none."""
    if data.startswith(_OLE):
        return "a workbook of Excel 97 to 2003 (.xls), or another binary Office file"
    if data.startswith(b"PK\x03\x04") and _ODS in data[:200]:
        return "an OpenDocument spreadsheet (.ods)"
    return ""


def sheets_of(data: bytes) -> dict[str, str]:
    """Return the sheets of a workbook by name, each as text: a line for each row, cells by tabs.

    Raises:
        DesignError: if the workbook is damaged or too large.
    """
    from openpyxl import load_workbook  # most imports need none, and it takes long to load

    has_spans, has_formulas = _inspected(data)
    try:
        # Only a workbook that is read whole knows its spans.
        book = load_workbook(io.BytesIO(data), read_only=not has_spans, data_only=True)
        formulas = load_workbook(io.BytesIO(data), read_only=True) if has_formulas else None
        return {
            sheet.title: _text(
                _rows_of(sheet),
                () if formulas is None else _rows_of(formulas[sheet.title]),
                _spans_of(sheet) if has_spans else {},
            )
            for sheet in book.worksheets
        }
    except (zipfile.BadZipFile, KeyError, ValueError, OSError, SyntaxError) as error:
        raise DesignError(f"is a damaged XLSX workbook: {error}") from error


def _inspected(data: bytes) -> tuple[bool, bool]:
    """Return whether a workbook has cells that span others, and formulas.

    Raises:
        DesignError: if it is too large, or has a document type.
    """
    has_spans = has_formulas = False
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        size = sum(part.file_size for part in archive.infolist())
        if size > _MOST_UNPACKED:
            raise DesignError(
                f"unpacks to {size // 1_000_000} MB; at most {_MOST_UNPACKED // 1_000_000} MB are "
                "read: split the list"
            )
        for part in archive.infolist():
            if not part.filename.endswith((".xml", ".rels")):
                continue
            with archive.open(part) as stream:
                text = stream.read()
            if b"<!DOCTYPE" in text[:1000]:
                raise DesignError(f"{part.filename} has a document type: remove <!DOCTYPE>")
            has_spans = has_spans or b"<mergeCell " in text
            has_formulas = has_formulas or b"<f>" in text or b"<f " in text
    if has_spans and size > _MOST_SPANNED:
        raise DesignError(
            f"has merged cells and unpacks to {size // 1_000_000} MB; at most "
            f"{_MOST_SPANNED // 1_000_000} MB are read with them: unmerge the cells, or split the "
            "list"
        )
    return has_spans, has_formulas


def _rows_of(sheet: _Sheet) -> Iterable[tuple[object, ...]]:
    return islice(sheet.iter_rows(values_only=True, max_col=_MOST_COLUMNS), _MOST_ROWS)


def _spans_of(sheet: Worksheet) -> dict[tuple[int, int], tuple[int, int]]:
    """Return, for each cell that another one spans, that one: row and column, both from 0."""
    return {
        (row - 1, column - 1): (span.min_row - 1, span.min_col - 1)
        for span in sheet.merged_cells.ranges
        for row in range(span.min_row, min(span.max_row, _MOST_ROWS) + 1)
        for column in range(span.min_col, min(span.max_col, _MOST_COLUMNS) + 1)
    }


def _text(
    rows: Iterable[tuple[object, ...]],
    formulas: Iterable[tuple[object, ...]],
    spans: Mapping[tuple[int, int], tuple[int, int]],
) -> str:
    lines = io.StringIO()
    writer = csv.writer(lines, delimiter=SEPARATOR, lineterminator="\n")
    spanning = set(spans.values())
    values: dict[tuple[int, int], object] = {}
    for number, (row, row_of_formulas) in enumerate(zip_longest(rows, formulas, fillvalue=())):
        texts = []
        # Rows of a sheet that does not state its size are as wide as the widest that is read.
        width = len(row) if spans else max(_width(row), min(len(row), _width(row_of_formulas)))
        for column, value in enumerate(row[:width]):
            formula = row_of_formulas[column] if column < len(row_of_formulas) else None
            if value is None and formula is not None:
                value = f"{FORMULA}{formula}"
            if (number, column) in spanning:
                values[number, column] = value
            texts.append(_cell(values.get(spans.get((number, column), (-1, -1)), value)))
        while texts and not texts[-1]:
            texts.pop()
        writer.writerow(texts)
    return lines.getvalue()


def _width(row: Sequence[object]) -> int:
    """Return how many cells a row has, up to the last one with a value."""
    return next((n for n in range(len(row), 0, -1) if row[n - 1] is not None), 0)


def _cell(value: object) -> str:
    """Return a cell on one line, so that lines are numbered as in the sheet."""
    if value is None:
        return ""
    if isinstance(value, date | time):
        return f"{DATE}{value}"
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    return " ".join(str(value).split())
