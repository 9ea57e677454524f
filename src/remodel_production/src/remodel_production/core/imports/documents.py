"""Read untrusted documents: XML, YAML with lines, XLSX sheets, text of unknown encoding.

Formulas of sheets count by the value that the program which wrote the workbook has computed. A cell
that spans others stands for all of them. What unpacks to more than a workbook of the longest list
is refused before it is read, as are document types, which can declare entities.
"""

from __future__ import annotations

import codecs
import csv
import io
import zipfile
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import date, time
from itertools import islice, zip_longest
from typing import TYPE_CHECKING, TypeAlias
from xml.parsers import expat

import yaml

from remodel_production.errors import DesignError

if TYPE_CHECKING:
    from lxml import etree
    from openpyxl.worksheet._read_only import ReadOnlyWorksheet
    from openpyxl.worksheet.worksheet import Worksheet

    _Sheet: TypeAlias = Worksheet | ReadOnlyWorksheet


_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
# What Western editions of Windows write where they do not write UTF-8.
_FALLBACK = "cp1252"


def decode(data: bytes, encoding: str = "") -> tuple[str, str]:
    """Return the text, and the assumed encoding; empty if it is given, marked or UTF-8.

    Args:
        data: to decode.
        encoding: that is known; empty for: by its mark, else UTF-8, else Windows-1252.

    Raises:
        DesignError: if the data is not in the encoding, or is no text.
    """
    mark = next((name for bom, name in _MARKS.items() if data.startswith(bom)), "")
    try:
        text, assumed = data.decode(encoding or mark or "utf-8"), ""
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        if encoding or mark:
            raise DesignError(
                f"line {line}: byte {data[error.start]:#04x} is no {error.encoding}: give the "
                "file's encoding in the mapping"
            ) from error
        text, assumed = data.decode(_FALLBACK, errors="replace"), _FALLBACK
    except LookupError as error:
        raise DesignError(f"encoding {encoding}: not known; utf-8, utf-16, cp1252 are") from error
    if "\0" in text:
        line = text[: text.index("\0")].count("\n") + 1
        raise DesignError(f"line {line}: a zero byte found; a text is needed, not a binary file")
    return text, assumed


class _RootSeen(Exception):  # noqa: N818 - it ends a search, and is no error
    pass


def parse_xml(text: bytes) -> etree._Element:
    """Return the root element.

    Raises:
        DesignError: if the text is no well-formed XML or declares a document type.
    """
    _refuse_document_type(text)
    from lxml import etree  # plans of problems do without

    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, huge_tree=False, remove_comments=True
    )
    try:
        return etree.fromstring(text, parser)
    except etree.XMLSyntaxError as error:
        raise DesignError(f"is no XML: {error}") from error


def local_name(element: etree._Element) -> str:
    """Return an element's name without its namespace; empty for a processing instruction."""
    tag = element.tag
    return tag.rsplit("}", 1)[-1] if isinstance(tag, str) else ""


def line_of(element: etree._Element) -> str:
    """Return where an element stands in its file."""
    return f"line {element.sourceline}"


def _refuse_document_type(text: bytes) -> None:
    """Refuse entities before they are expanded: only a document type can declare them."""

    def refuse(name: str, *_: object) -> None:
        raise DesignError(
            f"line {parser.CurrentLineNumber}: document type {name} found; files with document "
            "types are not read, since they can declare entities without end: remove <!DOCTYPE>"
        )

    def stop(*_: object) -> None:
        raise _RootSeen

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = stop
    try:
        parser.Parse(text, True)
    except _RootSeen:
        return
    except (expat.ExpatError, LookupError, ValueError) as error:
        raise DesignError(f"is no XML: {error}") from error


# Values after all aliases are followed; a harness of 1000 connections has some ten thousand.
_MOST_VALUES = 200_000
# Composing recurses; a WireViz harness nests seven deep.
_MOST_DEPTH = 50
_MERGE = "tag:yaml.org,2002:merge"


@dataclass(frozen=True)
class Value:
    """A value of a document: a mapping, a list, or a scalar, and its line.

    Attributes:
        data: dict[str, Value], list[Value], or a scalar of YAML.
    """

    data: object
    line: int

    @property
    def where(self) -> str:
        """The place of the value, for errors."""
        return f"line {self.line}"

    def mapping(self, what: str, known: Collection[str] | None = None) -> dict[str, Value]:
        """Return the entries; an empty value has none.

        Raises:
            DesignError: if this is no mapping, or has others than the known keys (None: any).
        """
        if self.data is None:
            return {}
        if not isinstance(self.data, dict):
            raise DesignError(f"{self.where}: {what}: expected a mapping, found {self.shown}")
        for key, value in self.data.items():
            if known is not None and key not in known:
                raise DesignError(
                    f"{value.where}: {what}: key {key} is not known; allowed: {', '.join(known)}"
                )
        return self.data

    def items(self, what: str) -> list[Value]:
        """Return the items; an empty value has none.

        Raises:
            DesignError: if this is no list.
        """
        if self.data is None:
            return []
        if not isinstance(self.data, list):
            raise DesignError(f"{self.where}: {what}: expected a list, found {self.shown}")
        return self.data

    @property
    def is_scalar(self) -> bool:
        """Return whether this is neither a mapping nor a list."""
        return not isinstance(self.data, dict | list)

    @property
    def text(self) -> str:
        """The scalar as text; empty for nothing."""
        return "" if self.data is None else str(self.data)

    @property
    def shown(self) -> str:
        """The value as an error shows it."""
        if isinstance(self.data, dict):
            return "a mapping"
        return "a list" if isinstance(self.data, list) else repr(self.data)[:60]


