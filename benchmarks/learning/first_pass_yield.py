#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Compare the learned push force with the frozen one: first-pass yield, and the guard rail.

first_pass_yield.py [PLOT] [--wires 600] [--seeds 5]; PLOT (out/bench/learning.png) is drawn, and
the figures are printed and written beside it, as lines of JSON for the docs. Exits with 1 when a
stretch of trials lost more than the guard rail allows.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from made_up_cell import SCENARIOS, Scenario, ends, luck
from yield_plot import draw

from remodel_planning.core.use_case.bounds import Bounds
from remodel_supervision.core.learning.experience import Call, LearnedParameters
from remodel_supervision.core.learning.parameter_choice import GuardRail

ABILITY, FORCE = "InsertCable", "force_limit"
# [N] What states push with, and what is safe.
BOUNDS = {FORCE: Bounds(8.0, 4.0, 16.0, 7)}
ATTEMPTS = 3
JAMMED = 301


@dataclass(frozen=True)
class Course:
    """How one order went.

    Attributes:
        first_pass: (wires,) 1 where both ends were seated at the first attempt, else 0.
        losses: of each trial, what the frozen force would have done better, as a probability.
    """

    first_pass: np.ndarray
    losses: tuple[float, ...]

    @property
    def worst_stretch(self) -> float:
        """[successes] The greatest loss of any stretch of trials, beyond the guard's share."""
        worst = stretch = 0.0
        for loss in self.losses:
            stretch = max(0.0, stretch + loss - GuardRail().share)
            worst = max(worst, stretch)
        return worst


def wire_up(scenario: Scenario, wires: int, seed: int, learns: bool) -> Course:
    """Insert both ends of all wires, each with up to three attempts."""
    learned = LearnedParameters()
    first_pass, losses = np.ones(wires), []
    for wire in range(wires):
        for number, end in enumerate(ends(seed, wire)):
            features = {"terminal_type": end.terminal_type, "section_mm2": end.section_mm2}
            for attempt in range(ATTEMPTS):
                force_n = BOUNDS[FORCE].frozen
                if learns:
                    where = f"{seed} {wire} {number} {attempt}"
                    force_n = learned.choose(ABILITY, features, BOUNDS, where)[FORCE]
                chance = scenario.chance(wire, end, force_n)
                losses.append(scenario.chance(wire, end, BOUNDS[FORCE].frozen) - chance)
                seated = luck(seed, wire, number, attempt) < chance
                code = 0 if seated else JAMMED
                learned.learn(Call(ABILITY, features, code, 6.0, {FORCE: force_n}))
                if seated:
                    break
                first_pass[wire] = 0.0
    return Course(first_pass, tuple(losses))


def main() -> int:
    """Wire up all orders, draw the plot and print the figures; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("plot", nargs="?", type=Path, default=Path("out/bench/learning.png"))
    parser.add_argument("--wires", type=int, default=600)
    parser.add_argument("--seeds", type=int, default=5)
    options = parser.parse_args()
    options.plot.parent.mkdir(parents=True, exist_ok=True)
    guard, panels, rows, kept = GuardRail(), [], [], True
    print(f"first-pass yield of {options.wires} wires, {options.seeds} seeds [%]; worst stretch of")
    print(f"trials, beyond {guard.share:.0%} of them [successes, at most {guard.slack:g}]\n")
    print(f"{'':<42}{'frozen':>8}{'learned':>9}{'last 100: frozen':>18}{'learned':>9}{'worst':>7}")
    for scenario in SCENARIOS:
        courses = {
            learns: [
                wire_up(scenario, options.wires, seed, learns) for seed in range(options.seeds)
            ]
            for learns in (False, True)
        }
        yields = {key: np.array([c.first_pass for c in found]) for key, found in courses.items()}
        worst = max(course.worst_stretch for course in courses[True])
        kept &= worst <= guard.slack
        whole = [100 * yields[learns].mean() for learns in (False, True)]
        late = [100 * yields[learns][:, -100:].mean() for learns in (False, True)]
        print(
            f"{scenario.title:<42}{whole[0]:>8.1f}{whole[1]:>9.1f}{late[0]:>18.1f}{late[1]:>9.1f}"
            f"{worst:>7.1f}"
        )
        rows.append(
            {
                "first-pass yield [%]": scenario.title,
                "frozen": f"{whole[0]:.1f}",
                "learned": f"{whole[1]:.1f}",
                "last 100: frozen": f"{late[0]:.1f}",
                "last 100: learned": f"{late[1]:.1f}",
                f"worst sequence (at most {guard.slack:g})": f"{worst:.1f}",
            }
        )
        panels.append((scenario.title, yields[False], yields[True]))
    draw(options.plot, panels)
    figures = options.plot.with_suffix(".jsonl")
    figures.write_text("".join(f"{json.dumps(row)}\n" for row in rows))
    print(f"\nplot: {options.plot}, figures: {figures}")
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
