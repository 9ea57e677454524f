"""Colours of pixels, and findings drawn into a picture, for people."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from remodel_states.core.wires import Rgb, rgbs_of
from remodel_work.camera import View
from remodel_work.component_shape import PLATE_RGB
from remodel_work.geometry import Array, Pose

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


Image = npt.NDArray[np.uint8]

GREEN = (30, 170, 60)
BLUE = (20, 110, 230)
ORANGE = (240, 120, 0)
RED = (215, 30, 30)
INK = (25, 30, 35)
PAPER = (250, 250, 250)
SHIFT = 4  # sub-pixel bits of OpenCV's drawing functions
AXIS_M = 0.02


class Drawing:
    """An annotated copy of a picture; sizes follow its resolution."""

    def __init__(self, rgb: Image, view: View) -> None:
        self.image = rgb.copy()
        self.view = view
        self._unit = max(1.0, rgb.shape[0] / 480)

    def outline(self, corners: Array, colour: tuple[int, int, int] = GREEN) -> None:
        """Draw a closed polygon (n, 2) [px]."""
        self._lines(corners, colour, closed=True)

    def path(self, points: Array, colour: tuple[int, int, int] = BLUE) -> None:
        """Draw a polyline (n, 2) [px]."""
        self._lines(points, colour, closed=False)

    def arrow(self, start: Array, end: Array, colour: tuple[int, int, int]) -> None:
        """Draw an arrow between two pixels, (2,) each."""
        a, b = (tuple(int(v) for v in np.rint(p)) for p in (start, end))
        cv2.arrowedLine(self.image, a, b, PAPER, self._thick(3), cv2.LINE_AA, tipLength=0.35)
        cv2.arrowedLine(self.image, a, b, colour, self._thick(1.6), cv2.LINE_AA, tipLength=0.35)

    def axes(self, world_from_frame: Pose) -> None:
        """Draw a frame's x axis red and y axis green, 20 mm long."""
        ends = world_from_frame.apply(np.array([[0, 0, 0], [AXIS_M, 0, 0], [0, AXIS_M, 0]]))
        origin, x, y = self.view.project(ends)
        self.arrow(origin, x, RED)
        self.arrow(origin, y, GREEN)

    def circle(self, centre: Array, radius_px: float, colour: tuple[int, int, int]) -> None:
        """Draw a circle around a pixel, (2,)."""
        place = tuple(int(v) for v in np.rint(centre * 2**SHIFT))
        radius = int(radius_px * 2**SHIFT)
        cv2.circle(self.image, place, radius, PAPER, self._thick(3), cv2.LINE_AA, SHIFT)
        cv2.circle(self.image, place, radius, colour, self._thick(1.5), cv2.LINE_AA, SHIFT)

    def note(self, text: str, anchor: Array, colour: tuple[int, int, int] = INK) -> None:
        """Write beside a pixel (2,), in a box that stays inside the picture."""
        scale, thick = 0.42 * self._unit, self._thick(1)
        (w, h), base = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, thick)
        pad = round(4 * self._unit)
        height, width = self.image.shape[:2]
        x = int(np.clip(anchor[0] + 3 * pad, pad, max(pad, width - w - 2 * pad)))
        y = int(np.clip(anchor[1] - 3 * pad, h + pad, height - base - pad))
        corners = (x - pad, y - h - pad), (x + w + pad, y + base + pad // 2)
        cv2.rectangle(self.image, *corners, PAPER, cv2.FILLED)
        cv2.rectangle(self.image, *corners, colour, self._thick(1), cv2.LINE_AA)
        cv2.putText(
            self.image, text, (x, y), cv2.FONT_HERSHEY_SIMPLEX, scale, INK, thick, cv2.LINE_AA
        )

    def title(self, text: str) -> None:
        """Write what the picture shows into its upper left corner."""
        scale, thick = 0.55 * self._unit, self._thick(1.2)
        (w, h), base = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, thick)
        pad = round(6 * self._unit)
        cv2.rectangle(self.image, (0, 0), (w + 2 * pad, h + base + 2 * pad), INK, cv2.FILLED)
        cv2.putText(
            self.image,
            text,
            (pad, h + pad),
            cv2.FONT_HERSHEY_SIMPLEX,
            scale,
            PAPER,
            thick,
            cv2.LINE_AA,
        )

    def _lines(self, points: Array, colour: tuple[int, int, int], *, closed: bool) -> None:
        fixed = np.rint(np.asarray(points) * 2**SHIFT).astype(np.int32).reshape(-1, 1, 2)
        for tone, thickness in ((PAPER, 3.5), (colour, 1.8)):
            cv2.polylines(
                self.image, [fixed], closed, tone, self._thick(thickness), cv2.LINE_AA, SHIFT
            )

    def _thick(self, width: float) -> int:
        return max(1, round(width * self._unit))
