#!/usr/bin/env python3
"""Compare the learned push force with the frozen one: first-pass yield, and the guard rail.

first_pass_yield.py [--wires 600] [--seeds 5] [--figures FILE]; the workspace must be sourced. Exits
with 1 when a sequence of trials lost more than the guard rail allows.

The cell is synthetic: in the simulated one every force from 3 to 25 N seats an end, so that there
is nothing to learn. Here an end is seated if the push is stronger than the terminal's resistance,
and weaker than what the grip holds and what bends the wire; all three vary from end to end. Both
forces are tried with the same wires and the same random numbers.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from figures import add_figures_option, report_table

from remodel_supervision.core.learning.belief import GuardRail
from remodel_supervision.core.learning.experience import Call, LearnedParameters
from remodel_tasks.core.use_case.model import Bounds

ABILITY, FORCE = "InsertCable", "force_limit"
# [N] What states push with, and what is safe.
BOUNDS = {FORCE: Bounds(8.0, 4.0, 16.0, 7)}
ATTEMPTS = 3
JAMMED = 301
LATE = 100  # wires at the end

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


# Terminal and section [mm2] of an end.
End = tuple[str, float]


@dataclass(frozen=True)
class Scenario:
    """How a cell changes from wire to wire.

    Attributes:
        title: in the table.
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
            (self.bending[end[1]] - force_n) / BENDING_SPREAD_N,
        )
        return OTHERWISE * math.prod(0.5 + 0.5 * math.erf(m / math.sqrt(2.0)) for m in margins)


def _by_table(_: int, end: End) -> float:
    return RESISTANCE_N[end]


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


def ends(seed: int, wire: int) -> tuple[End, ...]:
    """Return the ends of a wire: of one section, each with its terminal."""
    random = Random(f"wire {seed} {wire}")
    section = random.choice((0.5, 1.5, 2.5))
    return tuple((random.choice(("screw", "spring")), section) for _ in range(2))


def luck(seed: int, wire: int, end: int, attempt: int) -> float:
    """Return what decides one trial, 0 to 1: the same for all who try it."""
    return Random(f"luck {seed} {wire} {end} {attempt}").random()


def wire_up(scenario: Scenario, wires: int, seed: int, learns: bool) -> tuple[np.ndarray, float]:
    """Insert both ends of all wires, each with up to three attempts.

    Returns:
        (wires,) 1 where both ends were seated at the first attempt, else 0; and the greatest loss
        of any sequence of trials, beyond the guard's share [successes].
    """
    learned, share = LearnedParameters(), GuardRail().share
    first_pass, loss, worst = np.ones(wires), 0.0, 0.0
    for wire in range(wires):
        for number, end in enumerate(ends(seed, wire)):
            features = dict(zip(("terminal_type", "section_mm2"), end, strict=True))
            for attempt in range(ATTEMPTS):
                force_n = BOUNDS[FORCE].frozen
                if learns:
                    where = f"{seed} {wire} {number} {attempt}"
                    force_n = learned.choose(ABILITY, features, BOUNDS, where)[FORCE]
                chance = scenario.chance(wire, end, force_n)
                missed = scenario.chance(wire, end, BOUNDS[FORCE].frozen) - chance
                loss = max(0.0, loss + missed - share)
                worst = max(worst, loss)
                is_seated = luck(seed, wire, number, attempt) < chance
                code = 0 if is_seated else JAMMED
                learned.learn(Call(ABILITY, features, code, 6.0, {FORCE: force_n}))
                if is_seated:
                    break
                first_pass[wire] = 0.0
    return first_pass, worst


def main() -> int:
    """Wire up all orders and print the figures; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--wires", type=int, default=600)
    parser.add_argument("--seeds", type=int, default=5)
    add_figures_option(parser)
    options = parser.parse_args()
    slack, rows, is_kept = GuardRail().slack, [], True
    for scenario in SCENARIOS:
        frozen, learned = (
            [wire_up(scenario, options.wires, seed, learns) for seed in range(options.seeds)]
            for learns in (False, True)
        )
        worst = max(worst for _, worst in learned)
        is_kept &= worst <= slack
        of_all, of_last = (
            [100 * np.array([found[-n:] for found, _ in each]).mean() for each in (frozen, learned)]
            for n in (options.wires, LATE)
        )
        names = ("frozen", "learned", f"last {LATE}: frozen", f"last {LATE}: learned")
        names = (*names, f"worst sequence (at most {slack:g})")
        shares = (f"{share:.1f}" for share in (*of_all, *of_last, worst))
        rows.append(
            {"first-pass yield [%]": scenario.title, **dict(zip(names, shares, strict=True))}
        )
    report_table(rows, options.figures)
    return 0 if is_kept else 1


if __name__ == "__main__":
    sys.exit(main())
