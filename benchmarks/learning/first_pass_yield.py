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
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

import cv2
import numpy as np

from remodel_supervision.core.learning.belief import GuardRail
from remodel_supervision.core.learning.experience import Call, LearnedParameters
from remodel_tasks.core.use_case.model import Bounds

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


# A cell in which the push force of an insertion matters, by made-up figures.
#
# In the simulated cell every force from 3 to 25 N seats an end, so that there is nothing to learn.
# Here an end seats if the push is stronger than the terminal's resistance, and weaker than what the
# grip holds and what bends the wire; all three vary from end to end.


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


# Draw first-pass yield over wires, learned against frozen. OpenCV draws: nothing to install


# [wires] over which the yield is averaged, up to each wire.
WINDOW = 60

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 760, 420, 80, 20, 56, 60
BLACK, GREY, BLUE, RED = (30, 30, 30), (220, 220, 220), (180, 110, 20), (40, 40, 210)
LEAST = 0.2

# title, (seeds, wires) of 0 and 1 with the frozen force, the same with the learned one.
Panel = tuple[str, np.ndarray, np.ndarray]


def draw(file: Path, panels: Sequence[Panel]) -> None:
    """Write a picture with one plot for each panel, two in a row."""
    pictures = [_plot(*panel) for panel in panels]
    rows = [np.hstack(pictures[i : i + 2]) for i in range(0, len(pictures), 2)]
    cv2.imwrite(str(file), np.vstack(rows))


def _plot(title: str, frozen: np.ndarray, learned: np.ndarray) -> np.ndarray:
    picture = np.full((HEIGHT, WIDTH, 3), 255, np.uint8)
    wires = frozen.shape[1]
    _axes(picture, wires)
    _text(picture, title, (LEFT, 26))
    for share, name, colour, at in (
        (frozen, "frozen", BLUE, LEFT + 10),
        (learned, "learned", RED, LEFT + 90),
    ):
        _text(picture, name, (at, HEIGHT - BOTTOM - 10), colour)
        for seed in share:
            _line(picture, _moving(seed), wires, _faint(colour), 1)
        _line(picture, _moving(share.mean(axis=0)), wires, colour, 3)
    return picture


def _moving(values: np.ndarray) -> np.ndarray:
    """Return the mean of the last WINDOW values at each, (n,) of (n,)."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    ends = np.arange(1, len(values) + 1)
    starts = np.maximum(0, ends - WINDOW)
    return (sums[ends] - sums[starts]) / (ends - starts)


def _axes(picture: np.ndarray, wires: int) -> None:
    for share in np.arange(LEAST, 1.01, 0.2):
        y = _pixel(0, share, wires)[1]
        cv2.line(picture, (LEFT, y), (WIDTH - RIGHT, y), GREY, 1)
        _text(picture, f"{share:.0%}", (LEFT - 55, y + 5))
    for wire in range(0, wires + 1, 100):
        x = _pixel(wire, LEAST, wires)[0]
        cv2.line(picture, (x, TOP), (x, HEIGHT - BOTTOM), GREY, 1)
        _text(picture, str(wire), (x - 14, HEIGHT - BOTTOM + 20))
    _text(picture, f"wire; first-pass yield of the {WINDOW} up to it", (LEFT, HEIGHT - 12))


def _line(
    picture: np.ndarray, values: np.ndarray, wires: int, colour: tuple[int, ...], width: int
) -> None:
    """Draw a curve from the first whole window on."""
    points = [_pixel(i + 1, value, wires) for i, value in enumerate(values)][WINDOW - 1 :]
    cv2.polylines(picture, [np.array(points)], False, colour, width, cv2.LINE_AA)


def _pixel(wire: float, share: float, wires: int) -> tuple[int, int]:
    x = LEFT + wire / wires * (WIDTH - LEFT - RIGHT)
    up = (share - LEAST) / (1.0 - LEAST) * (HEIGHT - TOP - BOTTOM)
    return round(x), round(HEIGHT - BOTTOM - up)


def _faint(colour: tuple[int, int, int]) -> tuple[int, ...]:
    return tuple(255 - (255 - part) // 3 for part in colour)


def _text(
    picture: np.ndarray, words: str, at: tuple[int, int], colour: tuple[int, ...] = BLACK
) -> None:
    cv2.putText(picture, words, at, cv2.FONT_HERSHEY_SIMPLEX, 0.5, colour, 1, cv2.LINE_AA)


if __name__ == "__main__":
    sys.exit(main())
