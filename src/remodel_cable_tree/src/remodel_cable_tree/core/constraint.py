"""The hard constraints of a cable tree one by one, to explain which of them contradict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from remodel_cable_tree.core.problem import CableTree


@dataclass(frozen=True)
class Constraint:
    """A row of a table of hard constraints.

    Attributes:
        table: its name in the file.
        row: from 1, as in the file.
        ends: of the row.
    """

    table: str
    row: int
    ends: tuple[int, ...]

    def __str__(self) -> str:
        """Return the line for a person."""
        if self.table == "AtomicConstraints":
            text = "end {} before end {}".format(*self.ends)
        elif self.table == "DisjunctiveConstraints":
            text = "end {} before end {}, or end {} before end {}".format(*self.ends)
        else:
            text = (
                f"the other end of its cable follows end {self.ends[0]} at once if it comes later"
            )
        return f"{self.table}, row {self.row}: {text}"


def constraints_of(tree: CableTree) -> list[Constraint]:
    """Return the hard constraints of a cable tree; the direct successors come last."""
    tables = (
        ("AtomicConstraints", tree.atomic),
        ("DisjunctiveConstraints", tree.disjunctive),
        ("DirectSuccessors", tuple((end,) for end in tree.direct)),
    )
    return [
        Constraint(name, number, row) for name, rows in tables for number, row in enumerate(rows, 1)
    ]


def with_constraints(tree: CableTree, kept: Sequence[Constraint]) -> CableTree:
    """Return a cable tree with no hard constraints but those."""
    atomic, disjunctive, direct = [], [], []
    for each in kept:
        match each.ends:
            case (x, y):
                atomic.append((x, y))
            case (a, b, c, d):
                disjunctive.append((a, b, c, d))
            case (end,):
                direct.append(end)
    return replace(tree, atomic=tuple(atomic), disjunctive=tuple(disjunctive), direct=tuple(direct))
