import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from panels import panel

from remodel_work.cell.cell_design import find_panel_problems, held_panel
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import CellFileError
from remodel_work.panel import BOARD

CELLS = Path(__file__).parents[3] / "remodel_work/config/cells"
MAGAZINE = yaml.safe_load((CELLS / "cabinet.yaml").read_text())["magazine"]
LARGE = read_cell("large_cabinet")
AXIS = {"along": "y", "lower": -0.4, "upper": 0.4, "speed": 1.0}
FINGERS = yaml.safe_load((CELLS / "cabinet.yaml").read_text())["robots"][0]["gripper"]["fingers"]


def parsed():
    return yaml.safe_load((CELLS / "one_panda.yaml").read_text())


def problems(tmp_path, change):
    """Return what is wrong with the first cell once it has been changed."""
    cell = parsed()
    change(cell)
    file = tmp_path / "mine.yaml"
    file.write_text(yaml.safe_dump(cell))
    with pytest.raises(CellFileError, match=r"mine\.yaml") as caught:
        read_cell(str(file))
    return caught.value.problems


def read_changed(tmp_path, **fields):
    """Return the first cell as it is read with other fields."""
    file = tmp_path / "mine.yaml"
    file.write_text(yaml.safe_dump({**parsed(), **fields}))
    return read_cell(str(file))


def with_robot(part=None, **fields):
    """Return a change of fields of the first robot, or of a part of it."""

    def change(cell):
        robot = cell["robots"][0]
        (robot[part] if part else robot).update(fields)

    return change


def doubled(cell):
    """Have a cell's first robot stand there twice."""
    cell["robots"].append(cell["robots"][0])


def with_fingers(**fields):
    return with_robot("gripper", fingers={**FINGERS, **fields})


@pytest.mark.parametrize("name", sorted(path.stem for path in CELLS.glob("*.yaml")))
def test_every_cell_of_the_package_can_be_read(name):
    assert read_cell(name).name == name


def test_a_cell_has_labels_unless_it_says_otherwise(tmp_path):
    assert read_cell().labels
    assert not read_changed(tmp_path, labels=False).labels
    (problem,) = problems(tmp_path, lambda cell: cell.update(labels="no"))
    assert "labels" in problem and "'no'" in problem


def test_a_board_lies_where_the_cell_says(tmp_path):
    board = read_changed(tmp_path, board={"x": 0.6, "y": -0.1, "yaw_deg": 4}).world_from_panel
    assert board.apply(np.array([0.1, 0.0, 0.0])) == pytest.approx([0.69976, -0.09302, 0.0], 1e-4)
    assert read_cell().world_from_panel == BOARD
    (problem,) = problems(tmp_path, lambda cell: cell.update(board={"x": 0.6}))
    assert "board" in problem and "missing: y" in problem


