"""Recognise the labels of a panel's components in a picture.

OpenCV finds dark squares. Which label a square is, if any, is decided among the panel's own ones
only, by the correlation of the grey levels in its sixteen cells with each label in each of its four
turns. So neither a blurred cell nor the outline of a housing becomes a label that the panel lacks.

A label that something lies across is no square. Where one is expected, its drawing is searched for.
"""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
import numpy.typing as npt

from remodel_vision.colour import Pixels
from remodel_work.camera import Picture
from remodel_work.component_shape import LABEL_CELLS, label_corners, marker_cells
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Component

# The detector samples cells of 3 px badly: it gets a picture this much larger.
ENLARGED = 2
# Two labels of the dictionary differ in at least 3 of their 16 cells, hence by a correlation of
# 0.63 or less.
ALIKE = 0.8
# A square's sides differ by no more from what the label would measure on an upright component.
SIDE_TOLERANCE = 0.3
# Squares whose middles are further apart than this share of their side are not the same.
SAME_PLACE = 0.5
# The border of a label is darker than this share of the way from its black to its white cells.
DARK_BORDER = 0.35
# Least difference of white and black cells [grey levels].
MIN_CONTRAST = 15.0
# Around where a label is expected it is searched this far [m], in these turns [rad].
SEARCH_M = 0.03
TURNS = np.radians(np.arange(-15.0, 15.1, 3.0))
# A search uses cells of so many pixels.
SEARCH_CELL_PX = 4.0
SEARCH_FINE = 4  # samples of the drawing per cell
# What is found has this correlation with the drawing, and no more cells on the wrong side of the
# middle between white and black: labels differ in at least 3.
MATCH, MOST_WRONG_CELLS = 0.5, 2
# Where a cell is sampled, from its middle [cells]: blur mixes its rim with its neighbours.
INNER = np.array([-0.25, 0.0, 0.25])


def find_labels(picture: Picture, components: Iterable[Component]) -> dict[int, Array]:
    """Return the corners (4, 2) of the labels that are seen, by id, to a pixel or two.

    Their order is that of label_corners.

    A label that is seen in two places is left out: one of them belongs to a stranger.
    """
    grey = cv2.cvtColor(picture.rgb, cv2.COLOR_RGB2GRAY)
    squares = _squares(grey)
    if not len(squares):
        return {}
    cells = _cells(grey, squares)
    sides = np.linalg.norm(squares - np.roll(squares, 1, axis=1), axis=2)
    found = {}
    for component in components:
        height = float(label_corners(component)[0, 2])
        expected = component.marker_size / picture.view.metres_per_pixel(height)
        fits = np.all(np.abs(sides / expected - 1) < SIDE_TOLERANCE, axis=1)
        alike, turns = _likeness(cells, component.marker_id)
        alike = np.where(fits, alike, 0.0)
        best = int(np.argmax(alike))
        places = squares[alike >= ALIKE].mean(axis=1)
        apart = np.linalg.norm(places - squares[best].mean(axis=0), axis=1)
        if len(places) and np.all(apart < SAME_PLACE * expected):
            found[component.marker_id] = np.roll(squares[best], -int(turns[best]), axis=0)
    return found


