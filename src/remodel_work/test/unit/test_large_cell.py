"""The large cabinet's cell: its cameras, axes and magazine serve the greatest plate it takes."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from panels import example, moved_onto

from remodel_work.camera import best_view
from remodel_work.cell.cell_design import bin_of, find_panel_problems, held_panel
from remodel_work.cell.presenting import plan_presentation
from remodel_work.edge.cell_file import read_cell
from remodel_work.panel import WireEnd
from remodel_work.robot.arm import ToolPose

CELL = read_cell("large_cabinet")
SMALL = read_cell("two_arms_cabinet")
HOUSEHOLD = example("household")
# Far enough inside a picture for what stands there and for a device's outline.
INSIDE_PX = 20.0
# A device's greatest size, and how high it may stand [m].
DEVICE_M, HIGH_M = 0.10, 0.045


def corners(x, y):
    """Return the middles of boards in a plate's corners and in its middle, when it is x by y."""
    half = [(most - size) / 2 for most, size in zip((x, y), HOUSEHOLD.size, strict=False)]
    return [(0.0, 0.0), *product(*[(-each, each) for each in half])]


def plate_of(cell):
    """Return places all over the greatest plate of a cell, world frame, (n, 3) [m]."""
    x, y = (np.linspace(-size / 2, size / 2, 33) for size in cell.takes.plate)
    grid = [cell.world_from_panel.apply(np.array([i, j, 0.0])) for i, j in product(x, y)]
    return np.array(grid)


def test_every_place_of_the_plate_is_well_inside_a_picture_with_pixels_as_small_as_before():
    for point in plate_of(CELL):
        shown = CELL.overheads[best_view(CELL.overheads, point[None])]
        assert shown.sees(point[None], INSIDE_PX), point
    fine = SMALL.overheads[0].metres_per_pixel(0.0)
    assert all(view.metres_per_pixel(0.0) < 1.10 * fine for view in CELL.overheads)


def test_every_device_lies_in_one_picture_whole():
    half = DEVICE_M / 2
    around = np.array([[i * half, j * half, HIGH_M] for i in (-1, 1) for j in (-1, 1)])
    x, y = (np.linspace(half - s / 2, s / 2 - half, 25) for s in CELL.takes.plate)
    for i, j in product(x, y):
        points = CELL.world_from_panel.apply(np.array([i, j, 0.0])) + around
        assert CELL.overheads[best_view(CELL.overheads, points)].sees(points, 0.0), (i, j)


@pytest.mark.parametrize("place", corners(*CELL.takes.plate))
def test_a_board_anywhere_on_the_greatest_plate_is_taken_and_both_ends_are_seen_at_once(place):
    panel = moved_onto(HOUSEHOLD, CELL.takes.plate, *place)
    assert find_panel_problems(CELL, panel) == ()
    assert any("plate's size" in each for each in find_panel_problems(SMALL, panel))
    held = held_panel(CELL, panel)
    for wire in held.wires:
        presented = plan_presentation(CELL.magazine, held, wire)
        tips = np.array([presented.tips[end].position for end in WireEnd])
        assert CELL.overheads[best_view(CELL.overheads, tips)].sees(tips, INSIDE_PX)


@pytest.mark.parametrize(("width", "height"), [(0.025, 0.040), (0.040, 0.080)])
def test_ducts_of_usual_heights_are_taken(width, height):
    ducts = tuple(replace(duct, width=width, height=height) for duct in HOUSEHOLD.ducts)
    panel = moved_onto(replace(HOUSEHOLD, ducts=ducts), CELL.takes.plate, 0.0, 0.0)
    assert find_panel_problems(CELL, panel) == ()


@pytest.mark.parametrize("robot", CELL.robots)
def test_each_head_reaches_the_whole_plate_the_magazine_and_its_bin_beside_the_plate(robot):
    magazine = CELL.magazine
    strip = [(magazine.x, y, magazine.height) for y in np.linspace(-1, 1, 21) * magazine.y_max]
    for x, y, _ in [*plate_of(CELL), *strip]:
        for z, yaw in product((0.01, 0.35), (0.0, np.pi / 2, np.pi)):
            assert robot.arm.reaches(ToolPose(float(x), float(y), z, yaw))
    over = bin_of(robot, moved_onto(HOUSEHOLD, CELL.takes.plate, 0.0, 0.0))
    at = CELL.world_from_panel.inverse().apply(np.array([over.x, over.y, 0.0]))
    assert any(abs(at[i]) > CELL.takes.plate[i] / 2 + 0.05 for i in (0, 1))
