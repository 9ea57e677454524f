"""How a wire lies in its ducts and forks, in drawn pictures, and what the checks make of it."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
from drawn import along
from formboards import HARNESS, duct, formboard, in_forks, touching
from laid_wires import (
    IN_DUCT_M,
    IN_DUCTS_M,
    LEG,
    OVER_RIM_M,
    across_the_devices,
    curled,
    laid,
    led,
)
from refusals import refused
from scripted_device import PARAMETERS, ScriptedPlant

from remodel_skills.belief_state import NO_CHANNEL, Feed
from remodel_skills.cell import Cell
from remodel_skills.primitives.observation import checks
from remodel_skills.primitives.observation.checks import check_ducts, check_forks, inspect_ducts
from remodel_states.core.codes import Code
from remodel_work.component_shape import Box
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD

# So far aside along both axes it lies over an outer wall [m].
OVER_WALL_M = 0.028


def inspected(*shapes):
    """Return how WIRE lies in its ducts, seen from above."""
    cell = laid(*shapes)
    return cell.run(inspect_ducts(cell.context))


@pytest.mark.parametrize(
    ("height", "aside", "is_out"),
    [(IN_DUCT_M, 0.0, False), (OVER_RIM_M, 0.0, True), (OVER_RIM_M, OVER_WALL_M, True)],
)
def test_a_wire_over_the_rims_or_the_wall_is_out_of_its_ducts(height, aside, is_out):
    found = inspected(led(height, aside))
    if not is_out:
        assert found.share == pytest.approx(1.0, abs=0.05)
        check_ducts(found, PARAMETERS.fixture)
        return
    with refused(
        Code.OUT_OF_DUCT, r"of \d+ mm of its route; allowed: \d+ mm; draw it out"
    ) as caught:
        check_ducts(found, PARAMETERS.fixture)
    assert caught.value.found["in_ducts"] == pytest.approx(0.0, abs=0.2)


@pytest.mark.parametrize(
    ("outside_m", "length_m", "is_out"),
    [
        (0.055, 0.16, False),  # between facing rows, across one duct: the walls
        (0.055, 0.24, False),
        (0.095, 0.16, True),
        (0.095, 0.50, False),
        (0.110, 0.50, True),
        (0.190, 1.00, False),
        (0.210, 1.00, True),
        (0.030, 0.05, True),  # a loop through the far wall, of a wire between facing rows
        (0.020, 0.05, False),
    ],
)
def test_what_the_walls_force_out_of_a_short_route_is_allowed(outside_m, length_m, is_out):
    found = replace(inspected(led(IN_DUCT_M)), outside_m=outside_m, length_m=length_m)
    with pytest.raises(AbilityError) if is_out else nullcontext():
        check_ducts(found, PARAMETERS.fixture)


def test_a_wire_that_curls_up_is_out_of_its_ducts_along_its_route_not_along_itself():
    nodes = curled(led(IN_DUCT_M))
    out = np.ptp(nodes[nodes[:, 2] == OVER_RIM_M][:, 0])
    assert inspected(nodes).share == pytest.approx(1 - out / IN_DUCTS_M, abs=0.05)


def test_a_wire_that_curls_up_beside_its_duct_where_it_is_seen_in_it_lies_in_its_duct():
    nodes = led(IN_DUCT_M)
    beside = (0.0, 0.035, OVER_RIM_M - IN_DUCT_M)
    comes_back = np.add(nodes[9 * LEG // 4 : 11 * LEG // 4], beside)
    assert inspected(nodes, comes_back).share == pytest.approx(1.0, abs=0.05)


def test_a_wire_that_lies_across_the_devices_is_not_in_its_ducts():
    with refused(Code.OUT_OF_DUCT, "lies outside its ducts along"):
        check_ducts(inspected(across_the_devices()), PARAMETERS.fixture)


OTHER = "W1.5"  # black: in the shadow each colour comes near to it


@pytest.fixture(scope="module")
def harness():
    made = Cell(ScriptedPlant(HARNESS, read_cell("two_arms_formboard")))
    yield made
    made.close()


def lying(wire_id, aside, height):
    return HARNESS.wire(wire_id), in_forks(wire_id, aside, height)


def held_by_forks(cell, wire_id, *wires):
    cell.plant.wires = list(wires)
    cell.context.belief.start_wire(Feed(wire_id, NO_CHANNEL, 1), {})
    return [fork.id for fork in cell.run(check_forks(cell.context))]


@pytest.mark.parametrize("wire", [wire.id for wire in HARNESS.wires])
def test_a_wire_of_each_colour_is_seen_beside_its_fork(harness, wire):
    with refused(Code.OUT_OF_DUCT, r"lies in 2 of its 3 forks: .* beside 'F2'"):
        held_by_forks(harness, wire, lying(wire, touching(-1, 1), 0.025))


@pytest.mark.parametrize(
    ("aside", "height", "words"),
    [
        (0.0, 0.025, ""),
        (touching(1, -1), 0.002, ""),
        (touching(-1, -1), 0.050, ""),
        (touching(1, 1), 0.040, "beside 'F2'"),
        (touching(-1, 1), 0.006, "beside 'F2'"),
        (-0.060, 0.025, "beside 'F2'"),
        (0.0, 0.064, "above the posts of 'F2'"),
    ],
)
def test_where_a_wire_lies_at_a_fork_decides(harness, aside, height, words):
    with pytest.raises(AbilityError, match=words) if words else nullcontext():
        forks = held_by_forks(harness, "W1.4", lying("W1.4", aside, height))
    assert words or forks == ["F1", "F2", "F3"]


@pytest.mark.parametrize("wire", [wire.id for wire in HARNESS.wires if wire.id != OTHER])
def test_another_wire_beside_a_fork_is_not_taken_for_it(harness, wire):
    beside = lying(OTHER, touching(-1, 1), 0.037)
    assert held_by_forks(harness, wire, beside, lying(wire, 0.0, 0.025)) == ["F1", "F2", "F3"]


def test_a_wire_that_is_not_visible_does_not_count_as_held(harness):
    with pytest.raises(AbilityError, match=r"'W1\.4' is not visible near any of its 3 forks"):
        held_by_forks(harness, "W1.4")


def at(x, y):
    return BOARD @ Pose.level(x, y, 0.05, np.pi / 2)


def formboard_with_a_wire(*ducts):
    """Return a cell whose wire lies along the middle of its channel."""
    cell = Cell(ScriptedPlant(formboard(0, ducts)))
    cell.feed("W1", "A")
    wire = cell.context.wire
    line = BOARD.apply(np.array([[0.0, -0.31, wire.radius], [0.0, 0.31, wire.radius]]))
    cell.plant.wires = [(wire, along(line))]
    return cell


@pytest.mark.parametrize(("x", "words"), [(0.0, ""), (-0.045, "2. mm beside duct 'D1'")])
def test_a_wire_beside_its_duct_is_seen_from_above(x, words):
    cell = formboard_with_a_wire(duct(x, 0.0))
    with pytest.raises(AbilityError, match=words) if words else nullcontext() as caught:
        cell.run(checks.check_path_in_ducts(cell.context, (at(x, -0.1), at(x, 0.1))))
    assert not words or caught.value.code is Code.OUT_OF_DUCT


@pytest.mark.parametrize("hidden", [("D1",), ("D1", "D2")])
def test_a_wire_that_is_hidden_in_one_duct_is_judged_by_the_others(hidden):
    ducts = [duct(0.0, -0.1), replace(duct(0.0, 0.1), id="D2")]
    cell = formboard_with_a_wire(*ducts)
    cover = Box((0.0, 0.0, 0.03), (0.2, 0.2, 0.002), (0.5, 0.5, 0.5))
    covers = tuple((cover, BOARD @ one.panel_from_duct) for one in ducts if one.id in hidden)
    cell.plant.boxes += covers
    with pytest.raises(AbilityError) if len(hidden) > 1 else nullcontext() as caught:
        cell.run(checks.check_path_in_ducts(cell.context, (at(0.0, -0.2), at(0.0, 0.2))))
    assert caught is None or caught.value.code is Code.CABLE_OCCLUDED