def test_a_cell_of_ones_own_is_read_from_its_path(tmp_path):
    assert read_changed(tmp_path, name="mine").name == "mine"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c.pop("table"), "the file: found .*; missing: table"),
        (lambda c: c.pop("feeder"), "feeder, magazine: found none; allowed: one of them"),
        (
            lambda c: c.update(magazine=MAGAZINE),
            "feeder, magazine: found both; allowed: one of them",
        ),
        (
            lambda c: (
                c["takes"].update(wire_length={"least": 0.2, "most": 3})
                or c.update(magazine=MAGAZINE)
            ),
            r"takes.wire_length.least: found 0.2 m; allowed: 0.238 m or more, since the magazine",
        ),
        (
            lambda c: c["takes"].pop("plate"),
            "takes: found devices, wire_diameter, wire_length; missing: plate",
        ),
        (
            lambda c: c.update(magazine={**MAGAZINE, "y_min": 0.0}),
            r"magazine: y_min 0.000 to y_max 0.400 m; a wire with a span of 0.460 m needs as much",
        ),
        (
            lambda c: c["cameras"].update(front={}),
            "cameras: found front; allowed: overhead, scene",
        ),
        (lambda c: c.update(robots=[]), r"robots: found \[\]; allowed: 1 entries or more"),
        (
            lambda c: c.update(robots=c["robots"] * 3),
            "robots: found .*; allowed: 2 entries or fewer",
        ),
        (lambda c: c.update(name="2 arms"), "name: found '2 arms'; allowed: text that matches"),
        (
            lambda c: c["fixtures"]["ducts"].append(
                {"id": "D", "pose": [0, 0, 0], "length": 0, "width": 0.04, "height": 0.02}
            ),
            r"fixtures.ducts\[0\].length: found 0; allowed: more than 0",
        ),
        (
            lambda c: c.update(board={"x": 0.5, "y": 0.0, "yaw_deg": 90.0}),
            "board.yaw_deg: found 90; allowed: within 5 of 0, since the feeder lays wires along y",
        ),
        (
            lambda c: c.update(board={"x": 0.5, "y": 0.0, "yaw_deg": -5.2}),
            "board.yaw_deg: found -5.2; allowed: within 5 of 0",
        ),
        (doubled, "robots: 2 have name 'robot_1'; each needs its own"),
        (doubled, "are 0.00 m apart; allowed: 0.50 m or more"),
    ],
)
def test_what_is_wrong_is_reported_with_its_place_what_was_found_and_what_is_allowed(
    tmp_path, change, words
):
    found = problems(tmp_path, change)
    assert any(re.search(words, problem) for problem in found), found


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (with_robot(arm="ur5"), "arm: found 'ur5'; allowed: franka_panda, kuka_iiwa"),
        (with_robot("base", x="near"), "base.x: found 'near'; allowed: a value of type number"),
        (with_robot("base", x=float("nan")), "base.x: found nan; allowed: a finite number"),
        (
            with_robot("gripper", grip_force=500.0),
            "gripper.grip_force: found 500.0; allowed: 70 or less",
        ),
        (with_robot("gripper", grip_force=-1), "gripper.grip_force: found -1; allowed: 10 or more"),
        (with_robot("home", x=2.0), "home: no arm posture reaches x 2000"),
        (
            with_robot(scrap_bin={"x": 0.4, "y": 0.5, "z": 0.15, "yaw_deg": 90.0}),
            r"scrap_bin: found x 0.400, y 0.500 m; allowed: 0.05 m or more beside the .* 1.00 m",
        ),
        (
            with_robot(limits={"lower_deg": [-170] * 7, "upper_deg": [170] * 7}),
            "limits: joint 1 has -2.9671 to 2.9671 rad; allowed within -2.8973",
        ),
        (with_robot(arm="portal"), ": found .*; missing: travel"),
        (with_robot(axis={**AXIS, "along": "z"}), "axis.along: found 'z'; allowed: y"),
        (
            with_robot(axis={**AXIS, "lower": 0.5}),
            "axis: found lower 0.5, upper 0.4; allowed: lower less than upper",
        ),
        (with_fingers(opening=0.2), "gripper.fingers.opening: found 0.2; allowed: 0.08 or less"),
        (
            with_fingers(eyelet={**FINGERS["eyelet"], "above": 0.005}),
            "gripper.fingers.eyelet.above: found 0.005; allowed: 0.0084 or more",
        ),
        (
            with_fingers(pad_height=0.008),
            "gripper.fingers.pad_height: found 0.008; allowed: 0.0244 or more",
        ),
        (
            with_fingers(length=0.05, pad_height=0.06),
            "gripper.fingers.pad_height: found 0.06; allowed: up to the length",
        ),
    ],
)
def test_what_is_wrong_with_a_robot_is_reported_with_its_place(tmp_path, change, words):
    found = problems(tmp_path, change)
    assert any(re.search(rf"robots\[0\]\.?{words}", problem) for problem in found), found


def test_all_problems_are_reported_at_once(tmp_path):
    def change(cell):
        cell["robots"][0]["arm"] = "ur5"
        cell["feeder"]["overlap"] = 1.0

    assert len(problems(tmp_path, change)) == 2


def test_the_cells_own_fixtures_are_built_with_every_panel(tmp_path):
    duct = {"id": "D", "pose": [0, 0, 90], "length": 0.3, "width": 0.04, "height": 0.02}
    design = read_changed(tmp_path, fixtures={"clips": [], "ducts": [duct]})
    assert [built.id for built in held_panel(design, panel()).ducts] == ["D"]
    assert find_panel_problems(design, panel()) == ()


def test_an_unknown_cell_names_those_there_are():
    with pytest.raises(CellFileError, match=r"there are: .*one_panda"):
        read_cell("three_pandas")


def test_a_file_that_is_no_yaml_says_where(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("robots: [")
    with pytest.raises(CellFileError, match="line 1"):
        read_cell(str(file))


def test_more_cameras_above_the_plate_are_named_in_turn(tmp_path):
    assert LARGE.overhead_names[:3] == ("overhead", "overhead_2", "overhead_3")
    assert len(LARGE.overhead_names) == len(LARGE.overheads) == 6
    assert read_cell().overhead_names == ("overhead",)
    (problem,) = problems(
        tmp_path, lambda cell: cell["cameras"]["overhead"].update(also_at=[{"x": 1.0, "y": 0.0}])
    )
    assert "cameras.overhead.also_at[0]: found x, y; missing: z" in problem


def test_a_cell_takes_more_devices_than_there_are_labels_only_without_labels(tmp_path):
    assert LARGE.takes.devices > 250 and not LARGE.labels
    (problem,) = problems(tmp_path, lambda cell: cell["takes"].update(devices=251))
    assert problem == (
        "takes.devices: found 251; allowed: up to 250, as many as there are labels, or "
        "labels: false"
    )
    assert parsed()["takes"]["devices"] == 250
