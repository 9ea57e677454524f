"""What the contents of a list's columns say that headings leave open; lists of pins.

Contents count only for mappings that find columns by usual words: a mapping of one's own
means what it says.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from remodel_production.core.imports.values import LeftOut, length_m, number
from remodel_production.core.imports.wire_list_mapping import PIN_LIST, Field
from remodel_production.core.imports.wire_list_table import Row, Table

_GAUGES = frozenset(map(str, range(41)))
# Gauges that are no sections of IEC 60228 [mm^2].
_ONLY_GAUGES = frozenset(map(str, range(12, 31))) - {"16", "25"}
_USUAL_LENGTH_M = (0.02, 50.0)  # shortest and longest wire of most cabinets and harnesses
_ENDS = (
    (Field.FROM, Field.FROM_COMPONENT, Field.FROM_TERMINAL),
    (Field.TO, Field.TO_COMPONENT, Field.TO_TERMINAL),
)
# A component's tag ends in a digit ("J1", "-X12"); what follows it is short ("4", "A1", "1/L1").
_TAG_AND_TERMINAL = r"(.*\d){}([A-Z]{{0,3}}\d{{0,3}}[+-]?)"
_THOUSANDS = re.compile(r"(\d{1,3})[.,](\d{3})")


def checked(table: Table) -> tuple[Table, list[str]]:
    """Return a table whose columns agree with their contents, and a line for each thing assumed."""
    if not table.mapping.has_synonyms:
        return table, []
    table, lines = _with_wire_names(_without_contacts(_with_whole_ends(table))), []
    separator = _separator_of_terminals(table)
    if separator:
        table = replace(table, mapping=replace(table.mapping, terminal_separator=separator))
        example = next(text for text in _whole_ends(table) if text)
        component, _, terminal = example.rpartition(separator)
        lines.append(
            f"no end has a {':'!r}: what follows {separator!r} is taken as its terminal, such as "
            f"{terminal} of {component} in {example!r}"
        )
    return table, lines


def _with_whole_ends(table: Table) -> Table:
    """Return a table whose components without a column of terminals may have them in the cell."""
    columns = dict(table.columns)
    for whole, component, terminal in _ENDS:
        if component in columns and not {whole, terminal} & columns.keys():
            columns[whole] = columns.pop(component)
    return replace(table, columns=columns)


def _without_contacts(table: Table) -> Table:
    """Return a table without columns of terminals that its columns of whole ends contradict."""
    columns = dict(table.columns)
    sign = table.mapping.terminal_separator
    for whole, component, terminal in _ENDS:
        if not {whole, terminal} <= columns.keys() or component in columns:
            continue
        pairs = zip(table.cells(whole), table.cells(terminal), strict=True)
        stated = [(text.rpartition(sign)[2], own) for text, own in pairs if own and sign in text]
        if sum(tail != own for tail, own in stated) * 2 > len(stated):
            del columns[terminal]
    return replace(table, columns=columns)


def _with_wire_names(table: Table) -> Table:
    """Return a table in which cables of one core each are wires, if no column names those.

    So are cores without cables.
    """
    columns = dict(table.columns)
    if Field.CORE in columns and not {Field.WIRE, Field.CABLE} & columns.keys():
        columns[Field.WIRE] = columns.pop(Field.CORE)
    names = [name for name in table.cells(Field.CABLE) if name]
    is_open = Field.CABLE in columns and not {Field.WIRE, Field.CORE} & columns.keys()
    if is_open and len(names) == len(set(names)):
        columns[Field.WIRE] = columns.pop(Field.CABLE)
    return replace(table, columns=columns)


def _whole_ends(table: Table) -> list[str]:
    """Return the cells that hold a component and its terminal."""
    fields = [
        whole
        for whole, component, terminal in _ENDS
        if whole in table.columns and not {component, terminal} & table.columns.keys()
    ]
    return [text for field in fields for text in table.cells(field) if text]


def _separator_of_terminals(table: Table) -> str:
    """Return what stands between component and terminal, if not what usually does; else empty.

    All ends must have it, and it must gather ends of the same component.
    """
    ends = _whole_ends(table)
    if not ends or any(table.mapping.terminal_separator in text for text in ends):
        return ""
    for sign in ("/", ".", "-", " "):
        pattern = re.compile(_TAG_AND_TERMINAL.format(re.escape(sign)))
        matches = [pattern.fullmatch(text) for text in ends]
        tags = {match[1] for match in matches if match and match[2]}
        if all(m and m[2] for m in matches) and len(tags) < len(set(ends)):
            return sign
    return ""


def unit_of_sections(table: Table) -> tuple[str, str]:
    """Return the unit of sections without one, and a line about it if it is assumed."""
    stated = table.unit(Field.SECTION)
    if stated or Field.SECTION not in table.columns or not table.mapping.has_synonyms:
        return stated or table.mapping.section_unit, ""
    bare = [text for text in table.cells(Field.SECTION) if number(text) is not None]
    unit = table.mapping.section_unit
    heading = table.headings[table.columns[Field.SECTION]]
    are_gauges = bool(_ONLY_GAUGES & set(bare)) or "gauge" in heading.lower()
    if unit == "mm2" and set(bare) <= _GAUGES and are_gauges:
        unit = "awg"
    elif unit == "awg" and not set(bare) <= _GAUGES:
        unit = "mm2"
    return unit, f"column {heading!r} states no unit: {unit} taken" if bare else ""


def unit_of_lengths(table: Table, section_unit: str) -> tuple[str, str]:
    """Return the unit of lengths without one, and a line about it if it is assumed.

    Args:
        table: of the list.
        section_unit: beside which lengths may be in inches: gauges.
    """
    stated = table.unit(Field.LENGTH)
    if stated or Field.LENGTH not in table.columns or not table.mapping.has_synonyms:
        return stated or table.mapping.length_unit, ""
    bare = sorted(v for text in table.cells(Field.LENGTH) if (v := number(text)))
    if not bare:
        return table.mapping.length_unit, ""
    least, most = _USUAL_LENGTH_M
    imperial = ("in",) if section_unit == "awg" else ()
    units = (table.mapping.length_unit, "mm", *imperial, "m")
    middle_m = {unit: length_m(f"{bare[len(bare) // 2]:f}", unit) or 0.0 for unit in units}
    unit = next((unit for unit in units if least <= middle_m[unit] <= most), units[0])
    heading = table.headings[table.columns[Field.LENGTH]]
    return unit, f"column {heading!r} states no unit: {unit} taken"


def without_thousands(text: str, unit: str, others: Sequence[str]) -> str:
    """Return a length without the sign that groups thousands: "1.250" mm beside "830" is 1250."""
    match = _THOUSANDS.fullmatch(text)
    has_whole = any(other.isdecimal() and len(other) > 1 for other in others)
    return f"{match[1]}{match[2]}" if match and unit == "mm" and has_whole else text


# What both lines of a wire may state.
_OF_WIRE = (Field.COLOUR, Field.SECTION, Field.LENGTH, Field.CABLE, Field.CORE, Field.TWISTED)
_SHOWN = 6  # lines


def is_pin_list(table: Table) -> bool:
    """Return whether a table has a line for each end of a wire."""
    return not table.names_both_ends and table.columns.keys() >= {*PIN_LIST}


def with_wires(table: Table) -> tuple[Table, tuple[LeftOut, ...], tuple[str, ...]]:
    """Return a pin list as a table with a line for each wire.

    Returns:
        the table, whose headings are repeated for the second ends; what does not have two ends; and
        a line for each wire whose lines disagree.
    """
    width, columns = len(table.headings), dict(table.columns)
    component, terminal = columns.pop(Field.COMPONENT), columns.pop(Field.TERMINAL)
    ends = {
        Field.FROM_COMPONENT: component,
        Field.FROM_TERMINAL: terminal,
        Field.TO_COMPONENT: width + component,
        Field.TO_TERMINAL: width + terminal,
    }
    place = columns.pop(Field.PLACE, None)
    if place is not None:
        ends |= {Field.FROM_PLACE: place, Field.TO_PLACE: width + place}
    of_wire: dict[str, list[Row]] = {}
    left_out: list[LeftOut] = []
    for row in table.rows:
        name = row.cell(columns[Field.WIRE])
        if row.repeats(table.heading_rows):
            left_out.append(LeftOut(f"line {row.line}", "it repeats the headings"))
        elif not name or not row.cell(component):
            missing = "wire" if not name else "component"
            left_out.append(LeftOut(f"line {row.line}", f"it names no {missing}"))
        else:
            of_wire.setdefault(name, []).append(row)
    pairs: list[Row] = []
    disagreements: list[str] = []
    for name, lines in of_wire.items():
        if len(lines) == 2:
            pairs.append(_joined(table, *lines))
            disagreements += _disagreements(table, name, *lines)
        else:
            left_out.append(LeftOut(f"line {lines[0].line}", _not_two(name, lines)))
    wires = replace(
        table,
        headings=table.headings * 2,
        repeated=width,
        columns={**columns, **ends},
        rows=tuple(sorted(pairs, key=lambda row: row.line)),
    )
    return wires, tuple(left_out), tuple(disagreements)


def _joined(table: Table, first: Row, second: Row) -> Row:
    width = len(table.headings)
    one, other = (row.cells + [""] * (width - len(row.cells)) for row in (first, second))
    for column in (table.columns[field] for field in _OF_WIRE if field in table.columns):
        one[column] = one[column] or other[column]
    return Row(first.line, one + other)


def _disagreements(table: Table, name: str, first: Row, second: Row) -> Iterator[str]:
    for field in _OF_WIRE:
        one, other = (row.cell(table.columns.get(field)) for row in (first, second))
        if one and other and one != other:
            yield (
                f"line {first.line}, wire {name}: {field.value} is {one!r}, and {other!r} in line "
                f"{second.line}: the first taken"
            )


def _not_two(name: str, lines: list[Row]) -> str:
    if len(lines) == 1:
        return f"wire {name} has one end; two are needed"
    shown = ", ".join(str(row.line) for row in lines[:_SHOWN]) + (
        ", ..." if len(lines) > _SHOWN else ""
    )
    return (
        f"wire {name} has {len(lines)} ends, in lines {shown}; two are needed: name each wire "
        "between two of them"
    )
