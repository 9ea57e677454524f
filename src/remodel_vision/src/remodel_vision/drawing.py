"""Draw what was found into a picture, for people."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from remodel_work.camera import View
from remodel_work.geometry import Array, Pose

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
        """Copy the picture."""
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
