"""The calibration finds camera and board again from pictures of known views."""

import cv2
import numpy as np
import pytest
import yaml

from remodel_robot.calibration import Board, CalibrationError, Lens, View, calibrate, transform
from remodel_robot.commands.calibrate import main, matrix_of, pose_of

BOARD = Board(7, 5, 0.03, 0.022)
SIZE = (960, 720)
LENS = Lens(np.array([[900.0, 0, 480], [0, 900, 360], [0, 0, 1]]), np.zeros(5))
PIXELS_PER_M = 8000.0

# flange_from_camera and base_from_board: what is to be found.
CAMERA = transform(cv2.Rodrigues(np.array([0.05, -0.03, 1.5]))[0], np.array([0.05, -0.02, 0.08]))
PLACE = transform(cv2.Rodrigues(np.array([0.0, 0.0, 0.4]))[0], np.array([0.5, 0.1, 0.02]))


def picture(camera_from_board):
    """Return the board as a camera without distortion sees it."""
    width, height = BOARD.columns * BOARD.square_m, BOARD.rows * BOARD.square_m
    flat = BOARD.pattern().generateImage(
        (round(width * PIXELS_PER_M), round(height * PIXELS_PER_M)), marginSize=0
    )
    corners = np.array([[0, 0, 0], [width, 0, 0], [width, height, 0], [0, height, 0]])
    rotation = cv2.Rodrigues(camera_from_board[:3, :3])[0]
    seen, _ = cv2.projectPoints(
        corners, rotation, camera_from_board[:3, 3], LENS.matrix, LENS.distortion
    )
    # A pixel's coordinates are those of its middle.
    on_flat = corners[:, :2] * PIXELS_PER_M - 0.5
    warp = cv2.getPerspectiveTransform(
        on_flat.astype(np.float32), seen.reshape(4, 2).astype(np.float32)
    )
    drawn = cv2.warpPerspective(flat, warp, SIZE, flags=cv2.INTER_AREA, borderValue=255)
    return cv2.GaussianBlur(drawn, (3, 3), 0)


def views(turns):
    """Return a view for each rotation vector [rad] of the camera against the board."""
    found = []
    middle = np.array([BOARD.columns * BOARD.square_m / 2, BOARD.rows * BOARD.square_m / 2, 0])
    for number, turn in enumerate(turns):
        rotation = cv2.Rodrigues(np.array(turn, float))[0]
        camera_from_board = transform(rotation, np.array([0, 0, 0.35]) - rotation @ middle)
        base_from_flange = PLACE @ np.linalg.inv(camera_from_board) @ np.linalg.inv(CAMERA)
        found.append(View(f"{number}.png", picture(camera_from_board), base_from_flange))
    return found


TURNS = [
    *([0, 0, 0], [0.35, 0, 0], [-0.35, 0.1, 0], [0, 0.4, 0.2], [0, -0.4, -0.3]),
    *([0.3, 0.3, 0.6], [-0.25, 0.3, -0.5]),
]


def difference(left, right):
    """Return the distance [m] and the angle [rad] between two transforms."""
    apart = np.linalg.inv(left) @ right
    return np.linalg.norm(apart[:3, 3]), np.linalg.norm(cv2.Rodrigues(apart[:3, :3])[0])


def test_camera_and_board_are_found_from_pictures():
    result = calibrate(views(TURNS), BOARD, LENS)
    for found, true in ((result.flange_from_camera, CAMERA), (result.base_from_board, PLACE)):
        distance_m, angle_rad = difference(found, true)
        assert distance_m < 0.001
        assert angle_rad < 0.005
    assert [each.view for each in result.residuals] == [f"{n}.png" for n in range(len(TURNS))]
    assert max(each.reprojection_px for each in result.residuals) < 0.5
    assert max(each.position_m for each in result.residuals) < 0.001


def test_a_board_that_moved_shows_in_the_residual_of_its_view():
    seen = views(TURNS)
    moved = transform(np.eye(3), np.array([0.01, 0, 0]))
    seen[3] = View(seen[3].name, seen[3].picture, moved @ seen[3].base_from_flange)
    residuals = calibrate(seen, BOARD, LENS).residuals
    assert max(residuals, key=lambda each: each.position_m).view == "3.png"
    assert residuals[3].position_m > 0.002


