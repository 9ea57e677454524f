"""Walls of ducts: combs with slots, open where ducts meet."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest

from remodel_work.fixtures import WALL_M, duct_boxes, rail_box
from remodel_work.panel import Duct, Rail

ROW = Duct("D1", (0.0, 0.0, math.pi / 2), length=0.40, width=0.040, height=0.060)
SLOTTED = replace(ROW, slot_pitch=0.0125, slot_width=0.007, slot_bottom=0.015)


def spans(boxes, side, z):
    """Return from where to where along a duct the wall on a side stands at a height."""
    return sorted(
        (box.centre[0] - box.size[0] / 2, box.centre[0] + box.size[0] / 2)
        for box in boxes
        if box.centre[1] * side > 0
        and box.centre[2] - box.size[2] / 2 < z < box.centre[2] + box.size[2] / 2
    )


def test_a_duct_alone_has_two_solid_walls_outside_its_width():
    boxes = duct_boxes(ROW)
    assert len(boxes) == 2
    assert [abs(box.centre[1]) - WALL_M / 2 for box in boxes] == pytest.approx([0.020, 0.020])
    assert spans(boxes, 1, 0.05) == [(-0.20, 0.20)]


def test_the_slots_of_a_comb_are_as_wide_as_said_and_one_is_in_the_middle():
    boxes = duct_boxes(SLOTTED)
    assert spans(boxes, 1, 0.010) == [(-0.20, 0.20)]
    fingers = spans(boxes, -1, 0.030)
    slots = [b[0] - a[1] for a, b in pairwise(fingers)]
    assert slots == pytest.approx([0.007] * len(slots))
    assert len(fingers) == 32
    assert not any(left < 0.0 < right for left, right in fingers)
    assert max(box.centre[2] + box.size[2] / 2 for box in boxes) == pytest.approx(0.060)


def test_a_wall_is_open_where_another_duct_joins_it():
    # It begins at the far wall of the row, and leads away from it to one side.
    branch = Duct("L", (0.08, 0.1, 0.0), length=0.20, width=0.040, height=0.060)
    (into_row,) = [
        side for side in (-1, 1) if len(spans(duct_boxes(ROW, (ROW, branch)), side, 0.03)) == 2
    ]
    left, right = spans(duct_boxes(ROW, (ROW, branch)), into_row, 0.03)
    assert left[1] == pytest.approx(0.1 - 0.021)
    assert right[0] == pytest.approx(0.1 + 0.021)
    assert spans(duct_boxes(ROW, (ROW, branch)), -into_row, 0.03) == [(-0.20, 0.20)]
    # The branch's own walls end at the row's near wall.
    for side in (-1, 1):
        ((start, end),) = spans(duct_boxes(branch, (ROW, branch)), side, 0.03)
        assert (start, end) == pytest.approx((-0.10 + 0.041, 0.10), abs=2e-3)


def test_ducts_beside_each_other_leave_each_other_whole():
    beside = Duct("D2", (0.22, 0.0, math.pi / 2), length=0.40, width=0.040, height=0.060)
    assert duct_boxes(ROW, (ROW, beside)) == duct_boxes(ROW)


def test_a_rail_lies_on_the_plate():
    box = rail_box(Rail("R1", (0.0, 0.0, 0.0), 0.5, 0.035, 0.0075))
    assert box.size == (0.5, 0.035, 0.0075)
    assert box.centre == (0.0, 0.0, 0.00375)