def search_label(picture: Picture, component: Component, near: Pose) -> Array | None:
    """Return the corners (4, 2) [px] of a label that is partly covered; None if it is not there.

    Args:
        picture: from above.
        component: whose label is searched for.
        near: about where the component stands, world frame.
    """
    grey = cv2.cvtColor(picture.rgb, cv2.COLOR_RGB2GRAY)
    model = label_corners(component)
    height = float(model[0, 2])
    reach = SEARCH_M + component.marker_size
    x, y, _ = near.position
    window = np.array([[x - reach, y - reach], [x + reach, y + reach]])
    seen = picture.view.project(np.column_stack([window, np.full(2, height)]))
    low = np.clip(np.floor(seen.min(axis=0)), 0, None).astype(int)
    high = np.ceil(seen.max(axis=0)).astype(int)
    part = grey[low[1] : high[1], low[0] : high[0]]
    cell = component.marker_size / LABEL_CELLS / picture.view.metres_per_pixel(height)
    scale = SEARCH_CELL_PX / cell
    part = cv2.resize(part, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    best, corners = 0.0, None
    for turn in TURNS:
        turned = Pose.level(x, y, 0.0, near.yaw + turn).apply(model)
        square = (picture.view.project(turned) - low + 0.5) * scale - 0.5
        tile, offset = _tile(component.marker_id, square)
        if min(np.array(part.shape) - tile.shape) < 0:
            return None
        match = cv2.matchTemplate(part, tile, cv2.TM_CCOEFF_NORMED)
        _, most, _, place = cv2.minMaxLoc(match)
        if most > best:
            best = most
            corners = (square - offset + place + 0.5) / scale - 0.5 + low
    if corners is None or best < MATCH:
        return None
    true = marker_cells(component.marker_id) > 0
    cells = _cells(grey, corners[None])[0]
    middle = (np.median(cells[true]) + np.median(cells[~true])) / 2
    wrong = ((cells > middle) != true)[1:-1, 1:-1]
    return corners if np.count_nonzero(wrong) <= MOST_WRONG_CELLS else None


def _tile(marker_id: int, square: Array) -> tuple[Pixels, Array]:
    """Return a label drawn at corners (4, 2), as a picture, and the place of that in theirs."""
    low = np.floor(square.min(axis=0))
    wide, high = (np.ceil(square.max(axis=0)) - low + 1).astype(int).tolist()
    flat = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * LABEL_CELLS * SEARCH_FINE - 0.5
    to_tile = cv2.getPerspectiveTransform(
        flat.astype(np.float32), (square - low).astype(np.float32)
    )
    drawing = np.kron(marker_cells(marker_id), np.ones((SEARCH_FINE, SEARCH_FINE), np.uint8))
    tile = cv2.warpPerspective(
        drawing, to_tile, (wide, high), flags=cv2.INTER_AREA, borderValue=(255,)
    )
    return tile, low


def _squares(grey: Pixels) -> Array:
    """Return the corners (n, 4, 2) [px] of what may be labels, clockwise."""
    parameters = cv2.aruco.DetectorParameters()
    parameters.minMarkerPerimeterRate = 0.02
    # Else only the outermost of squares within each other is reported.
    parameters.minMarkerDistanceRate = 0.0
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_250)
    detector = cv2.aruco.ArucoDetector(dictionary, parameters)
    large = cv2.resize(grey, None, fx=ENLARGED, fy=ENLARGED, interpolation=cv2.INTER_CUBIC)
    labels, _, others = detector.detectMarkers(large)
    squares = np.array([*labels, *others], np.float64).reshape(-1, 4, 2)
    # Whole numbers are the centres of pixels.
    return (squares + 0.5) / ENLARGED - 0.5


def _cells(grey: Pixels, squares: Array) -> Array:
    """Return the mean grey levels (n, 6, 6) in the cells of squares (n, 4, 2)."""
    middles = np.arange(LABEL_CELLS) + 0.5
    along = (middles[:, None] + INNER).ravel()
    column, row = np.meshgrid(along, along)
    grid = np.column_stack([column.ravel(), row.ravel()]).astype(np.float32)
    flat = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32) * LABEL_CELLS
    maps = np.array(
        [
            cv2.perspectiveTransform(
                grid[None], cv2.getPerspectiveTransform(flat, square.astype(np.float32))
            )[0]
            for square in squares
        ]
    )
    levels = cv2.remap(
        grey, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    shape = (len(squares), LABEL_CELLS, len(INNER), LABEL_CELLS, len(INNER))
    return np.asarray(levels.reshape(shape).mean(axis=(2, 4)), np.float64)


def _likeness(cells: Array, marker_id: int) -> tuple[Array, npt.NDArray[np.intp]]:
    """Return how well cells (n, 6, 6) fit a label, at most 1, and its best quarter turns, (n,)."""
    true = marker_cells(marker_id)[1:-1, 1:-1] > 0
    inner = cells[:, 1:-1, 1:-1]
    border = np.ones(cells.shape[1:], bool)
    border[1:-1, 1:-1] = False
    lightest = np.quantile(cells[:, border], 0.75, axis=1)
    scores = []
    for turn in range(4):
        model = np.rot90(true, -turn)
        white, black = inner[:, model].mean(axis=1), inner[:, ~model].mean(axis=1)
        contrast = white - black
        deviation = np.where(model, white[:, None, None], black[:, None, None]) - inner
        spread = inner - inner.mean(axis=(1, 2), keepdims=True)
        unexplained = np.sum(deviation**2, axis=(1, 2)) / np.maximum(
            np.sum(spread**2, axis=(1, 2)), 1e-9
        )
        good = (contrast > MIN_CONTRAST) & (lightest < black + DARK_BORDER * contrast)
        scores.append(np.where(good, np.sqrt(np.maximum(1 - unexplained, 0.0)), 0.0))
    stacked = np.array(scores)
    return stacked.max(axis=0), np.argmax(stacked, axis=0)
