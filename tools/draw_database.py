#!/usr/bin/env python3
"""Draw the production database's models into docs/production-database.{md,svg}.

Run it with the workspace sourced. Graphviz draws the picture, which carries the digest of what it
was drawn from, since its bytes depend on the fonts of the machine.
"""

import hashlib
import subprocess
from html import escape
from itertools import groupby
from pathlib import Path

from sqlalchemy import Column, Table

from remodel_production.edge.database.production_models import Base

DOCS = Path(__file__).parents[1] / "docs"
PAGE, PICTURE = DOCS / "production-database.md", DOCS / "production-database.svg"
BEGIN, END = "<!-- drawn by tools/draw_database.py -->\n", "<!-- end of what is drawn -->\n"

# What each table is about, by colour.
_GROUPS = {
    "#e8eef7": ("products", "notes", "components", "terminals", "cables", "wires"),
    "#eaf3e6": ("nodes", "segments", "clips", "routes"),
    "#f9f0dd": ("orders", "tasks", "preferences", "constraints", "rehearsals"),
    "#f6e6e6": (
        "cells",
        "runs",
        "charts",
        "run_events",
        "run_snapshots",
        "executions",
        "ability_records",
        "decisions",
    ),
    "#eeeeee": ("abilities", "ability_parameters"),
}
# The comment of the column `id`, which the page explains once.
_NUMBER_OF_ROW = "number of the row"
_TYPES = {
    "VARCHAR": "text",
    "INTEGER": "integer",
    "FLOAT": "number",
    "BOOLEAN": "yes or no",
    "BLOB": "packed",
}


def tables() -> list[Table]:
    """Return the tables, group by group."""
    known = Base.metadata.tables
    names = [name for group in _GROUPS.values() for name in group]
    if set(names) != set(known):
        raise SystemExit(f"draw_database: put into a group: {set(names) ^ set(known)}")
    return [known[name] for name in names]


def listing() -> str:
    """Return all tables with their columns: those that are described alike in one row.

    A table's own row has the columns that refer to other tables.
    """
    rows = ["| table or column | type | |", "|---|---|---|"]
    for table in tables():
        about = [_sentence(table.comment)]
        about += [f"`{c.name}` → {_type(c)}: {c.comment}" for c in table.columns if c.foreign_keys]
        rows.append(f'| <a id="{table.name}"></a>**{table.name}** | | {"<br>".join(about)} |')
        columns = (
            column
            for column in table.columns
            if not column.foreign_keys and column.comment != _NUMBER_OF_ROW
        )
        for (kind, comment), alike in groupby(columns, lambda c: (_type(c), c.comment)):
            names = ", ".join(f"`{column.name}`" for column in alike)
            rows.append(f"| {names} | {kind} | {comment} |")
    return "\n".join([*rows, ""])


def graph() -> str:
    """Return the tables and their references in Graphviz' language."""
    lines = [
        "digraph production {",
        'graph [rankdir=RL, nodesep=0.25, ranksep=0.9, fontname="sans-serif"];',
        'node [shape=plain, fontname="sans-serif", fontsize=10];',
        'edge [color="#777777", arrowsize=0.6];',
    ]
    fills = {name: fill for fill, names in _GROUPS.items() for name in names}
    for table in tables():
        rows = "".join(
            f'<tr><td port="{c.name}" align="left">{escape(c.name)}</td></tr>'
            for c in table.columns
            if c.name != "id"
        )
        head = f'<tr><td port="id" bgcolor="{fills[table.name]}"><b>{table.name}</b></td></tr>'
        border = 'border="0" cellborder="1" cellspacing="0" cellpadding="2" color="#999999"'
        lines.append(f"{table.name} [label=<<table {border}>{head}{rows}</table>>];")
    for table in tables():
        for column in table.columns:
            for key in column.foreign_keys:
                style = " [style=dashed]" if column.nullable else ""
                lines.append(f"{table.name}:{column.name} -> {key.column.table.name}:id{style};")
    return "\n".join([*lines, "}", ""])


def digest() -> str:
    """Return the line in the picture that names what it was drawn from."""
    return f"<!-- drawn from {hashlib.sha256(graph().encode()).hexdigest()} -->\n"


def drawn() -> str:
    """Return what is to stand between the marks of the page."""
    return f"\n![The tables and their references]({PICTURE.name})\n\n{listing()}\n"


def _sentence(comment: str) -> str:
    return f"{comment[0].upper()}{comment[1:]}."


def _type(column: Column) -> str:
    if column.foreign_keys:
        target = next(iter(column.foreign_keys)).column.table.name
        return f"[{target}](#{target})" + (", or none" if column.nullable else "")
    name = str(column.type)
    return _TYPES.get(name, name.lower())


def main() -> None:
    """Put the tables into the page, and draw the picture."""
    text = PAGE.read_text(encoding="utf-8")
    head, _, rest = text.partition(BEGIN)
    tail = rest.partition(END)[2]
    PAGE.write_text(f"{head}{BEGIN}{drawn()}{END}{tail}", encoding="utf-8")
    command = ["dot", "-Tsvg"]
    picture = subprocess.run(command, input=graph(), capture_output=True, text=True, check=True)
    PICTURE.write_text(picture.stdout + digest(), encoding="utf-8")


if __name__ == "__main__":
    main()
