"""Results of the simulation's benchmarks: as lines of JSON, and as a table."""
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
        least: what it is to be at least; None without such a target.
        most: what it is to be at most; None without such a target.
    """

    what: str
    value: float
    unit: str
    least: float | None = None
    most: float | None = None

    @property
    def target(self) -> str:
        """The target in words; empty without one."""
        if self.least is not None:
            return f">= {self.least:.3g}"
        return "" if self.most is None else f"<= {self.most:.3g}"

    @property
    def met(self) -> bool:
        """Whether the figure is as good as its target; true without one."""
        return (self.least is None or self.value >= self.least) and (
            self.most is None or self.value <= self.most
        )


def head() -> str:
    """Return the head of the table."""
    return f"{'':<66}{'figure':>10} {'':<8}{'target':>9}"


def report(rows: Iterable[Row], file: Path) -> bool:
    """Print rows as they come, add them to the file; return whether every target is met."""
    good = True
    with file.open("a", encoding="utf-8") as lines:
        for row in rows:
            verdict = "" if not row.target else "met" if row.met else "MISSED"
            print(
                f"{row.what:<66}{row.value:>10.3f} {row.unit:<8}{row.target:>9} {verdict}",
                flush=True,
            )
            lines.write(json.dumps({**asdict(row), "met": bool(row.met)}) + "\n")
            lines.flush()
            good &= row.met
    return good
