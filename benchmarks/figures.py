"""Figures of the benchmarks: printed as they come, and written for the docs' tables.

A table is a file of docs/figures, a line of JSON for each row; tools/figure_tables.py brings it
into the page that names it.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import json
from argparse import ArgumentParser
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path


@dataclass(frozen=True)
class Figure:
    """A figure, and what it is to be.

    Attributes:
        what: was measured.
        value: the figure.
        unit: its unit.
        least, most: what it is to be at least or at most; None without such a target.
        floor: the figure of a plain program that does only this; None without one.
    """

    what: str
    value: float
    unit: str = ""
    least: float | None = None
    most: float | None = None
    floor: float | None = None

    @property
    def is_met(self) -> bool:
        """Whether it is as good as its target; true without one."""
        low = self.least is None or self.value >= self.least
        return low and (self.most is None or self.value <= self.most)


def add_figures_option(parser: ArgumentParser) -> None:
    """Add the option that names the file of a table in the docs."""
    text = "file of the docs' table, such as docs/figures/NAME.jsonl"
    parser.add_argument("--figures", type=Path, metavar="FILE", help=text)


def report(figures: Iterable[Figure], file: Path | None = None) -> bool:
    """Print figures as they come, write them to a file; return whether all targets are met."""
    found = []
    for each in figures:
        target = "" if each.most is None else f"at most {each.most:g}"
        target = target if each.least is None else f"at least {each.least:g}"
        ratio = f"{each.value / each.floor:.1f} times its floor" if each.floor else ""
        verdict = "" if not target else "met" if each.is_met else "MISSED"
        words = filter(None, (each.unit, ratio, target, verdict))
        print(f"{each.what:<72}{each.value:>12.4g} {' '.join(words)}", flush=True)
        found.append(each)
    write_rows(map(asdict, found), file)
    return all(each.is_met for each in found)


def write_rows(rows: Iterable[Mapping[str, object]], file: Path | None) -> None:
    """Write the rows of a table to a file, unless there is none."""
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("".join(f"{json.dumps(row)}\n" for row in rows), encoding="utf-8")


def report_table(rows: Iterable[Mapping[str, str]], file: Path | None = None) -> None:
    """Print the rows of a table, whose keys are its columns, and write them to a file."""
    kept = list(rows)
    columns = list(dict.fromkeys(column for row in kept for column in row))
    cells = [columns, *([str(row.get(column, "")) for column in columns] for row in kept)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for row in cells:
        print("  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)))
    write_rows(kept, file)
