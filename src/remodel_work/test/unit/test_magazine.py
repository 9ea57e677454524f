"""Where the magazine presents a wire."""

import math
import re

import numpy as np
import pytest
from dense_board import board_wire, dense_panel

from remodel_work.cell.cell_design import find_panel_problems
from remodel_work.cell.presenting import ALONG_TOLERANCE_M, Magazine, disturbed, plan_presentation
from remodel_work.edge.cell_file import read_cell
from remodel_work.panel import WireEnd

MAGAZINE = Magazine(x=0.20, height=0.050, span=0.46, y_min=-0.30, y_max=0.40)
TO_THE_LEFT = board_wire("W1", ("N1", "b1"), ("N2", "b10"), 0.53)


def test_a_wire_is_presented_before_its_first_terminal_with_the_tips_outwards():
    presentation = plan_presentation(MAGAZINE, dense_panel([TO_THE_LEFT]), TO_THE_LEFT)
    a, b = (presentation.tips[end] for end in WireEnd)
    opening = dense_panel().panel_from_socket("N1", "b1").position[1]
    assert presentation.direction == 1
    assert (a.position[1] + b.position[1]) / 2 == pytest.approx(max(opening, -0.30 + 0.23))
    assert b.position[1] - a.position[1] == pytest.approx(MAGAZINE.span)
    assert (a.yaw, b.yaw) == pytest.approx((-math.pi / 2, math.pi / 2))


def test_a_wire_that_runs_the_other_way_has_its_first_end_at_the_other_side():
    back = board_wire("W1", ("N2", "b10"), ("N1", "b1"), 0.53)
    presentation = plan_presentation(MAGAZINE, dense_panel([back]), back)
    a, b = (presentation.tips[end].position[1] for end in WireEnd)
    assert presentation.direction == -1
    assert a - b == pytest.approx(MAGAZINE.span)


def test_a_short_wire_is_presented_nearly_straight_by_clips_nearer_to_each_other():
    assert {MAGAZINE.span_of(length) for length in (0.48, 0.53, 1.35, 3.0)} == {MAGAZINE.span}
    spans = [MAGAZINE.span_of(length) for length in (0.25, 0.36, 0.42, 0.47)]
    assert spans == pytest.approx([0.2498, 0.3559, 0.4100, 0.4520], abs=1e-4)
    assert not MAGAZINE.is_short(0.48) and MAGAZINE.is_short(0.47)


@pytest.mark.parametrize("is_short", [True, False])
def test_a_short_wire_is_fed_too_far_to_one_side_as_a_whole(is_short):
    tips = plan_presentation(MAGAZINE, dense_panel([TO_THE_LEFT]), TO_THE_LEFT).tips
    noise = np.random.default_rng(1)
    found = disturbed(tips, noise, is_short=is_short)
    out = [(tips[end].inverse() @ found[end]).position for end in WireEnd]
    assert (out[0][0] == pytest.approx(-out[1][0])) == is_short
    assert max(abs(at).max() for at in out) <= ALONG_TOLERANCE_M


def test_a_wire_that_the_magazine_cannot_present_is_refused_when_its_panel_is_loaded():
    short = board_wire("W1", ("N1", "b1"), ("N2", "b10"), 0.45)
    (problem,) = find_panel_problems(read_cell("cabinet"), dense_panel([short]))
    assert re.search(r"'W1': length .* is 0.45 m, 0.03 m too little", problem), problem
