"""Figures of the vision benchmarks: a line of a table, and a line of JSON, each."""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

OUT = Path(__file__).parents[2] / "out" / "bench" / "vision.jsonl"


@dataclass(frozen=True)
class Row:
    """A figure, and what it is to be at least or at most; neither for a figure to know."""

    what: str
    value: float
    unit: str = ""
    at_least: float | None = None
    at_most: float | None = None

    @property
    def target(self) -> float | None:
        """What it is to be at least or at most."""
        return self.at_most if self.at_least is None else self.at_least

    @property
    def verdict(self) -> str:
        """Whether the target is met."""
        if self.at_least is None and self.at_most is None:
            return ""
        low = self.at_least is None or self.value >= self.at_least
        high = self.at_most is None or self.value <= self.at_most
        return "met" if low and high else "MISSED"


def start() -> None:
    """Remove the file of an earlier run."""
    OUT.parent.mkdir(parents=True, exist_ok=True)
    OUT.unlink(missing_ok=True)


def report(row: Row) -> None:
    """Print a line of the table and add a line to the file."""
    target = f">= {row.at_least:g}" if row.at_least is not None else ""
    target = f"<= {row.at_most:g}" if row.at_most is not None else target
    print(f"{row.what:<62}{row.value:>9.3f} {row.unit:<3} {target:>9} {row.verdict}", flush=True)
    OUT.parent.mkdir(parents=True, exist_ok=True)
    with OUT.open("a", encoding="utf-8") as lines:
        lines.write(json.dumps(asdict(row)) + "\n")
