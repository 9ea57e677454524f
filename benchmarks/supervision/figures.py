"""The rows of a table in the docs, written as lines of JSON; see tools/figure_tables.py."""

from __future__ import annotations

import json
from argparse import ArgumentParser
from collections.abc import Iterable, Mapping
from pathlib import Path


def add_option(parser: ArgumentParser) -> None:
    """Add the option that names the file."""
    text = "also write the rows of the docs' table there, such as docs/figures/NAME.jsonl"
    parser.add_argument("--figures", type=Path, metavar="FILE", help=text)


def write(file: Path | None, rows: Iterable[Mapping[str, object]]) -> None:
    """Write the rows, unless there is no file."""
    if file is not None:
        file.write_text("".join(f"{json.dumps(row)}\n" for row in rows), encoding="utf-8")


def replace_row(file: Path | None, row: Mapping[str, object]) -> None:
    """Add a row, or replace the one with the same value in the first column."""
    if file is None:
        return
    lines = file.read_text(encoding="utf-8").splitlines() if file.is_file() else []
    column = next(iter(row))
    rows = {found[column]: found for found in map(json.loads, lines)}
    write(file, {**rows, row[column]: row}.values())
