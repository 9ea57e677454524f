"""Which wires the robots of a cell can place along their routes; planner and cell both ask here."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from remodel_states.core.cell.cell_limits import CellLimits

# A wall that is no longer is a post of a fork: it holds no wire bent [m].
FORK_LENGTH_M = 0.020
# A slot lets a wire through that is thinner by this [m].
SLOT_PLAY_M = 0.0003
# A wire that is let down into forks is so much longer than the line between its openings: shorter,
# its second end does not come in front of its opening; longer, it bows out between the forks [m].
SPARE_M = (0.028, 0.060)
STRAIGHT_RAD = math.radians(5.0)
# Rounding of lengths [m].
_TOLERANCE_M = 1e-6


class Objection(NamedTuple):
    """Why no robot places a wire: what several wires may have in common, and a sentence."""

    kind: str
    sentence: str


@dataclass(frozen=True)
class Passage:
    """A duct, or the posts of a fork, on a wire's route.

    Attributes:
        name: of it.
        length: of its walls [m].
        slot_pitch: between the slots of its walls [m]; 0: they are solid.
        slot_width: of these slots [m].
    """

    name: str
    length: float
    slot_pitch: float
    slot_width: float

    @property
    def is_fork(self) -> bool:
        """Whether it is no trough, but the posts of a fork: walls too short to hold a wire bent."""
        return not self.slot_pitch and self.length <= FORK_LENGTH_M


def objections(
    takes: CellLimits,
    length: float,
    diameter: float,
    route: Sequence[Sequence[float]],
    passages: Sequence[Passage],
) -> Iterator[Objection]:
    """Yield why the robots of a cell cannot place a wire; nothing: they can.

    Args:
        takes: the limits of the cell.
        length: of the wire, from tip to tip [m].
        diameter: over its insulation [m].
        route: x and y, and what follows, of points [m], from opening to opening; empty: free.
        passages: the ducts and forks on the route.
    """
    kinds = ("shorter than {0:g} m", "longer than {1:g} m")
    for sentence in takes.about_length(length):
        yield Objection(_kind(kinds, length, takes.wire_length), sentence)
    kinds = ("thinner than {0:g} mm", "thicker than {1:g} mm")
    limits_mm = (1e3 * takes.wire_diameter[0], 1e3 * takes.wire_diameter[1])
    for sentence in takes.about_diameter(diameter):
        yield Objection(_kind(kinds, 1e3 * diameter, limits_mm), sentence)
    along = sum(math.dist(p[:2], q[:2]) for p, q in pairwise(route))
    if length < along:
        yield Objection(
            "shorter than their routes",
            f"it is {length:.2f} m long and its route {along:.2f} m, {along - length:.2f} m too "
            "short: cut it to the route's length and both bends",
        )
    if any(passage.is_fork for passage in passages):
        yield from _about_forks(length, along, route)
    for passage in dict.fromkeys(passages):
        lack = diameter + SLOT_PLAY_M - passage.slot_width
        if passage.slot_pitch and lack > 0:
            yield Objection(
                "thicker than slots",
                f"{diameter * 1e3:.1f} mm thick, and the slots of duct {passage.name!r} are "
                f"{passage.slot_width * 1e3:.1f} mm wide, {lack * 1e3:.1f} mm too narrow: slots of "
                f"{(diameter + SLOT_PLAY_M) * 1e3:.1f} mm",
            )


def _kind(kinds: tuple[str, str], found: float, limits: tuple[float, float]) -> str:
    return kinds[found > limits[1]].format(*limits)


def _about_forks(
    length: float, along: float, route: Sequence[Sequence[float]]
) -> Iterator[Objection]:
    """Yield why a wire with a route of a length [m] cannot be let down into its forks."""
    headings = [math.atan2(q[1] - p[1], q[0] - p[0]) for p, q in pairwise(route)]
    turn = max((abs(_wrapped(b - a)) for a, b in pairwise(headings)), default=0.0)
    if turn > STRAIGHT_RAD:
        yield Objection(
            "not straight through forks",
            f"its route turns by {math.degrees(turn):.0f} deg; the cell lets wires down into forks "
            "in a straight line only: connectors that face each other",
        )
        return
    least, most = SPARE_M
    if not least - _TOLERANCE_M <= length - along <= most + _TOLERANCE_M:
        yield Objection(
            "not cut for their forks",
            f"it is {length:.3f} m long and its openings are {along:.3f} m apart, through forks; "
            f"allowed: {least * 1e3:.0f} to {most * 1e3:.0f} mm more: cut it to "
            f"{along + least:.3f} to {along + most:.3f} m",
        )


def _wrapped(angle: float) -> float:
    """Return an angle [rad] between -pi and pi."""
    return math.remainder(angle, math.tau)
