"""A cell in which the push force of an insertion matters, by made-up figures.

In the simulated cell every force from 3 to 25 N seats an end, so that there is nothing to learn.
Here an end seats if the push is stronger than the terminal's resistance, and weaker than what the
grip holds and what bends the wire; all three vary from end to end.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from random import Random

# [N] Means of the resistance by terminal and section [mm2], of what bends a wire, and of the grip.
RESISTANCE_N = {
    ("screw", 0.5): 3.0,
    ("screw", 1.5): 5.0,
    ("screw", 2.5): 6.5,
    ("spring", 0.5): 4.5,
    ("spring", 1.5): 6.5,
    ("spring", 2.5): 8.0,
}
BENDING_N = {0.5: 9.0, 1.5: 25.0, 2.5: 40.0}
STIFF_N = {0.5: 25.0, 1.5: 25.0, 2.5: 40.0}
GRIP_N = 18.0

# [N] Standard deviations of the three, and [1] how often an insertion succeeds besides.
RESISTANCE_SPREAD_N, BENDING_SPREAD_N, GRIP_SPREAD_N = 1.2, 1.5, 2.0
OTHERWISE = 0.99


@dataclass(frozen=True)
class End:
    """An end of a wire to be inserted."""

    terminal_type: str
    section_mm2: float


@dataclass(frozen=True)
class Scenario:
    """How a cell changes from wire to wire.

    Attributes:
        title: for the plot.
        resistance: wire number, end -> mean [N].
        grip: wire number -> mean [N].
        bending: section [mm2] -> mean [N].
    """

    title: str
    resistance: Callable[[int, End], float]
    grip: Callable[[int], float]
    bending: Mapping[float, float] = field(default_factory=lambda: BENDING_N)

    def chance(self, wire: int, end: End, force_n: float) -> float:
        """Return the probability that an end is seated by a force."""
        margins = (
            (force_n - self.resistance(wire, end)) / RESISTANCE_SPREAD_N,
            (self.grip(wire) - force_n) / GRIP_SPREAD_N,
            (self.bending[end.section_mm2] - force_n) / BENDING_SPREAD_N,
        )
        return OTHERWISE * math.prod(0.5 + 0.5 * math.erf(m / math.sqrt(2.0)) for m in margins)


def _by_table(_: int, end: End) -> float:
    return RESISTANCE_N[end.terminal_type, end.section_mm2]


def _worn(wire: int) -> float:
    """Pads that wear from wire 150 on, and are changed at 400."""
    return GRIP_N - 9.0 * max(0.0, (wire - 150) / 250) if wire < 400 else GRIP_N


def _other_batch(wire: int, end: End) -> float:
    """Terminals of another maker from wire 300 on: those that needed force need less of it."""
    return _by_table(wire, end) - (3.0 if wire >= 300 else 0.0)


SCENARIOS = (
    Scenario("a cell that stays as it is", _by_table, lambda _: GRIP_N),
    Scenario("pads wear from wire 150, changed at 400", _by_table, _worn),
    Scenario("easier terminals from wire 300", _other_batch, lambda _: GRIP_N),
    Scenario("the frozen force is the best", lambda *_: 5.5, lambda _: 12.0, STIFF_N),
)


def ends(seed: int, wire: int) -> tuple[End, End]:
    """Return the ends of a wire: of one section, each with its terminal."""
    random = Random(f"wire {seed} {wire}")
    section = random.choice((0.5, 1.5, 2.5))
    return tuple(End(random.choice(("screw", "spring")), section) for _ in range(2))


def luck(seed: int, wire: int, end: int, attempt: int) -> float:
    """Return what decides one trial, 0 to 1: the same for all who try it."""
    return Random(f"luck {seed} {wire} {end} {attempt}").random()
