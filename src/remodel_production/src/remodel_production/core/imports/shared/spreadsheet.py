"""Read the sheets of an XLSX workbook as lines of cells, as a list of a CSV file has them.

Formulas count by the value that the program which wrote the workbook has computed. Untrusted: what
unpacks to more than a workbook of the longest list is refused before it is read, as are document
types, which can declare entities.
"""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Iterable
from datetime import date, time
from itertools import islice

from remodel_production.errors import DesignError

SEPARATOR = "\t"
_PART = "xl/workbook.xml"
_MOST_UNPACKED = 500_000_000
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


def sheets_of(data: bytes) -> dict[str, str]:
    """Return the sheets of a workbook by name, each as text: a line for each row, cells by tabs.

    Raises:
        DesignError: if the workbook is damaged, too large, or a cell is a date where a sign such as
            "1-2" was typed.
    """
    from openpyxl import load_workbook  # most imports need none, and it takes long to load

    _refuse_dangerous(data)
    try:
        book = load_workbook(io.BytesIO(data), read_only=True, data_only=True)
        return {
            sheet.title: _text(
                sheet.title,
                islice(sheet.iter_rows(values_only=True, max_col=_MOST_COLUMNS), _MOST_ROWS),
            )
            for sheet in book.worksheets
        }
    except (zipfile.BadZipFile, KeyError, ValueError, OSError, SyntaxError) as error:
        raise DesignError(f"is a damaged XLSX workbook: {error}") from error


def _refuse_dangerous(data: bytes) -> None:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        size = sum(part.file_size for part in archive.infolist())
        if size > _MOST_UNPACKED:
            raise DesignError(
                f"unpacks to {size // 1_000_000} MB; at most {_MOST_UNPACKED // 1_000_000} MB are "
                "read: split the list"
            )
        for part in archive.infolist():
            if part.filename.endswith((".xml", ".rels")):
                with archive.open(part) as stream:
                    if b"<!DOCTYPE" in stream.read(1000):
                        raise DesignError(f"{part.filename} has a document type: remove <!DOCTYPE>")


def _text(title: str, rows: Iterable[tuple[object, ...]]) -> str:
    lines = io.StringIO()
    writer = csv.writer(lines, delimiter=SEPARATOR, lineterminator="\n")
    for number, row in enumerate(rows, start=1):
        writer.writerow([_cell(value, f"sheet {title}, line {number}") for value in row])
    return lines.getvalue()


def _cell(value: object, where: str) -> str:
    """Return a cell on one line, so that lines are numbered as in the sheet."""
    if value is None:
        return ""
    if isinstance(value, date | time):
        raise DesignError(
            f"{where}: a cell is the date {value}; format the column as text, and type it again"
        )
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    return " ".join(str(value).split())
