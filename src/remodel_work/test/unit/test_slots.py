"""Slots of ducts before terminals."""

import math
from dataclasses import replace

import pytest
from panels import panel

from remodel_work.geometry import Pose
from remodel_work.panel import Duct
from remodel_work.routes import slot_before

# Along y; its wall at x 0.02 has slots at y 0, 12.5 mm, ...
DUCT = Duct("D1", (0.0, 0.0, math.pi / 2), 0.40, 0.040, 0.060, slot_pitch=0.0125, slot_width=0.007)


def board(*ducts):
    return replace(panel(), ducts=ducts)


@pytest.mark.parametrize(("y", "aside"), [(0.0, 0.0), (0.004, 0.004), (0.010, -0.0025)])
def test_the_nearest_slot_is_found_beside_the_axis(y, aside):
    # The opening's y axis points against the panel's: its x, into the terminal, is the panel's.
    opening = Pose.level(0.065, y, 0.023)
    slot = slot_before(board(DUCT), opening)
    assert slot.before == pytest.approx(0.045)
    assert slot.aside == pytest.approx(-aside)


def test_a_wire_from_the_slot_points_at_the_opening():
    opening = Pose.level(0.065, 0.004, 0.023)
    slot = slot_before(board(DUCT), opening)
    at_slot = opening.apply([-slot.before, slot.aside, 0.0])
    towards = opening.position - at_slot
    assert math.atan2(towards[1], towards[0]) == pytest.approx(opening.yaw + slot.slant)


@pytest.mark.parametrize(
    ("opening", "duct"),
    [
        (Pose.level(0.065, 0.0, 0.023), replace(DUCT, slot_pitch=0.0)),  # solid walls
        (Pose.level(0.065, 0.0, 0.023, math.pi), DUCT),  # it looks the other way
        (Pose.level(0.065, 0.0, 0.023, math.pi / 2), DUCT),  # along the wall
        (Pose.level(0.165, 0.0, 0.023), DUCT),  # the wall is far
        (Pose.level(0.065, 0.3, 0.023), DUCT),  # beyond its end
    ],
)
def test_no_slot_stands_before_other_openings(opening, duct):
    assert slot_before(board(duct), opening) is None
