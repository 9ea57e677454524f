"""Calibration of a camera on the wrist, and of the place of a board, from views of that board.

A ChArUco board is fixed in the cell. The camera on the wrist observes it from several poses. For
view i

    base_from_board = base_from_flange_i @ flange_from_camera @ camera_from_board_i

The first factor is the robot's, the last one is found in the picture. Hand-eye calibration finds
the two constants (Park and Martin, "Robot sensor calibration: solving AX = XB on the Euclidean
group", IEEE Transactions on Robotics and Automation 10, 1994). How far the right side differs from
view to view is the residual: it contains the errors of the robot, of the lens and of the detection.

Transforms are (4, 4) matrices, lengths in metres: `a_from_b` maps b's coordinates to a's. The frame
of the board is OpenCV's: origin at the outer corner of the first square, x along the first row, y
along the first column, z away from the viewer.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt


class CalibrationError(Exception):
    """The views cannot be used; the text says which, what was found and what to do."""


Array = npt.NDArray[np.float64]
Picture = npt.NDArray[np.uint8]

LEAST_VIEWS = 5
# Of the corners of a view: fewer determine its pose badly.
_LEAST_CORNERS = 8
# [rad] Between the axes of two rotations, and of a rotation: less leaves an axis undetermined.
_LEAST_ROTATION_RAD = math.radians(10.0)


@dataclass(frozen=True)
class Board:
    """A ChArUco board; a printed one is measured, not assumed.

    Attributes:
        columns, rows: number of squares.
        square_m: [m] side of a square.
        marker_m: [m] side of a marker.
        dictionary: name of its markers in OpenCV, such as DICT_5X5_100.

    Raises:
        CalibrationError: if there is no such board.
    """

    columns: int
    rows: int
    square_m: float
    marker_m: float
    dictionary: str = "DICT_5X5_100"

    def __post_init__(self) -> None:
        if min(self.columns, self.rows) < 3 or not 0 < self.marker_m < self.square_m:
            raise CalibrationError(
                f"board of {self.columns} x {self.rows} squares of {self.square_m} m with markers "
                f"of {self.marker_m} m; needed: at least 3 x 3, and 0 < marker < square"
            )
        if not self.dictionary.startswith("DICT_") or not hasattr(cv2.aruco, self.dictionary):
            raise CalibrationError(
                f"dictionary {self.dictionary!r}; allowed are OpenCV's, such as DICT_5X5_100"
            )

    def pattern(self) -> cv2.aruco.CharucoBoard:
        """Return the board as OpenCV's."""
        markers = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, self.dictionary))
        size = (self.columns, self.rows)
        return cv2.aruco.CharucoBoard(size, self.square_m, self.marker_m, markers)


@dataclass(frozen=True)
class View:
    """A picture, and the pose of the flange when it was taken.

    Attributes:
        name: for messages.
        picture: (height, width) grey values.
        base_from_flange: (4, 4) [m], from the robot.
    """

    name: str
    picture: Picture
    base_from_flange: Array


@dataclass(frozen=True)
class Lens:
    """Intrinsic parameters, as in sensor_msgs/CameraInfo.

    Attributes:
        matrix: (3, 3) [pixels].
        distortion: (5,) of the model plumb_bob.
    """

    matrix: Array
    distortion: Array


@dataclass(frozen=True)
class Residual:
    """How far a view is from the result.

    Attributes:
        reprojection_px: root mean square over its corners.
        position_m, angle_rad: of the board as this view finds it, from the mean of all views.
    """

    view: str
    reprojection_px: float
    position_m: float
    angle_rad: float


@dataclass(frozen=True)
class Calibration:
    """The result.

    Attributes:
        flange_from_camera: (4, 4) [m], optical frame of the camera (z forward, x right).
        base_from_board: (4, 4) [m], mean of the views.
        unused: names of the views in which too few corners were found.
    """

    flange_from_camera: Array
    base_from_board: Array
    residuals: tuple[Residual, ...]
    unused: tuple[str, ...]


