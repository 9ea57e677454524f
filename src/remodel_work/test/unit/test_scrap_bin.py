"""Where a robot's scrap bin stands."""

import dataclasses
import math

import pytest
from panels import panel
from refusals import refused

from remodel_states.core.codes import Code
from remodel_work.cell.cell_design import bin_of
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD
from remodel_work.robot.arm import ToolPose


@pytest.mark.parametrize("name", ["one_panda", "one_iiwa", "two_pandas"])
@pytest.mark.parametrize("small", [(0.40, 0.70), None])
def test_each_robot_has_a_bin_in_reach_beside_any_plate(name, small):
    design = read_cell(name)
    size = (*(small or design.takes.plate), 0.003)
    for robot in design.robots:
        place = bin_of(robot, panel(size=size))
        assert robot.arm.reaches(place)
        assert abs(place.y) > size[1] / 2 + 0.05 and place.y * robot.home.y > 0


def test_beside_a_plate_that_is_turned_the_bin_is_beyond_its_longer_side_too():
    robot = read_cell().robots[0]
    turned = BOARD @ Pose.level(0.0, 0.0, 0.0, math.pi / 2)
    place = bin_of(robot, panel(size=(0.7, 0.4, 0.003), world_from_panel=turned))
    assert abs(place.y) > 0.7 / 2 + 0.05


def test_the_cells_file_may_name_the_bins_place():
    robot = read_cell().robots[0]
    place = ToolPose(0.3, 0.5, 0.2, 0.0)
    assert bin_of(dataclasses.replace(robot, scrap_bin=place), panel()) == place


def test_a_bin_out_of_reach_is_refused():
    robot = read_cell().robots[0]
    with refused(Code.UNREACHABLE, "scrap_bin"):
        bin_of(robot, panel(size=(0.4, 2.0, 0.003)))
