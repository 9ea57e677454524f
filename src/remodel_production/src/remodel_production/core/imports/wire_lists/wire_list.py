"""Import a from-to list: a CSV file or a sheet with a wire a line, and a mapping of its columns."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from remodel_production.core.catalogue import Catalogue
from remodel_production.core.imports.shared.account import Account, Imported, LeftOut
from remodel_production.core.imports.shared.assembly import (
    Connection,
    Device,
    assemble,
    unique_name,
)
from remodel_production.core.imports.shared.assumptions import Assumptions
from remodel_production.core.imports.shared.spreadsheet import (
    SEPARATOR,
    is_spreadsheet,
    sheets_of,
)
from remodel_production.core.imports.shared.text_encoding import decode
from remodel_production.core.imports.shared.units import length_m, number
from remodel_production.core.imports.wire_lists.headings import (
    fields_of,
    similar_heading,
    unit_in,
)
from remodel_production.core.imports.wire_lists.mapping import (
    ENDS,
    Field,
    WireListMapping,
    mapping_text,
)
from remodel_production.core.production import Cable, Order, Pose, TerminalRef
from remodel_production.errors import DesignError

_SEPARATORS = (";", "\t", ",", "|")
# Reports begin with titles; below that many lines, no headings are searched.
_HEADINGS_WITHIN = 30
_MOST_ROWS = 50_000
_MOST_LENGTH = 50_000  # characters of a cell
_GAUGES = frozenset(map(str, range(41)))
# Gauges that are no sections of IEC 60228 [mm^2].
_ONLY_GAUGES = frozenset(map(str, range(12, 31))) - {"16", "25"}
_USUAL_LENGTH_M = (0.02, 50.0)  # shortest and longest wire of most cabinets and harnesses


@dataclass(frozen=True)
class _Row:
    line: int
    cells: list[str]


@dataclass(frozen=True)
class _Table:
    """The rows under the headings.

    Attributes:
        headings: of which the second "Pin" is "Pin#2".
        columns: number of each field's column.
        listed: how many of them the mapping lists.
    """

    mapping: WireListMapping
    headings: tuple[str, ...]
    columns: dict[Field, int]
    listed: int
    rows: tuple[_Row, ...]
    separator: str

    def cells(self, field: Field) -> list[str]:
        """Return the contents of a field's column."""
        column = self.columns.get(field)
        if column is None:
            return []
        return [row.cells[column] for row in self.rows if column < len(row.cells)]

    def unit(self, field: Field) -> str:
        """Return the unit that the heading of a field's column states; empty if none."""
        column = self.columns.get(field)
        return "" if column is None else unit_in(self.headings[column], field)


@dataclass(frozen=True)
class _Source:
    """The text of a list.

    Attributes:
        assumed: of the file; empty if nothing was.
        separators: of its cells; empty if they are to be found.
        others: sheets beside it.
    """

    text: str
    assumed: str
    separators: tuple[str, ...] = ()
    others: tuple[LeftOut, ...] = ()


def import_wire_list(
    data: bytes,
    name: str,
    source: str,
    catalogue: Catalogue,
    mappings: Sequence[WireListMapping],
) -> Imported:
    """Read a list.

    Args:
        data: content of the file.
        name: of the order to make.
        source: name of the file, for the record.
        catalogue: of what the list leaves unsaid.
        mappings: of which the one is taken with which most columns of the list are found; of
            several the one that lists most of them.

    Raises:
        DesignError: if no mapping fits, or a line cannot be read.
    """
    table, text = _table(data, mappings)
    names = {**catalogue.colour_names, **(table.mapping.colours or {})}
    reader = _Reader(table, replace(catalogue, colour_names=names))
    if text.assumed:
        reader.assumptions.add(text.assumed)
    return reader.read(name, source, text.others)


def fits(data: bytes, mappings: Sequence[WireListMapping]) -> bool:
    """Return whether the data is a list that one of the mappings fits."""
    try:
        _table(data, mappings)
    except DesignError:
        return False
    return True


