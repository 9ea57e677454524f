"""How wires that lie in ducts pass a place, in drawn pictures from above."""

import math
from dataclasses import replace

import numpy as np
import pytest
from drawn import along, boxes_of, picture
from panels import example

from remodel_vision.laid_wire import WireLines, uppermost_past, wire_past
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD

OVERHEAD = read_cell("two_arms_cabinet").overheads[0]
PANEL = example("household")
BOXES = boxes_of(PANEL)
WIRE = PANEL.wire("W3")
# Of the same diameter: one of the same colour, one of another one, and one of a colour that no wire
# here has.
ALIKE, UNLIKE, STRANGE = PANEL.wire("W15"), PANEL.wire("W7"), replace(WIRE, colour="YE")
ROUTE = BOARD.apply(np.array(WIRE.route))
REACH_M = 0.020
# Wires that lie beside each other are so far apart, and one that lies apart from them so far [m].
BESIDE_M, FAR_ASIDE_M = 0.004, 0.016


def place_at(height):
    """Return the middle of the wire's first leg in a duct, at a height [m]."""
    x, y, _ = ROUTE[1:3].mean(axis=0)
    return Pose.level(float(x), float(y), height, math.pi / 2)


def lying(height, x=0.0):
    """Return a wire's nodes along the route at a height, so far beside it [m]."""
    level = np.column_stack([ROUTE[:, 0] + x, ROUTE[:, 1], np.full(len(ROUTE), height)])
    return along(level)


def seen(*wires, seed=0):
    return picture(OVERHEAD, BOXES, wires, seed=seed)


def test_the_uppermost_of_two_wires_beside_each_other_is_taken():
    shown = seen((ALIKE, lying(0.030)), (UNLIKE, lying(0.038, BESIDE_M)))
    place = place_at(0.030)
    alone = wire_past(place, REACH_M, WireLines(shown, UNLIKE))
    passing = uppermost_past(place, REACH_M, WireLines(shown, ALIKE))
    assert passing.aside == pytest.approx(-BESIDE_M, abs=0.001)
    assert passing.height == pytest.approx(alone.height, abs=0.001)
    strange = WireLines(shown, STRANGE)
    assert wire_past(place, REACH_M, strange) is None
    by_depth = uppermost_past(place, REACH_M, strange)
    assert by_depth.height == pytest.approx(alone.height, abs=0.001)


def test_of_two_wires_of_one_colour_the_highest_is_taken_or_below_it_the_one_that_is_new():
    # Above the rims: the walls are lower.
    stood = (ALIKE, lying(0.082, -0.014))
    lines = WireLines(seen(stood, (WIRE, lying(0.070, 0.004)), seed=1), WIRE)
    highest = uppermost_past(place_at(0.070), REACH_M, lines)
    assert highest.height == pytest.approx(0.082, abs=0.005)
    assert highest.aside == pytest.approx(0.014, abs=0.003), "not the nearest"
    passing = uppermost_past(place_at(0.070), REACH_M, lines, seen(stood))
    assert passing.height == pytest.approx(0.070, abs=0.003)
    assert passing.aside == pytest.approx(-0.004, abs=0.003)


def test_an_older_wire_that_hides_the_new_one_is_not_taken_for_it():
    eye, above = OVERHEAD.world_from_camera.position, lying(0.070)
    hidden = eye + (above - eye) * (eye[2] - 0.040) / (eye[2] - 0.070)
    lines = WireLines(seen((UNLIKE, above), (WIRE, hidden), seed=1), WIRE)
    taken = uppermost_past(place_at(0.040), REACH_M, lines)
    assert taken.height == pytest.approx(0.070, abs=0.005)
    assert uppermost_past(place_at(0.040), REACH_M, lines, seen((UNLIKE, above))) is None


def test_a_wire_whose_colour_is_not_seen_is_found_by_what_is_new_far_aside():
    stood = (UNLIKE, lying(0.034, -0.008))
    before, place = seen(stood), place_at(0.030)
    lines = WireLines(seen(stood, (WIRE, lying(0.030, FAR_ASIDE_M)), seed=1), STRANGE)
    passing = uppermost_past(place, REACH_M, lines, before)
    assert passing.aside == pytest.approx(-FAR_ASIDE_M, abs=0.002)
    assert passing.height == pytest.approx(0.030, abs=0.002)
    assert uppermost_past(place, REACH_M, WireLines(before, STRANGE), before) is None
