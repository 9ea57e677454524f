"""Calibrate the camera on the wrist and the panel from views of a ChArUco board."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml

from remodel_robot.calibration import (
    Array,
    Board,
    Calibration,
    CalibrationError,
    Lens,
    View,
    calibrate,
    transform,
)

_KEYS = ("board", "camera", "views")
_POSE = "[x, y, z, qx, qy, qz, qw], metres and a quaternion"


def read_views(file: Path) -> tuple[list[View], Board, Lens]:
    """Return the views that a file lists, the board and the lens; docs/real-cell/drivers.md.

    Raises:
        CalibrationError: naming the file and the key.
    """
    try:
        document = yaml.safe_load(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, yaml.YAMLError) as error:
        raise CalibrationError(f"{file}: cannot be read: {error}") from error
    missing = [key for key in _KEYS if not isinstance(document, dict) or key not in document]
    if missing:
        raise CalibrationError(f"{file}: no {', '.join(missing)}; needed: {', '.join(_KEYS)}")
    try:
        board = Board(**document["board"])
        camera = document["camera"]
        matrix = np.array(camera["K"], float).reshape(3, 3)
        lens = Lens(matrix, np.array(camera["D"], float).reshape(5))
        views = [_view(file.parent, row) for row in document["views"]]
    except (KeyError, TypeError, ValueError) as error:
        raise CalibrationError(
            f"{file}: {type(error).__name__}: {error}; needed: board {{columns, rows, square_m, "
            "marker_m, dictionary}, camera {K: 9 numbers, D: 5 numbers}, views "
            f"[{{picture, base_from_flange: {_POSE}}}]"
        ) from error
    return views, board, lens


def write_calibration(file: Path, result: Calibration, panel: Array) -> None:
    """Write what static transforms need: x, y, z [m], and a quaternion x, y, z, w.

    Args:
        file: to write, as YAML.
        result: camera, board and residuals.
        panel: (4, 4) base_from_panel [m].
    """
    document = {
        "flange_from_camera": pose_of(result.flange_from_camera),
        "base_from_board": pose_of(result.base_from_board),
        "base_from_panel": pose_of(panel),
        "residuals": [
            {
                "view": each.view,
                "reprojection_px": round(each.reprojection_px, 3),
                "position_mm": round(1000 * each.position_m, 3),
                "angle_deg": round(float(np.degrees(each.angle_rad)), 4),
            }
            for each in result.residuals
        ],
    }
    file.write_text(yaml.safe_dump(document, sort_keys=False), encoding="utf-8")


def pose_of(matrix: Array) -> list[float]:
    """Return a (4, 4) transform as x, y, z [m], qx, qy, qz, qw."""
    turn = cv2.Rodrigues(matrix[:3, :3])[0].ravel()
    angle = float(np.linalg.norm(turn))
    axis = turn / angle if angle else turn
    quaternion = [*(np.sin(angle / 2) * axis), np.cos(angle / 2)]
    return [round(float(value), 9) for value in (*matrix[:3, 3], *quaternion)]


def matrix_of(pose: list[float]) -> Array:
    """Return the (4, 4) transform of x, y, z [m], qx, qy, qz, qw.

    Raises:
        ValueError: if it has other than seven numbers, or the quaternion has no length of 1.
    """
    values = np.array(pose, float)
    length = float(np.linalg.norm(values[3:]))
    if values.shape != (7,) or abs(length - 1.0) > 1e-3:
        raise ValueError(f"pose {pose} found; needed: {_POSE} of length 1")
    vector, cosine = values[3:6], values[6]
    sine = float(np.linalg.norm(vector))
    turn = vector / sine * 2.0 * np.arctan2(sine, cosine) if sine else vector
    return transform(cv2.Rodrigues(turn)[0], values[:3])


def _view(folder: Path, row: Mapping[str, Any]) -> View:
    path = folder / row["picture"]
    picture = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if picture is None:
        raise ValueError(f"picture {path} cannot be read")
    return View(row["picture"], picture.astype(np.uint8), matrix_of(row["base_from_flange"]))


def main(words: Sequence[str]) -> int:
    """Print residuals and poses, write them, and return the exit code."""
    options = _arguments(words)
    try:
        result = calibrate(*read_views(options.views))
        panel = result.base_from_board @ matrix_of(options.board_from_panel)
        for each in result.residuals:
            print(
                f"{each.view}: {each.reprojection_px:.2f} px, {1000 * each.position_m:.2f} mm, "
                f"{np.degrees(each.angle_rad):.3f} deg"
            )
        for name in result.unused:
            print(f"{name}: not used, too few corners of the board found")
        print(f"flange_from_camera: {pose_of(result.flange_from_camera)}")
        print(f"base_from_panel: {pose_of(panel)}")
        worst = max(result.residuals, key=lambda each: each.position_m)
        if 1000 * worst.position_m > options.most_mm:
            raise CalibrationError(
                f"{worst.view} is {1000 * worst.position_m:.2f} mm from the mean, allowed: "
                f"{options.most_mm:g} mm; nothing was written. Check that the board has not moved, "
                "the size of its squares, the lens, and that the robot stood when the picture was "
                "taken"
            )
        write_calibration(options.output, result, panel)
    except (CalibrationError, ValueError, OSError) as error:
        sys.stderr.write(f"calibrate: {error}\n")
        return 1
    print(f"wrote: {options.output}")
    return 0


def _arguments(words: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        "calibrate",
        description=__doc__,
        epilog="Exit code: 0 written, 1 refused (nothing is written), 2 usage error.",
    )
    parser.add_argument("views", type=Path, help="views.yaml (docs/real-cell/drivers.md)")
    parser.add_argument("--output", type=Path, required=True, metavar="FILE.yaml")
    parser.add_argument(
        "--board-from-panel",
        type=float,
        nargs=7,
        default=[0, 0, 0, 0, 0, 0, 1],
        metavar=("X", "Y", "Z", "QX", "QY", "QZ", "QW"),
        help="where the panel's frame is on the board [m] (default: the board's own frame)",
    )
    parser.add_argument(
        "--most-mm",
        type=float,
        default=1.0,
        metavar="MM",
        help="largest distance of a view from the mean [mm] (default: 1)",
    )
    return parser.parse_args(list(words))
