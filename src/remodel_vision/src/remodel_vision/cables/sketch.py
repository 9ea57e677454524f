"""Draw detected cables into a picture, for people."""

from __future__ import annotations

import cv2
import numpy as np

from remodel_vision.cables.model import CableEnding, Detection
from remodel_vision.pixels import Pixels
from remodel_work.geometry import Array

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