def similar_headings(line: str) -> str:
    """Return which headings of a line may be misspelt, and for what; empty if none."""
    separator = max(_SEPARATORS, key=line.count)
    similar = {cell.strip(): similar_heading(cell) for cell in line.split(separator)}
    return ", ".join(f"{cell!r} to {near!r}" for cell, near in similar.items() if near)


def mapping_draft(data: bytes, catalogue: Catalogue, mappings: Sequence[WireListMapping]) -> str:
    """Return the mapping by which a list is read, or as much of one as its headings give.

    Raises:
        DesignError: if it is no text of lines with cells.
    """
    try:
        table, _ = _table(data, mappings)
    except DesignError:
        table = _unread_table(data)
    reader = _Reader(table, catalogue)
    used = set(table.columns.values())
    return mapping_text(
        {field: table.headings[column] for field, column in table.columns.items()},
        reader.units,
        table.separator,
        [heading for i, heading in enumerate(table.headings) if heading and i not in used],
    )


def _unread_table(data: bytes) -> _Table:
    """Return the list of a file in which no headings of both ends are found."""
    text = next(_sources(data, "")).text
    lines = text.splitlines(keepends=True)[:_HEADINGS_WITHIN]
    cells, number_of_line, separator = max(
        ((line.count(sign), -i, sign) for i, line in enumerate(lines) for sign in _SEPARATORS),
        default=(0, 0, ""),
    )
    if not cells:
        raise DesignError("no line of it has cells: a CSV file with a line of headings is needed")
    plain = next(csv.reader([lines[-number_of_line]], delimiter=separator))
    mapping = WireListMapping("", {}, has_synonyms=True)
    return _Table(
        mapping, tuple(_numbered(plain)), fields_of(plain), listed=0, rows=(), separator=separator
    )


def _table(data: bytes, mappings: Sequence[WireListMapping]) -> tuple[_Table, _Source]:
    """Return the list by the mapping that fits best, and the text that it is in."""
    best: tuple[tuple[int, int], _Table, _Source] | None = None
    headings = ""
    for mapping in mappings:
        for source in _sources(data, mapping.encoding):
            lines = (line for line in source.text.splitlines() if line.strip())
            headings = headings or next(lines, "")
            own = (mapping.separator,) if mapping.separator else _SEPARATORS
            for separator in source.separators or own:
                table = _table_of(source.text, mapping, separator)
                if table is None:
                    continue
                fit = len(table.columns), table.listed
                if best is None or fit > best[0]:
                    best = fit, table, source
    if best is None:
        similar = similar_headings(headings)
        wanted = "; ".join(
            f"{mapping.name}: "
            + ", ".join("/".join(names) for names in mapping.columns.values()).lower()
            for mapping in mappings
        )
        raise DesignError(
            f"no line of the first {_HEADINGS_WITHIN} has the headings of a wire list; found "
            f"{headings[:120]!r}; known headings: {wanted}"
            + (f"; similar: {similar}" if similar else "")
            + "; give the columns with --mapping, which --print-mapping drafts"
        )
    return best[1], best[2]


def _sources(data: bytes, encoding: str) -> Iterator[_Source]:
    """Yield the text of a file, or of each sheet of a workbook."""
    if not is_spreadsheet(data):
        text, assumed = decode(data, encoding)
        yield _Source(text, f"the file is no UTF-8: read as {assumed}" if assumed else "")
        return
    sheets = sheets_of(data)
    for title, text in sheets.items():
        others = tuple(
            LeftOut(
                f"sheet {other!r}", f"sheet {title!r} is read: give the others files of their own"
            )
            for other in sheets
            if other != title and sheets[other].strip()
        )
        yield _Source(text, f"sheet {title!r} is read", (SEPARATOR,), others)


