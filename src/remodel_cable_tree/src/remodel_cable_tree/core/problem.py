"""Cable Tree Wiring, after Koehler et al., Constraints 2021 (arXiv 2011.12862).

A harness has ends 1 to k. Ends i and i + b, for i up to b, are the two ends of cable i; the others
belong to cables with one end in this harness.
"""

from __future__ import annotations

from dataclasses import dataclass

from remodel_production.errors import InstanceError


@dataclass(frozen=True)
class CableTree:
    """A harness whose ends are to be inserted one after another.

    Attributes:
        ends: k.
        cables: b, those with two ends in the harness.
        atomic: (x, y): x before y.
        disjunctive: (a, b, c, d): a before b, or c before d.
        soft: (x, y): x should come before y.
        direct: x: if x comes before the other end of its cable, that one follows at once.
    """

    ends: int
    cables: int
    atomic: tuple[tuple[int, int], ...]
    disjunctive: tuple[tuple[int, int, int, int], ...]
    soft: tuple[tuple[int, int], ...]
    direct: tuple[int, ...]

    def __post_init__(self) -> None:
        """Refuse ends that are not there.

        Raises:
            InstanceError: naming the constraint.
        """
        if self.ends < 0 or not 0 <= 2 * self.cables <= self.ends:
            raise InstanceError(
                f"k = {self.ends}, b = {self.cables}: expected 0 <= 2 b <= k, since each two-sided "
                "cable has two ends"
            )
        for name, rows in (
            ("AtomicConstraints", self.atomic),
            ("DisjunctiveConstraints", self.disjunctive),
            ("SoftAtomicConstraints", self.soft),
            ("DirectSuccessors", tuple((end,) for end in self.direct)),
        ):
            for number, row in enumerate(rows, 1):
                for end in row:
                    if not 1 <= end <= self.ends:
                        raise InstanceError(
                            f"{name}, row {number}: no end {end}; ends are 1 to {self.ends}"
                        )

    def other_end(self, end: int) -> int | None:
        """Return the other end of a two-sided cable, None for a one-sided one."""
        if end > 2 * self.cables:
            return None
        return end + self.cables if end <= self.cables else end - self.cables
