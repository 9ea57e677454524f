"""Draw first-pass yield over wires, learned against frozen. OpenCV draws: nothing to install."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

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
