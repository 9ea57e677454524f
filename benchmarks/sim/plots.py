#!/usr/bin/env python3
"""Draw the simulated wire beside theory: plots.py [FOLDER] makes sag.png and buckling.png.

OpenCV draws, so that nothing else needs to be installed.
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

HERE = Path(__file__).parent
for folder in ("remodel_sim/test/unit", "remodel_work/test"):
    sys.path.insert(0, str(HERE.parents[1] / "src" / folder))

import rods  # noqa: E402
from elastica import buckled_tip_angle, cantilever_shape  # noqa: E402

WIDTH, HEIGHT, MARGIN = 900, 560, 90
BLACK, GREY, BLUE, RED = (30, 30, 30), (205, 205, 205), (180, 110, 20), (40, 40, 210)
LOADS = (1.0, 5.0, 21.0)
RATIOS = (0.9, 0.97, 1.03, 1.06, 1.1, 1.2, 1.35, 1.5, 1.75, 2.0)


@dataclass(frozen=True)
class Axes:
    """A plot's picture, and the ranges of its axes."""

    picture: np.ndarray
    x: tuple[float, float]
    y: tuple[float, float]

    def pixel(self, x: float, y: float) -> tuple[int, int]:
        """Return where a point is drawn."""
        across = (x - self.x[0]) / (self.x[1] - self.x[0])
        up = (y - self.y[0]) / (self.y[1] - self.y[0])
        return (
            round(MARGIN + across * (WIDTH - 1.5 * MARGIN)),
            round(HEIGHT - MARGIN * 0.8 - up * (HEIGHT - 1.6 * MARGIN)),
        )

    def line(self, xs: np.ndarray, ys: np.ndarray) -> None:
        """Draw a theoretical curve."""
        points = np.array([self.pixel(x, y) for x, y in zip(xs, ys, strict=True)])
        cv2.polylines(self.picture, [points.reshape(-1, 1, 2)], False, BLUE, 2, cv2.LINE_AA)

    def dots(self, xs: np.ndarray, ys: np.ndarray) -> None:
        """Draw simulated points."""
        for x, y in zip(xs, ys, strict=True):
            cv2.circle(self.picture, self.pixel(x, y), 4, RED, -1, cv2.LINE_AA)

    def text(self, words: str, at: tuple[int, int], colour: tuple[int, int, int] = BLACK) -> None:
        """Write words."""
        cv2.putText(self.picture, words, at, cv2.FONT_HERSHEY_SIMPLEX, 0.55, colour, 1, cv2.LINE_AA)


def axes(
    title: str,
    names: tuple[str, str],
    x: tuple[float, ...],
    y: tuple[float, ...],
    *,
    legend: bool = True,
) -> Axes:
    """Return an empty plot; x and y are the ticks, the legend separates theory from simulation."""
    plot = Axes(np.full((HEIGHT, WIDTH, 3), 255, np.uint8), (x[0], x[-1]), (y[0], y[-1]))
    for tick in x:
        cv2.line(plot.picture, plot.pixel(tick, y[0]), plot.pixel(tick, y[-1]), GREY, 1)
        column, row = plot.pixel(tick, y[0])
        plot.text(f"{tick:g}", (column - 12, row + 22))
    for tick in y:
        cv2.line(plot.picture, plot.pixel(x[0], tick), plot.pixel(x[-1], tick), GREY, 1)
        column, row = plot.pixel(x[0], tick)
        plot.text(f"{tick:g}", (column - 52, row + 6))
    plot.text(title, (MARGIN, 34))
    plot.text(names[0], (WIDTH // 2 - 60, HEIGHT - 18))
    plot.text(names[1], (12, 58))
    if legend:
        plot.text("theory", (WIDTH - 190, 34), BLUE)
        plot.text("simulation", (WIDTH - 120, 34), RED)
    return plot


def draw_sag() -> np.ndarray:
    """Return the shapes of clamped wires under their weight."""
    plot = axes(
        "Clamped wire under its weight, 24 links: shape / length",
        ("x / L", "z / L"),
        (0.0, 0.2, 0.4, 0.6, 0.8, 1.0),
        (-1.0, -0.8, -0.6, -0.4, -0.2, 0.0),
    )
    for load in LOADS:
        xs, ys = cantilever_shape(load)
        plot.line(np.array(xs), -np.array(ys))
        rod = rods.Rod(load=load)
        rod.come_to_rest()
        nodes = rod.cable.nodes()[1:] - [0.0, 0.0, rods.HEIGHT]
        rod.close()
        plot.dots(nodes[:, 0] / rods.LENGTH, nodes[:, 2] / rods.LENGTH)
        column, row = plot.pixel(xs[-1], -ys[-1])
        plot.text(f"w L^3 / EI = {load:g}", (column - 120, row + 30))
    return plot.picture


def draw_buckling() -> np.ndarray:
    """Return the tip's angle over the load."""
    plot = axes(
        "Clamped wire pushed at its tip, 24 links: the tip's angle [deg]",
        ("P / Pcr", "[deg]"),
        (0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0),
        (0.0, 25.0, 50.0, 75.0, 100.0, 125.0),
    )
    fine = np.linspace(0.8, 2.0, 400)
    plot.line(fine, np.array([math.degrees(buckled_tip_angle(r)) for r in fine]))
    angles = [math.degrees(rods.buckle(ratio)) for ratio in RATIOS]
    plot.dots(np.array(RATIOS), np.array(angles))
    return plot.picture


def main() -> None:
    """Write both pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path("docs"))
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(folder / "sag.png"), draw_sag())
    cv2.imwrite(str(folder / "buckling.png"), draw_buckling())


if __name__ == "__main__":
    main()
