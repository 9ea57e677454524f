"""Pin lists: a line for each end of a wire, instead of one for each wire."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from remodel_production.core.imports.shared.account import LeftOut
from remodel_production.core.imports.wire_lists.mapping import PIN_LIST, Field
from remodel_production.core.imports.wire_lists.table import Row, Table

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