def section_of(
    root: Mapping[str, Value], key: str, known: Collection[str] | None = None
) -> dict[str, Value]:
    """Return the entries of a mapping in another one; none if it is not there."""
    return root[key].mapping(key, known) if key in root else {}


def parse_yaml(text: str) -> Value:
    """Return the document.

    Raises:
        DesignError: if it is no YAML, has keys twice, or grows without end by its aliases.
    """
    try:
        _refuse_deep(text)
        loader = yaml.CSafeLoader(text)
        try:
            node = loader.get_single_node()
            if node is None:
                return Value(None, 1)
            _refuse_endless(node)
            return _value(node, loader)
        finally:
            loader.dispose()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        raise DesignError(f"{where}is no YAML: {error.problem}") from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise DesignError(f"is no YAML: {' '.join(str(error).split())[:200]}") from error


def _refuse_deep(text: str) -> None:
    """Refuse a document that nests too deeply or is too long, before it is composed."""
    depth = 0
    for count, event in enumerate(yaml.parse(text, Loader=yaml.CSafeLoader)):
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        if depth > _MOST_DEPTH or count > 2 * _MOST_VALUES:
            line = event.start_mark.line + 1
            found = f"{depth} levels" if depth > _MOST_DEPTH else f"{count} values"
            raise DesignError(
                f"line {line}: {found} found; at most {_MOST_DEPTH} levels and {_MOST_VALUES} "
                "values are read: split the file"
            )


def _children(node: yaml.Node) -> Iterator[yaml.Node]:
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            yield key
            yield value
    elif isinstance(node, yaml.SequenceNode):
        yield from node.value


def _refuse_endless(root: yaml.Node) -> None:
    """Refuse a document that contains itself, or whose aliases multiply to too many values."""
    sizes: dict[int, int] = {}
    open_nodes: set[int] = set()
    stack: list[tuple[yaml.Node, bool]] = [(root, False)]
    while stack:
        node, is_done = stack.pop()
        if is_done:
            open_nodes.discard(id(node))
            sizes[id(node)] = 1 + sum(sizes[id(child)] for child in _children(node))
            if sizes[id(node)] > _MOST_VALUES:
                raise DesignError(
                    f"line {node.start_mark.line + 1}: more than {_MOST_VALUES} values, after its "
                    "aliases (*name) are followed: split the file, or remove aliases of aliases"
                )
        elif id(node) in open_nodes:
            raise DesignError(
                f"line {node.start_mark.line + 1}: the value contains itself by an alias (*name)"
            )
        elif id(node) not in sizes:
            open_nodes.add(id(node))
            stack.append((node, True))
            stack += [(child, False) for child in _children(node)]


def _value(node: yaml.Node, loader: yaml.CSafeLoader) -> Value:
    line = node.start_mark.line + 1
    if isinstance(node, yaml.MappingNode):
        return Value(_mapping(node, loader), line)
    if isinstance(node, yaml.SequenceNode):
        return Value([_value(item, loader) for item in node.value], line)
    return Value(loader.construct_object(node), line)


def _mapping(node: yaml.MappingNode, loader: yaml.CSafeLoader) -> dict[str, Value]:
    """Return the entries; the mapping's own replace those of merged mappings (<<)."""
    own: dict[str, Value] = {}
    merged: dict[str, Value] = {}
    for key_node, value_node in node.value:
        if key_node.tag == _MERGE:
            is_list = isinstance(value_node, yaml.SequenceNode)
            sources = value_node.value if is_list else [value_node]
            for source in sources:
                if not isinstance(source, yaml.MappingNode):
                    raise DesignError(
                        f"line {source.start_mark.line + 1}: << takes a mapping, or a list of them"
                    )
                merged = {**_mapping(source, loader), **merged}
            continue
        key, line = _value(key_node, loader), key_node.start_mark.line + 1
        if not key.is_scalar:
            raise DesignError(f"line {line}: a key must be a name, found {key.shown}")
        if key.text in own:
            raise DesignError(
                f"line {line}: key {key.text} is given before, at {own[key.text].where}: keep one"
            )
        own[key.text] = _value(value_node, loader)
    return {**merged, **own}


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