def test_views_without_the_board_are_named():
    blank = View("blank.png", np.full(SIZE[::-1], 255, np.uint8), np.eye(4))
    assert calibrate([*views(TURNS), blank], BOARD, LENS).unused == ("blank.png",)
    with pytest.raises(CalibrationError, match=r"4 of 5 views .*; needed: 5. Without: blank.png"):
        calibrate([*views(TURNS[:4]), blank], BOARD, LENS)


def test_rotations_about_one_axis_are_not_enough():
    with pytest.raises(CalibrationError, match="needed: turn it about two axes"):
        calibrate(views([[0.15 * n, 0, 0] for n in range(-2, 3)]), BOARD, LENS)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ((2, 5, 0.03, 0.02), "needed: at least 3 x 3"),
        ((7, 5, 0.03, 0.03), "0 < marker < square"),
        ((7, 5, 0.03, 0.02, "DICT_NONE"), "'DICT_NONE'; allowed are OpenCV's"),
    ],
)
def test_impossible_boards_are_refused(values, said):
    with pytest.raises(CalibrationError, match=said):
        Board(*values)


@pytest.fixture
def files(tmp_path):
    """Return the file of the views, and its document, to be changed."""
    rows = []
    for view in views(TURNS):
        cv2.imwrite(str(tmp_path / view.name), view.picture)
        rows.append({"picture": view.name, "base_from_flange": pose_of(view.base_from_flange)})
    document = {
        "board": {"columns": 7, "rows": 5, "square_m": 0.03, "marker_m": 0.022},
        "camera": {"K": LENS.matrix.ravel().tolist(), "D": [0.0] * 5},
        "views": rows,
    }
    file = tmp_path / "views.yaml"
    file.write_text(yaml.safe_dump(document))
    return file, document


def test_the_command_writes_poses_and_residuals(files, tmp_path, capsys):
    output = tmp_path / "calibration.yaml"
    # The panel's frame lies 0.1 m along the first row.
    panel = ["--board-from-panel", "0.1", "0", "0", "0", "0", "0", "1"]
    assert main([str(files[0]), "--output", str(output), *panel]) == 0
    written = yaml.safe_load(output.read_text())
    assert difference(matrix_of(written["flange_from_camera"]), CAMERA)[0] < 0.001
    expected = PLACE @ transform(np.eye(3), np.array([0.1, 0, 0]))
    assert difference(matrix_of(written["base_from_panel"]), expected)[0] < 0.001
    assert len(written["residuals"]) == len(TURNS)
    assert "0.png: 0." in capsys.readouterr().out


def test_a_view_too_far_from_the_others_is_refused_and_nothing_is_written(files, tmp_path, capsys):
    file, document = files
    document["views"][3]["base_from_flange"][0] += 0.01
    file.write_text(yaml.safe_dump(document))
    output = tmp_path / "calibration.yaml"
    assert main([str(file), "--output", str(output)]) == 1
    assert "3.png is " in capsys.readouterr().err
    assert not output.exists()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda d: d.pop("camera"), "no camera; needed: board, camera, views"),
        (lambda d: d["board"].update(colour=1), "unexpected keyword argument 'colour'"),
        (lambda d: d["views"][0].update(picture="none.png"), "none.png cannot be read"),
        (lambda d: d["views"][0].update(base_from_flange=[0] * 7), "of length 1"),
        (lambda d: d["camera"].update(K=[1, 2]), "cannot reshape array of size 2"),
    ],
)
def test_a_file_with_a_mistake_is_refused_with_what_is_needed(files, capsys, change, said):
    file, document = files
    change(document)
    file.write_text(yaml.safe_dump(document))
    assert main([str(file), "--output", "none.yaml"]) == 1
    assert said in capsys.readouterr().err


def test_poses_return_from_their_numbers():
    assert np.allclose(matrix_of(pose_of(CAMERA)), CAMERA, atol=1e-7)
