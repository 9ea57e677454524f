"""The result of the detector."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from remodel_vision.cables.curves.spline import Spline
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
