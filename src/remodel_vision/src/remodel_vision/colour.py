"""Colours of pixels."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from remodel_states.core.wires.wire_colours import Rgb, rgbs_of
from remodel_work.geometry import Array
from remodel_work.wire_colours import PLATE_RGB

Pixels = npt.NDArray[Any]


Mask = npt.NDArray[np.uint8]

# Shades of a round wire under diffuse light, and of the level plate.
WIRE_SHADES = (0.45, 1.15)
PLATE_SHADES = (0.88, 1.13)
# Half of the likelihood is lost at this distance from the wire's colour [grey levels].
TOLERANCE = 40.0
# The background's likelihood is taken to be at most this: a picture full of wire keeps contrast.
MAX_FLOOR = 0.6

# The ferrules' magenta in OpenCV's HSV (hue 0 to 179): the hue of FERRULE_RGB, and saturated as no
# wire is.
FERRULE_HUES = (150, 172)
FERRULE_MIN_SATURATION = 150
FERRULE_MIN_VALUE = 60


def wire_likelihood(rgb: npt.NDArray[np.uint8], colour: str) -> npt.NDArray[np.float32]:
    """Return per pixel, 0 to 1, how well a wire's colour explains it and the plate does not.

    Most of a picture is no wire: its median counts as 0. So a white wire stands out on a light
    plate, whose likelihood is near a half everywhere.
    """
    pixels = rgb.astype(np.float32)
    wire = np.min([shade_distance(pixels, rgb, WIRE_SHADES) for rgb in rgbs_of(colour)], axis=0)
    plate = shade_distance(pixels, PLATE_RGB, PLATE_SHADES)
    fit = np.clip(1.0 - wire / (2 * TOLERANCE), 0.0, 1.0)
    contrast = np.clip((plate - wire) / TOLERANCE + 0.5, 0.0, 1.0)
    likelihood = (fit * contrast).astype(np.float32)
    floor = min(float(np.median(likelihood)), MAX_FLOOR)
    return np.clip((likelihood - floor) / (1.0 - floor), 0.0, 1.0)


def shade_distance(
    pixels: npt.NDArray[np.float32], colour: Rgb, shades: tuple[float, float]
) -> Array:
    """Return each pixel's distance to the nearest shade of a colour [grey levels]."""
    full = np.array(colour, np.float32) * 255
    shade = np.clip(pixels @ full / float(full @ full), *shades)
    return np.linalg.norm(pixels - shade[..., None] * full, axis=-1)


def ferrule_mask(rgb: npt.NDArray[np.uint8]) -> Mask:
    """Return the pixels of the ferrules' colour as 0 and 1."""
    hsv = cv2.cvtColor(rgb, cv2.COLOR_RGB2HSV)
    low = np.array([FERRULE_HUES[0], FERRULE_MIN_SATURATION, FERRULE_MIN_VALUE])
    high = np.array([FERRULE_HUES[1], 255, 255])
    return np.asarray(cv2.inRange(hsv, low, high) // 255, np.uint8)
