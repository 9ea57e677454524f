"""Import a from-to list: a CSV file or a sheet with a wire a line, and a mapping of its columns."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice

from remodel_production.core.catalogue import Catalogue
from remodel_production.core.imports.assembly import Connection, Device, assemble
from remodel_production.core.imports.documents import DATE, FORMULA
from remodel_production.core.imports.values import (
    Account,
    Assumptions,
    Imported,
    LeftOut,
    length_m,
    names_splice,
    number,
)
from remodel_production.core.imports.wire_list_contents import (
    checked,
    is_pin_list,
    unit_of_lengths,
    unit_of_sections,
    with_wires,
    without_thousands,
)
from remodel_production.core.imports.wire_list_headings import fields_of, similar_heading
from remodel_production.core.imports.wire_list_mapping import Field, MappingDraft, WireListMapping
from remodel_production.core.imports.wire_list_table import (
    Row,
    Table,
    headings_table,
    read_table,
    readable_rows,
)
from remodel_production.core.production import (
    TWISTED,
    Cable,
    Mount,
    Order,
    Pose,
    Role,
    TerminalRef,
    sealed_kind,
)
from remodel_production.errors import DesignError
from remodel_run.whole_task import counted

# What stands in a column of seals for none.
_NONE = frozenset({"", "-", "--", "0", "no", "none", "nein", "non", "n/a", "na"})
_YES = frozenset(
    {"yes", "y", "ja", "j", "oui", "o", "si", "s\u00ed", "x", "true", "1", "tw", "twisted"}
)
_NO_GROUPS = _NONE | _YES
# What a wire has and a jumper has not, which say what a line is instead.
_OF_WIRES = (Field.COLOUR, Field.SECTION, Field.LENGTH, Field.CABLE)
_JUMPER = re.compile(
    r"\b(?:jumpers?|bridges?|(?:bus ?)?bars?|comb|links?|(?:draht|steck)?br(?:ü|ue)cken?|"
    r"kammschienen?|querverbinder|ponts?|pontets?|cavaliers?|peignes?|ponticell[oi]|puentes?)\b",
    re.IGNORECASE,
)
# What a spreadsheet shows of a formula that it cannot compute.
_ERRORS = frozenset({"#REF!", "#N/A", "#VALUE!", "#NAME?", "#DIV/0!", "#NULL!", "#NUM!"})

_DRAFT_ROWS = 5  # by which a person recognizes columns
_MOUNTS = {mount.value: mount for mount in Mount}


def import_wire_list(
    data: bytes,
    name: str,
    source: str,
    catalogue: Catalogue,
    mappings: Sequence[WireListMapping],
) -> Imported:
    """Read a list.

    Of the mappings that one is taken with which most columns of the list are found; of several the
    one that lists most of them. The other arguments are those of `DesignFormat.read`.

    Raises:
        DesignError: if no mapping fits, or a line cannot be read.
    """
    table, text = read_table(data, mappings)
    names = {**catalogue.colour_names, **(table.mapping.colours or {})}
    left_out: tuple[LeftOut, ...] = ()
    disagreements: tuple[str, ...] = ()
    unit = "lines"
    with text.blamed():
        if is_pin_list(table):
            table, left_out, disagreements = with_wires(table)
            unit = "wires"
        reader = _Reader(table, replace(catalogue, colour_names=names), left_out, unit)
        for line in filter(None, (text.assumed, *disagreements)):
            reader.assumptions.add(line)
        return reader.read(name, source, text.others)


def mapping_draft(
    data: bytes, catalogue: Catalogue, mappings: Sequence[WireListMapping]
) -> MappingDraft:
    """Return the mapping by which a list is read, or as much of one as its headings give.

    Raises:
        DesignError: if it is no text of lines with cells.
    """
    try:
        table, _ = read_table(data, mappings)
    except DesignError:
        table, source = headings_table(data)
        rows = islice(readable_rows(source, table), _DRAFT_ROWS)
        table = replace(table, rows=tuple(rows))
    reader = _Reader(table, catalogue)
    table = reader.table
    return MappingDraft(
        table.headings,
        tuple(tuple(row.cells) for row in table.rows[:_DRAFT_ROWS]),
        {field: table.headings[column] for field, column in table.columns.items()},
        reader.units,
        table.separator,
        terminal_separator=table.mapping.terminal_separator,
    )


class _Reader:
    """Reads one list."""

    def __init__(
        self,
        table: Table,
        catalogue: Catalogue,
        left_out: Sequence[LeftOut] = (),
        unit: str = "lines",
    ) -> None:
        self.table, assumed = checked(table)
        self.assumptions = Assumptions(catalogue)
        self._catalogue = catalogue
        self._count = len(table.rows) + len(left_out)
        self._unit = unit
        self._left_out = [*left_out]
        self._devices: dict[str, Device] = {}
        self._placed_at: dict[str, int] = {}
        # By component: its place, and the line that says it.
        self._mounted: dict[str, tuple[str, int]] = {}
        self._cables: dict[str, Cable] = {}
        self._seen: dict[tuple[str, TerminalRef, TerminalRef], int] = {}
        self._section_unit, of_sections = unit_of_sections(self.table)
        self._length_unit, of_lengths = unit_of_lengths(self.table, self._section_unit)
        # A group of one wire is none.
        groups = self.table.cells(Field.TWISTED)
        self._twisted = Counter(group for group in groups if group.lower() not in _NO_GROUPS)
        if words := sorted({group for group in groups if group.lower() in _YES}):
            self.assumptions.add(
                f"which wires are twisted with each other is not given by {', '.join(words)}: they "
                "are single wires"
            )
        self._lengths = self.table.cells(Field.LENGTH)
        self._describes_wires = any(any(self.table.cells(field)) for field in _OF_WIRES)
        for line in filter(None, (*assumed, of_sections, of_lengths)):
            self.assumptions.add(line)

    def read(self, name: str, source: str, sheets: tuple[LeftOut, ...]) -> Imported:
        connections = [c for row in self.table.rows if (c := self._connection(row)) is not None]
        if not connections:
            raise DesignError(
                f"none of its {self._count} {self._unit} names both ends"
                + (f"; the first: {self._left_out[0]}" if self._left_out else "")
            )
        assembly = assemble(self._devices.values(), connections)
        self._note_places()
        account = Account(
            self._unit,
            self._count,
            (*self.assumptions.lines, *assembly.assumptions),
            tuple(self._left_out),
            unused_columns=(*sheets, *self._unused_columns()),
        )
        order = Order(
            name,
            self.table.mapping.name,
            source,
            assembly.components,
            wires=assembly.wires,
            notes=account.notes,
            cables=tuple(self._cables.values()),
        )
        return Imported(order, account)

    def _note_places(self) -> None:
        """Note the devices that are on the plate since nothing says where they are."""
        placed = [
            name
            for name, device in self._devices.items()
            if device.role is Role.DEVICE
            and name not in self._mounted
            and self._catalogue.mount(name) is None
        ]
        if placed:
            self.assumptions.add(
                f"nothing says where {counted(len(placed), 'device')} "
                f"{'is' if len(placed) == 1 else 'are'} mounted: the plate taken, such as for "
                f"{placed[0]} (columns of places, or --placement)"
            )

    def _connection(self, row: Row) -> Connection | None:
        """Return the wire of a line, or None if it is left out."""
        source = f"line {row.line}"
        if row.repeats(self.table.heading_rows):
            self._left_out.append(LeftOut(source, "it repeats the headings"))
            return None
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
        if self._is_jumper(row, is_one_component=a.component == b.component):
            self._left_out.append(
                LeftOut(source, "it is a jumper or bar, a part for a person to set")
            )
            return None
        first, second = sorted((a, b), key=str)
        before = self._seen.setdefault((name, first, second), row.line)
        if before != row.line:
            self._left_out.append(LeftOut(source, f"the same wire is in line {before}"))
            return None
        self._device(a, row, Field.FROM_X, Field.FROM_Y)
        self._device(b, row, Field.TO_X, Field.TO_Y)
        self._mount(a, row, Field.FROM_PLACE)
        self._mount(b, row, Field.TO_PLACE)
        self._seal(a, row, Field.FROM_SEAL)
        self._seal(b, row, Field.TO_SEAL)
        self._force_limit(a, row, Field.FROM_FORCE_LIMIT)
        self._force_limit(b, row, Field.TO_FORCE_LIMIT)
        return Connection(
            a,
            b,
            self.assumptions.colour(self._cell(row, Field.COLOUR), source),
            self._section(row, source),
            source=source,
            name=name or self._name_of_core(row),
            length_m=self._length(row, source),
            cable=self._cable(row, source),
            core=self._cell(row, Field.CORE),
        )

    def _is_jumper(self, row: Row, *, is_one_component: bool) -> bool:
        """Return whether a line is no wire but what joins terminals beside each other.

        It says so in place of a colour or section; or it joins terminals of one component and is
        called so, or has nothing of a wire although others have.
        """
        colour, section, *others = (self._cell(row, field) for field in _OF_WIRES)
        if _JUMPER.search(f"{colour}\n{section}"):
            return True
        names = f"{self._cell(row, Field.WIRE)}\n{self._cell(row, Field.CABLE)}"
        is_bare = self._describes_wires and not any((colour, section, *others))
        return is_one_component and (is_bare or _JUMPER.search(names) is not None)

    @property
    def units(self) -> dict[str, str]:
        """The units of numbers without one."""
        places = (Field.FROM_X, Field.FROM_Y, Field.TO_X, Field.TO_Y)
        stated = next((unit for field in places if (unit := self.table.unit(field))), "")
        return {
            "section": self._section_unit,
            "length": self._length_unit,
            "position": stated or self.table.mapping.position_unit,
        }

    def _unused_columns(self) -> Iterator[LeftOut]:
        table = self.table
        used = set(table.columns.values())
        for column, heading in enumerate(table.headings[table.repeated :]):
            has_content = any(any(row.cells[column : column + 1]) for row in table.rows)
            if column in used or not (heading or has_content):
                continue
            place = f"column {heading!r}" if heading else f"column {column + 1}, without a heading"
            yield LeftOut(place, self._reason(heading))

    def _reason(self, heading: str) -> str:
        """Return why a column is not used, and what would use it."""
        if not self.table.mapping.has_synonyms:
            return "the mapping does not list its heading"
        similar = similar_heading(heading)
        field = next(iter(fields_of([heading])), None)
        if field is not None:
            return f"another column is read as {field.value}"
        return "its heading is not known" + (f"; similar: {similar}" if similar else "")

    def _cell(self, row: Row, field: Field) -> str:
        text = row.cell(self.table.columns.get(field))
        if text.startswith(DATE):
            raise DesignError(
                f"line {row.line}: {field.value}: a cell is the date {text.removeprefix(DATE)}; "
                "format the column as text, and type it again"
            )
        if text.startswith(FORMULA):
            raise DesignError(
                f"line {row.line}: {field.value}: {text.removeprefix(FORMULA)} has no value: open "
                "the workbook in a spreadsheet program and save it there, which computes it"
            )
        if text in _ERRORS:
            raise DesignError(
                f"line {row.line}: {field.value}: {text} found, the error of a formula: correct it"
            )
        return text

    def _end(self, row: Row, whole: Field, component: Field, terminal: Field) -> TerminalRef | None:
        name, clamp = self._cell(row, component), self._cell(row, terminal)
        text = self._cell(row, whole)
        if not name and clamp:
            name = text.removesuffix(f"{self.table.mapping.terminal_separator}{clamp}")
        elif not name and text:
            head, separator, tail = text.rpartition(self.table.mapping.terminal_separator)
            name, clamp = (head, tail) if separator and head else (text, clamp)
        name, clamp = name.strip(), clamp.strip()
        if not name:
            return None
        if not clamp:
            clamp = "1"
            self.assumptions.add(f"line {row.line}: no terminal of {name} is given, 1 taken")
        return TerminalRef(name, clamp)

    def _device(self, end: TerminalRef, row: Row, x: Field, y: Field) -> None:
        """Note a component, and its place if the line has one."""
        place = self._cell(row, x), self._cell(row, y)
        role = Role.JOINT if names_splice(end.component) else Role.DEVICE
        known = self._devices.setdefault(end.component, Device(end.component, role=role))
        if not any(place):
            return
        units = (self.table.unit(field) or self.table.mapping.position_unit for field in (x, y))
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

    def _mount(self, end: TerminalRef, row: Row, field: Field) -> None:
        """Note where a component is mounted, if the line says it."""
        text = self._cell(row, field).lower()
        if not text:
            return
        if text not in _MOUNTS:
            raise DesignError(
                f"line {row.line}: {field.value}: {text!r} found for {end.component}; allowed: "
                f"{', '.join(_MOUNTS)}; call the column something else if it is about other things"
            )
        before, line = self._mounted.setdefault(end.component, (text, row.line))
        if before != text:
            raise DesignError(
                f"line {row.line}: {field.value}: {end.component} is at {text}, and at {before} in "
                f"line {line}: give it one place"
            )
        known = self._devices[end.component]
        self._devices[end.component] = replace(known, mount=_MOUNTS[text])

    def _seal(self, end: TerminalRef, row: Row, field: Field) -> None:
        """Note the seal of an end, if the line has one."""
        seal = self._cell(row, field)
        if seal.lower() not in _NONE:
            device = self._devices[end.component]
            kinds = {**device.kinds, end.terminal: sealed_kind("", seal)}
            self._devices[end.component] = replace(device, kinds=kinds)

    def _force_limit(self, end: TerminalRef, row: Row, field: Field) -> None:
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

    def _section(self, row: Row, source: str) -> float:
        text = self._cell(row, Field.SECTION)
        return self.assumptions.section(text, source, self._section_unit)

    def _length(self, row: Row, source: str) -> float | None:
        stated = self._cell(row, Field.LENGTH)
        text = without_thousands(stated, self._length_unit, self._lengths)
        if text != stated:
            self.assumptions.add(f"{source}: length {stated!r} read as {text} mm")
        length = length_m(text, self._length_unit) if text else None
        if text and length is None and number(text) != 0.0:
            self.assumptions.add(f"{source}: length {text!r} not understood, none taken")
        return length

    def _name_of_core(self, row: Row) -> str:
        """Return the name of a core by its cable's; empty if either is not given."""
        cable, core = self._cell(row, Field.CABLE), self._cell(row, Field.CORE)
        return f"{cable}.{core}" if cable and core else ""

    def _cable(self, row: Row, source: str) -> str:
        name = self._cell(row, Field.CABLE)
        group = self._cell(row, Field.TWISTED)
        if name:
            self._cables.setdefault(name, Cable(name, "", None, False, source=source))
        elif self._twisted[group] > 1:
            self._cables.setdefault(group, Cable(group, TWISTED, None, False, source=source))
            return group
        return name


def _position(text: str, unit: str) -> float | None:
    """Return a coordinate [m], which may be zero or negative, unlike a length."""
    value = number(text)
    if value is None:
        return None
    scale = length_m("1", unit)
    return None if scale is None else value * scale
