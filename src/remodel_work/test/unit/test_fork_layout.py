"""Which wires fit the forks of a formboard."""

import math
from functools import partial

import pytest
from panels import example, with_first

from remodel_work.edge.cell_file import read_cell
from remodel_work.layout import find_problems

DESIGN = read_cell("two_arms_formboard")
HARNESS = example("harness")


def problems(panel):
    arms = [robot.arm for robot in DESIGN.robots]
    return find_problems(panel, arms, DESIGN.takes, has_magazine=True)


with_wire = partial(with_first, HARNESS, "wires")


def test_the_harness_fits_the_cell_for_formboards():
    assert problems(HARNESS) == ()


def test_a_route_that_bends_is_refused_with_the_angle():
    (ax, ay, z), (bx, by, _) = HARNESS.wires[0].route
    (problem,) = problems(with_wire(route=((ax, ay, z), (bx, ay, z), (bx, by, z)), length=0.60))
    assert "'W1.1': its route turns by 90 deg" in problem
    assert "connectors that face each other" in problem


@pytest.mark.parametrize("length", [0.495, 0.60])
def test_a_wire_too_short_or_too_long_for_its_forks_is_refused_with_the_allowed_length(length):
    (problem,) = problems(with_wire(length=length))
    apart = math.dist(*(point[:2] for point in HARNESS.wires[0].route))
    assert f"'W1.1': it is {length:.3f} m long and its openings are {apart:.3f} m apart" in problem
    assert f"cut it to {apart + 0.028:.3f} to {apart + 0.060:.3f} m" in problem
