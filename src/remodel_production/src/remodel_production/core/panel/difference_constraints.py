"""Solve constraints on differences of unknowns: y[u] - y[v] >= gap.

The least solution is that of longest paths, found by relaxation (Bellman and Ford; Cormen et al.,
Introduction to Algorithms, 3rd ed., section 24.4).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class AtLeast:
    """y[upper] is greater than y[lower] by at least the gap, which may be negative."""

    upper: str
    lower: str
    gap: float


def least_solution(
    lowest: Mapping[str, float], constraints: Iterable[AtLeast], tolerance: float = 1e-9
) -> dict[str, float] | None:
    """Return the least values that meet the constraints, or None if none do.

    Args:
        lowest: for every unknown, the least value that it may have.
        constraints: between those unknowns.
        tolerance: by which a constraint may be missed.
    """
    constraints = tuple(constraints)
    values = dict(lowest)
    for _ in range(len(values) + 1):
        changed = False
        for constraint in constraints:
            least = values[constraint.lower] + constraint.gap
            if values[constraint.upper] < least - tolerance:
                values[constraint.upper] = least
                changed = True
        if not changed:
            return values
    return None
