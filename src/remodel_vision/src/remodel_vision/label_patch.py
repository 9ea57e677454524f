"""The pixels that show a label, and what they would show if it were somewhere else."""

from __future__ import annotations

import math

import cv2
import numpy as np
import numpy.typing as npt

from remodel_vision.pixels import Pixels
from remodel_work.camera import Picture
from remodel_work.component_shape import LABEL_CELLS, LABEL_MARGIN_CELLS, marker_cells
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Component

# Samples of the drawing per cell, and white cells around its black square.
FINE = 16
MARGIN = int(LABEL_MARGIN_CELLS)
# So much of the white margin takes part [cells]: what lies beyond it blurs into its rim.
RIM_CELLS = 0.6
# So many samples are taken per cell and axis, at least, of labels that have them.
SAMPLES_PER_CELL = 6
# Pictures are blurred by this standard deviation [px]: edges sharper than a pixel are hard to move.
SMOOTH_PX = 1.0


class LabelPatch:
    """The pixels of one picture that show a label.

    Attributes:
        levels: (n,) grey levels.
        even: (n, 2) the pixels' places on the label, -0.5 to 0.5, for light that is not even.
        valid: (n,) which of them take part.
        scale: size of a sample of the drawing [m].
    """

    def __init__(self, component: Component, picture: Picture, corners: Array) -> None:
        """Cut out the label located at corners (4, 2) [px]."""
        self._size = component.marker_size
        self.scale = component.marker_size / (LABEL_CELLS * FINE)
        self._drawing = _drawing(component.marker_id)
        self._layers: dict[float, tuple[Pixels, Pixels, Pixels]] = {}
        square = corners.astype(np.float32)
        flat = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
        self._cell_px = float(np.sqrt(abs(cv2.contourArea(square)))) / LABEL_CELLS
        reach = 1.5 * RIM_CELLS * self._cell_px
        limit = np.array([picture.rgb.shape[1], picture.rgb.shape[0]]) - 1
        low = np.clip(np.floor(corners.min(axis=0) - reach), 0, limit).astype(int)
        high = np.clip(np.ceil(corners.max(axis=0) + reach), 0, limit).astype(int)
        step = max(1, int(self._cell_px / SAMPLES_PER_CELL))
        columns, rows = np.meshgrid(
            np.arange(low[0], high[0] + 1, step), np.arange(low[1], high[1] + 1, step)
        )
        pixels = np.column_stack([columns.ravel(), rows.ravel()])
        to_label = cv2.getPerspectiveTransform(square, flat)
        even = cv2.perspectiveTransform(pixels[None].astype(np.float64), to_label)[0] - 0.5
        inside = np.all(np.abs(even) < 0.5 + RIM_CELLS / LABEL_CELLS, axis=1)
        window = picture.rgb[low[1] : high[1] + 1, low[0] : high[0] + 1]
        grey = cv2.cvtColor(window, cv2.COLOR_RGB2GRAY).astype(np.float32)
        smooth = cv2.GaussianBlur(grey, (0, 0), SMOOTH_PX)
        self.even = np.asarray(even[inside], np.float64)
        self.valid = np.ones(len(self.even), bool)
        self._inside, self._shape = inside, columns.shape
        self._step = step
        self.levels = smooth[::step, ::step].ravel()[inside].astype(np.float64)
        self._eye = picture.view.world_from_camera.position
        self._rays = picture.view.on_plane(pixels[inside], self._eye[2] - 1.0) - self._eye

    def drop(self, covered: npt.NDArray[np.bool_], cells: float) -> None:
        """Let pixels (n,) that something covers, and those that near [cells], take no part."""
        image = np.zeros(self._inside.shape, np.uint8)
        image[self._inside] = covered & self.valid
        reach = 2 * max(1, round(cells * self._cell_px / self._step)) + 1
        kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
        self.valid &= cv2.dilate(image.reshape(self._shape), kernel).ravel()[self._inside] == 0

    def shown(self, blur_px: float, places: Array) -> tuple[Array, Array]:
        """Return the drawing's level (n,), from 0 to 1, and its gradient at places (n, 2).

        Args:
            blur_px: standard deviation of the lens's blur [px].
            places: as `places` returns them.
        """
        maps = places.astype(np.float32)[None]
        level, *slope = (
            cv2.remap(
                layer, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
            )[0].astype(np.float64)
            for layer in self._blurred(blur_px)
        )
        return level, np.column_stack(slope)

    def _blurred(self, blur_px: float) -> tuple[Pixels, Pixels, Pixels]:
        """Return the drawing as a lens with that blur shows it, and its gradient."""
        if blur_px not in self._layers:
            whole = math.hypot(blur_px, SMOOTH_PX) / self._cell_px * FINE
            level = cv2.GaussianBlur(self._drawing, (0, 0), whole)
            along, down = (cv2.Scharr(level, cv2.CV_32F, *way) / 32 for way in ((1, 0), (0, 1)))
            self._layers[blur_px] = level, along, down
        return self._layers[blur_px]

    def places(self, world_from_label: Pose) -> Array:
        """Return where the pixels lie on the drawing (n, 2) when the label is at a pose."""
        turn = world_from_label.rotation
        gap = world_from_label.position - self._eye
        depth = (gap @ turn[:, 2]) / (self._rays @ turn[:, 2])
        local = (self._rays * depth[:, None] - gap) @ turn[:, :2] / self._size
        cells = (local * [1.0, -1.0] + 0.5) * LABEL_CELLS + MARGIN
        return np.asarray(cells * FINE - 0.5, np.float64)


def _drawing(marker_id: int) -> Pixels:
    cells = np.pad(marker_cells(marker_id) > 0, MARGIN, constant_values=True)
    return np.kron(cells, np.ones((FINE, FINE))).astype(np.float32)