def calibrate(views: Sequence[View], board: Board, lens: Lens) -> Calibration:
    """Return camera and board.

    Raises:
        CalibrationError: if too few views show the board, or the flange was turned too little.
    """
    detector = cv2.aruco.CharucoDetector(board.pattern())
    used, unused = [], []
    cameras, errors_px = [], []
    for view in views:
        found = _camera_from_board(view, detector, board, lens)
        if found is None:
            unused.append(view.name)
            continue
        used.append(view)
        cameras.append(found[0])
        errors_px.append(found[1])
    if len(used) < LEAST_VIEWS:
        raise CalibrationError(
            f"{len(used)} of {len(views)} views show at least {_LEAST_CORNERS} corners of the "
            f"board; needed: {LEAST_VIEWS}. Without: {', '.join(unused) or 'none'}. Check the "
            "board's size and dictionary, sharpness and light"
        )
    _check_rotations(used)
    flanges = [view.base_from_flange for view in used]
    rotation, translation = cv2.calibrateHandEye(
        [flange[:3, :3] for flange in flanges],
        [flange[:3, 3] for flange in flanges],
        [camera[:3, :3] for camera in cameras],
        [camera[:3, 3] for camera in cameras],
        method=cv2.CALIB_HAND_EYE_PARK,
    )
    flange_from_camera = transform(np.asarray(rotation, float), np.asarray(translation, float))
    boards = [
        flange @ flange_from_camera @ camera
        for flange, camera in zip(flanges, cameras, strict=True)
    ]
    mean = _mean(boards)
    residuals = tuple(
        Residual(
            view.name,
            error_px,
            float(np.linalg.norm(each[:3, 3] - mean[:3, 3])),
            _angle_rad(mean[:3, :3].T @ each[:3, :3]),
        )
        for view, error_px, each in zip(used, errors_px, boards, strict=True)
    )
    return Calibration(flange_from_camera, mean, residuals, tuple(unused))


def transform(rotation: Array, translation: Array) -> Array:
    """Return the (4, 4) transform of a (3, 3) rotation and a translation [m]."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, np.ravel(translation)
    return matrix


def _camera_from_board(
    view: View, detector: cv2.aruco.CharucoDetector, board: Board, lens: Lens
) -> tuple[Array, float] | None:
    """Return the pose of the board and the error of its corners [pixels], if enough are found."""
    corners, ids, _, _ = detector.detectBoard(view.picture)
    if ids is None or len(ids) < _LEAST_CORNERS:
        return None
    points = np.asarray(board.pattern().getChessboardCorners(), float)[ids.ravel()]
    found, rotation, translation = cv2.solvePnP(points, corners, lens.matrix, lens.distortion)
    if not found:
        return None
    projected, _ = cv2.projectPoints(points, rotation, translation, lens.matrix, lens.distortion)
    difference = (projected - corners).reshape(-1, 2)
    error_px = math.sqrt(float(np.mean(np.sum(difference**2, axis=1))))
    turn = np.asarray(cv2.Rodrigues(rotation)[0], float)
    return transform(turn, np.asarray(translation, float)), error_px


def _check_rotations(views: Sequence[View]) -> None:
    """Require rotations of the flange about two axes: otherwise the camera is undetermined."""
    first = views[0].base_from_flange[:3, :3]
    turns = [cv2.Rodrigues(first.T @ view.base_from_flange[:3, :3])[0].ravel() for view in views]
    turned = [turn for turn in turns if np.linalg.norm(turn) > _LEAST_ROTATION_RAD]
    axes = [turn / np.linalg.norm(turn) for turn in turned]
    least = math.sin(_LEAST_ROTATION_RAD)
    if not any(np.linalg.norm(np.cross(axes[0], axis)) > least for axis in axes[1:]):
        raise CalibrationError(
            f"{len(turned)} of {len(views)} views turn the flange by more than 10 deg against "
            f"{views[0].name}, about less than two axes; needed: turn it about two axes by 10 deg "
            "or more"
        )


def _mean(poses: Sequence[Array]) -> Array:
    """Return the mean position, and the rotation nearest to the mean of the rotations."""
    mean = np.mean(poses, axis=0)
    left, _, right = np.linalg.svd(mean[:3, :3])
    sign = np.diag([1.0, 1.0, float(np.sign(np.linalg.det(left @ right)))])
    return transform(left @ sign @ right, mean[:3, 3])


def _angle_rad(rotation: Array) -> float:
    return float(np.linalg.norm(cv2.Rodrigues(rotation)[0]))
