"""Cables as values, and their drawing."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import cv2
import numpy as np

from remodel_vision.cables.lines import Spline
from remodel_vision.colour import Pixels
from remodel_work.geometry import Array


class CableEnding(Enum):
    """How a cable ends in a picture."""

    TIP = "tip"
    TRUNCATED = "truncated"
    HIDDEN = "hidden"


@dataclass(frozen=True, eq=False)
class Tip:
    """One of a cable's two ends.

    Attributes:
        point: (2,) the outermost point of the centreline [px].
        outward: (2,) unit vector along the cable and out of it.
        end: whether the cable ends there, leaves the picture, or goes on unseen.
    """

    point: Array
    outward: Array
    end: CableEnding


@dataclass(frozen=True, eq=False)
class DetectedCable:
    """A cable in a picture.

    Attributes:
        centreline: (n, 2) from the first tip to the last [px].
        spline: the centreline as a B-spline over 0 to 1.
        tips: the first and the last.
        width: [px].
        colour: mean, RGB 0 to 255.
        confidence: 0 to 1: the probability that this is one cable and all of it.
        warnings: the reasons why this cable may be wrong.
    """

    centreline: Array
    spline: Spline
    tips: tuple[Tip, Tip]
    width: float
    colour: tuple[float, float, float]
    confidence: float
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Crossing:
    """Where two strands cross; a cable that crosses itself is both.

    Attributes:
        point: (2,) [px].
        upper, lower: indices of the cables.
        upper_at, lower_at: the splines' parameters, 0 to 1.
        confidence: 0 to 1 that the upper one is on top.
    """

    point: Array
    upper: int
    lower: int
    upper_at: float
    lower_at: float
    confidence: float


@dataclass(frozen=True, eq=False)
class Detection:
    """All cables of a picture.

    `warnings` are the reasons why the result may be wrong, those of its cables included. A result
    without any is reliable.

    Attributes:
        cables: the longest first.
        crossings: where they cross.
    """

    cables: tuple[DetectedCable, ...]
    crossings: tuple[Crossing, ...]
    warnings: tuple[str, ...]


COLOURS = ((40, 200, 60), (230, 60, 220), (20, 190, 230), (250, 160, 20), (120, 110, 250))
ENDS = {
    CableEnding.TIP: (255, 40, 40),
    CableEnding.TRUNCATED: (40, 90, 255),
    CableEnding.HIDDEN: (255, 200, 0),
}
PAPER, INK = (255, 255, 255), (20, 20, 20)
SHIFT = 4  # sub-pixel bits of OpenCV's drawing functions


def sketch(rgb: Pixels, found: Detection) -> Pixels:
    """Return a picture with the centrelines, ends (a ring each) and crossings (upper number)."""
    drawn = rgb.copy()
    unit = max(1.0, max(rgb.shape[:2]) / 640)
    for i, cable in enumerate(found.cables):
        line = _fixed(cable.centreline).reshape(-1, 1, 2)
        for colour, width in ((INK, 3.0), (COLOURS[i % len(COLOURS)], 1.4)):
            cv2.polylines(drawn, [line], False, colour, round(width * unit), cv2.LINE_AA, SHIFT)
        for tip in cable.tips:
            _ring(drawn, tip.point, 6 * unit, ENDS[tip.end], unit=unit)
        _note(drawn, f"{i}", cable.tips[0].point + 9 * unit, unit)
    for crossing in found.crossings:
        _ring(drawn, crossing.point, 4 * unit, PAPER, unit=unit)
        sure = "" if crossing.confidence > 0.5 else "?"
        _note(drawn, f"{crossing.upper}{sure}", crossing.point + 6 * unit, unit)
    return drawn


def _fixed(points: Array) -> Pixels:
    return np.rint(np.asarray(points) * 2**SHIFT).astype(np.int32)


def _ring(drawn: Pixels, at: Array, radius: float, colour: tuple[int, ...], unit: float) -> None:
    place = tuple(_fixed(at).tolist())
    cv2.circle(
        drawn, place, round(radius * 2**SHIFT), colour, max(1, round(unit)), cv2.LINE_AA, SHIFT
    )


def _note(drawn: Pixels, text: str, at: Array, unit: float) -> None:
    place = (round(float(at[0])), round(float(at[1])))
    for colour, width in ((INK, 3), (PAPER, 1)):
        cv2.putText(
            drawn,
            text,
            place,
            cv2.FONT_HERSHEY_SIMPLEX,
            0.4 * unit,
            colour,
            round(width * unit),
            cv2.LINE_AA,
        )