def _table_of(text: str, mapping: WireListMapping, separator: str) -> _Table | None:
    """Return the rows under the first line that has the mapping's headings."""
    lines = text.splitlines(keepends=True)
    for skipped, line in enumerate(lines[:_HEADINGS_WITHIN]):
        plain = next(csv.reader([line], delimiter=separator), [])
        headings = _numbered(plain)
        listed = mapping.found_in(headings)
        columns = _with_synonyms(listed, plain) if mapping.has_synonyms else listed
        if all(whole in columns or component in columns for whole, component in ENDS):
            body = "".join(lines[skipped + 1 :])
            rows = tuple(_rows(body, separator, skipped + 1))
            return _Table(
                mapping,
                tuple(headings),
                columns,
                listed=len(listed),
                rows=rows,
                separator=separator,
            )
    return None


def _numbered(headings: Sequence[str]) -> list[str]:
    """Return headings without repeats: the second "Pin" becomes "Pin#2"."""
    numbered: list[str] = []
    for heading in (each.strip() for each in headings):
        numbered.append(unique_name(heading, numbered) if heading else "")
    return numbered


def _with_synonyms(listed: dict[Field, int], headings: Sequence[str]) -> dict[Field, int]:
    """Return the columns that a mapping lists, and those that the words of others name."""
    taken = set(listed.values())
    usual = fields_of(headings)
    return {**{field: i for field, i in usual.items() if i not in taken}, **listed}


def _rows(text: str, separator: str, lines_before: int) -> Iterator[_Row]:
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
    line = lines_before + 1
    try:
        for count, cells in enumerate(reader, start=1):
            if count > _MOST_ROWS:
                raise DesignError(f"line {line}: more than {_MOST_ROWS} lines: split the list")
            if any(len(cell) > _MOST_LENGTH for cell in cells):
                raise DesignError(f"line {line}: a cell is longer than {_MOST_LENGTH} characters")
            if any(cell.strip() for cell in cells):
                yield _Row(line, [" ".join(cell.split()) for cell in cells])
            line = lines_before + reader.line_num + 1
    except csv.Error as error:
        raise DesignError(
            f"line {line}: is no CSV: {error}; a cell with a quote is quoted, with the quote twice"
        ) from error


