"""Calibrate the camera on the wrist and the panel from views of a ChArUco board."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from remodel_robot.core.calibration import calibrate
from remodel_robot.edge.view_files import matrix_of, pose_of, read_views, write_calibration
from remodel_robot.errors import CalibrationError


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
