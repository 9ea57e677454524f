"""Results of benchmarks: as lines of JSON, and as a table."""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path


@dataclass(frozen=True)
class Row:
    """One figure.

    Attributes:
        what: what was measured.
        value: the figure.
        unit: its unit.
        target: what it is to be at most; None if it is there to compare with.
        floor: the figure of the same run of a plain program that does only this; None without.
    """

    what: str
    value: float
    unit: str
    target: float | None = None
    floor: float | None = None


def report(row: Row, file: Path) -> None:
    """Print a line of the table and add a line to the file."""
    target = "" if row.target is None else f"{row.target:>9.3g}"
    verdict = "" if row.target is None else "met" if row.value <= row.target else "MISSED"
    ratio = "" if not row.floor else f"{row.value / row.floor:>7.1f} x"
    print(
        f"{row.what:<58}{row.value:>10.3f} {row.unit:<7}{target:>9} {verdict:<7}{ratio}", flush=True
    )
    with file.open("a", encoding="utf-8") as lines:
        lines.write(json.dumps(asdict(row)) + "\n")


def report_all(rows: Iterable[Row], file: Path) -> None:
    """Report rows as they come."""
    for row in rows:
        report(row, file)