class _Reader:
    """Reads one list."""

    def __init__(self, table: _Table, catalogue: Catalogue) -> None:
        self._table = table
        self.assumptions = Assumptions(catalogue)
        self._left_out: list[LeftOut] = []
        self._devices: dict[str, Device] = {}
        self._placed_at: dict[str, int] = {}
        self._cables: dict[str, Cable] = {}
        self._seen: dict[tuple[str, TerminalRef, TerminalRef], int] = {}
        self._section_unit = self._unit_of_sections()
        self._length_unit = self._unit_of_lengths()

    def read(self, name: str, source: str, sheets: tuple[LeftOut, ...]) -> Imported:
        connections = [c for row in self._table.rows if (c := self._connection(row)) is not None]
        if not connections:
            raise DesignError(
                f"none of its {len(self._table.rows)} lines names both ends of a wire"
                + (f"; the first: {self._left_out[0]}" if self._left_out else "")
            )
        assembly = assemble(self._devices.values(), connections)
        account = Account(
            "lines",
            len(self._table.rows),
            (*self.assumptions.lines, *assembly.assumptions),
            tuple(self._left_out),
            unused_columns=(*sheets, *self._unused_columns()),
        )
        order = Order(
            name,
            self._table.mapping.name,
            source,
            assembly.components,
            wires=assembly.wires,
            notes=account.notes,
            cables=tuple(self._cables.values()),
        )
        return Imported(order, account)

    def _connection(self, row: _Row) -> Connection | None:
        """Return the wire of a line, or None if it is left out."""
        source = f"line {row.line}"
        width = len(self._table.headings)
        if len(row.cells) > width and any(row.cells[width:]):
            raise DesignError(
                f"{source}: {len(row.cells)} cells found; there are {width} headings: quote cells "
                "that contain the separator"
            )
        a = self._end(row, Field.FROM, Field.FROM_COMPONENT, Field.FROM_TERMINAL)
        b = self._end(row, Field.TO, Field.TO_COMPONENT, Field.TO_TERMINAL)
        name = self._cell(row, Field.WIRE)
        if a is None or b is None:
            end = "first" if a is None else "second"
            self._left_out.append(LeftOut(source, f"its {end} end is not given"))
            return None
        if a == b:
            self._left_out.append(LeftOut(source, f"both its ends are at {a}"))
            return None
        first, second = sorted((a, b), key=str)
        before = self._seen.setdefault((name, first, second), row.line)
        if before != row.line:
            self._left_out.append(LeftOut(source, f"the same wire is in line {before}"))
            return None
        self._device(a, row, Field.FROM_X, Field.FROM_Y)
        self._device(b, row, Field.TO_X, Field.TO_Y)
        self._force_limit(a, row, Field.FROM_FORCE_LIMIT)
        self._force_limit(b, row, Field.TO_FORCE_LIMIT)
        return Connection(
            a,
            b,
            self.assumptions.colour(self._cell(row, Field.COLOUR), source),
            self._section(row, source),
            source=source,
            name=name,
            length_m=self._length(row, source),
            cable=self._cable(row, source),
            core=self._cell(row, Field.CORE),
        )

    @property
    def units(self) -> dict[str, str]:
        """The units of numbers without one."""
        places = (Field.FROM_X, Field.FROM_Y, Field.TO_X, Field.TO_Y)
        stated = next((unit for field in places if (unit := self._table.unit(field))), "")
        return {
            "section": self._section_unit,
            "length": self._length_unit,
            "position": stated or self._table.mapping.position_unit,
        }

    def _unused_columns(self) -> Iterator[LeftOut]:
        table = self._table
        used = set(table.columns.values())
        for column, heading in enumerate(table.headings):
            has_content = any(any(row.cells[column : column + 1]) for row in table.rows)
            if column in used or not (heading or has_content):
                continue
            place = f"column {heading!r}" if heading else f"column {column + 1}, without a heading"
            yield LeftOut(place, self._reason(heading))

    def _reason(self, heading: str) -> str:
        """Return why a column is not used, and what would use it."""
        if not self._table.mapping.has_synonyms:
            return "the mapping does not list its heading"
        similar = similar_heading(heading)
        field = next(iter(fields_of([heading])), None)
        if field is not None:
            return f"another column is read as {field.value}"
        return "its heading is not known" + (f"; similar: {similar}" if similar else "")

    def _unit_of_sections(self) -> str:
        """Return the unit of sections without one."""
        table = self._table
        stated = table.unit(Field.SECTION)
        if stated or Field.SECTION not in table.columns or not table.mapping.has_synonyms:
            return stated or table.mapping.section_unit
        bare = [text for text in table.cells(Field.SECTION) if number(text) is not None]
        unit = table.mapping.section_unit
        heading = table.headings[table.columns[Field.SECTION]]
        are_gauges = bool(_ONLY_GAUGES & set(bare)) or "gauge" in heading.lower()
        if unit == "mm2" and set(bare) <= _GAUGES and are_gauges:
            unit = "awg"
        elif unit == "awg" and not set(bare) <= _GAUGES:
            unit = "mm2"
        if bare:
            self.assumptions.add(f"column {heading!r} states no unit: {unit} taken")
        return unit

    def _unit_of_lengths(self) -> str:
        """Return the unit of lengths without one."""
        table = self._table
        stated = table.unit(Field.LENGTH)
        if stated or Field.LENGTH not in table.columns or not table.mapping.has_synonyms:
            return stated or table.mapping.length_unit
        bare = sorted(v for text in table.cells(Field.LENGTH) if (v := number(text)))
        if not bare:
            return table.mapping.length_unit
        least, most = _USUAL_LENGTH_M
        units = (table.mapping.length_unit, "mm", "m")
        middle_m = {unit: length_m(f"{bare[len(bare) // 2]:f}", unit) or 0.0 for unit in units}
        unit = next((unit for unit in units if least <= middle_m[unit] <= most), units[0])
        heading = table.headings[table.columns[Field.LENGTH]]
        self.assumptions.add(f"column {heading!r} states no unit: {unit} taken")
        return unit

    def _cell(self, row: _Row, field: Field) -> str:
        column = self._table.columns.get(field)
        return row.cells[column] if column is not None and column < len(row.cells) else ""

    def _end(
        self, row: _Row, whole: Field, component: Field, terminal: Field
    ) -> TerminalRef | None:
        name, clamp = self._cell(row, component), self._cell(row, terminal)
        text = self._cell(row, whole)
        if not name and clamp:
            name = text.removesuffix(f"{self._table.mapping.terminal_separator}{clamp}")
        elif not name and text:
            head, separator, tail = text.rpartition(self._table.mapping.terminal_separator)
            name, clamp = (head, tail) if separator and head else (text, clamp)
        name, clamp = name.strip(), clamp.strip()
        if not name:
            return None
        if not clamp:
            clamp = "1"
            self.assumptions.add(f"line {row.line}: no terminal of {name} is given, 1 taken")
        return TerminalRef(name, clamp)

    def _device(self, end: TerminalRef, row: _Row, x: Field, y: Field) -> None:
        """Note a component, and its place if the line has one."""
        place = self._cell(row, x), self._cell(row, y)
        known = self._devices.setdefault(end.component, Device(end.component))
        if not any(place):
            return
        units = (self._table.unit(field) or self._table.mapping.position_unit for field in (x, y))
        x_m, y_m = map(_position, place, units)
        if x_m is None or y_m is None:
            raise DesignError(
                f"line {row.line}: place of {end.component}: {place} found; two lengths are needed"
            )
        pose = Pose((x_m, y_m, 0.0))
        if known.pose is not None and known.pose != pose:
            raise DesignError(
                f"line {row.line}: {end.component} is at {place}, and elsewhere in line "
                f"{self._placed_at[end.component]}: give it one place"
            )
        self._devices[end.component] = replace(known, pose=pose)
        self._placed_at.setdefault(end.component, row.line)

    def _force_limit(self, end: TerminalRef, row: _Row, field: Field) -> None:
        """Note with which force an end may be pushed in, if the line says it."""
        text = self._cell(row, field)
        if not text:
            return
        limit_n = number(text)
        if limit_n is None or limit_n <= 0:
            raise DesignError(
                f"line {row.line}: force limit of {end}: {text!r} found; a number of newtons above "
                "0 is needed"
            )
        known = self._devices[end.component]
        before = known.force_limits_n.get(end.terminal, limit_n)
        if before != limit_n:
            raise DesignError(
                f"line {row.line}: force limit of {end}: {limit_n:g} N found, and {before:g} N in "
                "another line: give it one"
            )
        limits = {**known.force_limits_n, end.terminal: limit_n}
        self._devices[end.component] = replace(known, force_limits_n=limits)

    def _section(self, row: _Row, source: str) -> float:
        text = self._cell(row, Field.SECTION)
        return self.assumptions.section(text, source, self._section_unit)

    def _length(self, row: _Row, source: str) -> float | None:
        text = self._cell(row, Field.LENGTH)
        length = length_m(text, self._length_unit) if text else None
        if text and length is None and number(text) != 0.0:
            self.assumptions.add(f"{source}: length {text!r} not understood, none taken")
        return length

    def _cable(self, row: _Row, source: str) -> str:
        name = self._cell(row, Field.CABLE)
        if name:
            self._cables.setdefault(name, Cable(name, "", None, False, source=source))
        return name


def _position(text: str, unit: str) -> float | None:
    """Return a coordinate [m], which may be zero or negative, unlike a length."""
    value = number(text)
    if value is None:
        return None
    scale = length_m("1", unit)
    return None if scale is None else value * scale
