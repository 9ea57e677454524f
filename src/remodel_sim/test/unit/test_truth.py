"""Ground truth about wires that have been parked: where their ends sit, what lies in ducts."""

from itertools import pairwise

import numpy as np
import pytest
from panels import example

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth, share_in_ducts
from remodel_sim.ros.simulated_cell import truth_message
from remodel_skills.cell import Cell
from remodel_work.edge.cell_file import read_cell
from remodel_work.panel import BOARD, WireEnd
from remodel_work.routes import ParkedWire

WIRE, OTHER = "W3", "W7"
BELOW_M, ABOVE_M = 0.020, 0.065


@pytest.fixture(scope="module")
def board():
    panel = example("household")
    made = Cell(SimulatedPlant(panel, design=read_cell("two_arms_cabinet"), seed=1))
    yield made.plant
    made.close()


def park(plant, heights, ends, fixed):
    """Park the wire along its route at a height [m] per leg, from the bottom of one terminal."""
    route = [BOARD.apply(np.array(at)) for at in plant.panel.wire(WIRE).route]
    legs = [np.linspace(a, b, 200) for a, b in pairwise(route)]
    for leg, height in zip(legs, heights, strict=True):
        leg[:, 2] = height
    tips = [
        plant.world_from_socket(*key).apply(
            np.array([[plant.panel.component(key[0]).terminal(key[1]).depth, 0.0, 0.0]])
        )
        for key in ends
    ]
    plant.parked[WIRE] = ParkedWire(np.concatenate([tips[0], *legs, tips[1]]), frozenset(fixed))
    (found,) = ground_truth(plant, [WIRE])
    return found


def test_a_parked_wire_at_its_places_is_placed_and_in_its_ducts(board):
    wire = board.panel.wire(WIRE)
    ends = [wire.goes_to(end) for end in WireEnd]
    found = park(board, [BELOW_M] * 5, ends, fixed=WireEnd)
    assert found.placed
    assert (found.a.at, found.b.at) == ("D11/T1", "Q1/B1.1")
    legs_m = [np.linalg.norm(np.subtract(b, a)) for a, b in pairwise(wire.route)]
    assert found.duct_length == pytest.approx(sum(legs_m[1:-1]), abs=0.06), "three ducts in a row"
    assert found.in_ducts == 1.0


def test_a_leg_above_the_rims_takes_its_length_from_the_share(board):
    wire = board.panel.wire(WIRE)
    ends = [wire.goes_to(end) for end in WireEnd]
    found = park(board, [BELOW_M, BELOW_M, ABOVE_M, BELOW_M, BELOW_M], ends, fixed=WireEnd)
    assert found.placed, "ducts do not decide that"
    outside_m = np.linalg.norm(np.subtract(wire.route[3], wire.route[2]))
    assert found.in_ducts == pytest.approx(1 - outside_m / found.duct_length, abs=0.06)
    assert share_in_ducts(board, WIRE) == found.in_ducts


def test_a_wire_that_rounds_a_corner_is_in_its_ducts_and_one_that_leaves_them_is_not(board):
    ends = [board.panel.wire(WIRE).goes_to(end) for end in WireEnd]
    straight = park(board, [BELOW_M] * 5, ends, fixed=WireEnd)
    nodes = board.parked[WIRE].nodes
    corner = BOARD.apply(np.array(board.panel.wire(WIRE).route[2]))
    for rounded_m, least, most in ((0.035, 1.0, 1.0), (0.090, 0.0, 0.95)):
        cut = np.linalg.norm((nodes - corner)[:, :2], axis=1) > rounded_m
        board.parked[WIRE] = ParkedWire(nodes[cut], frozenset(WireEnd))
        assert least <= share_in_ducts(board, WIRE) <= most
    assert straight.in_ducts == 1.0


def test_a_parked_wire_in_the_neighbours_terminal_is_found_there(board):
    own, wrong = (
        board.panel.wire(WIRE).goes_to(WireEnd.A),
        board.panel.wire(OTHER).goes_to(WireEnd.B),
    )
    found = park(board, [BELOW_M] * 5, [own, wrong], fixed=[WireEnd.A])
    assert not found.placed
    assert (found.b.at, found.b.seated, found.b.fixed) == ("/".join(wrong), False, False)
    assert (found.a.seated, found.a.fixed) == (True, True)


def test_the_message_says_the_same(board):
    wire = board.panel.wire(WIRE)
    found = park(
        board,
        [BELOW_M, BELOW_M, ABOVE_M, BELOW_M, BELOW_M],
        [wire.goes_to(end) for end in WireEnd],
        fixed=[WireEnd.B],
    )
    message = truth_message(found)
    assert (message.duct_length, message.in_ducts) == (found.duct_length, found.in_ducts)
    assert (message.a_fixed, message.b_fixed, message.placed) == (False, True, False)


def test_a_wire_without_a_route_has_nothing_in_ducts(cell):
    cell.plant.parked["W1"] = ParkedWire(np.array([[0.5, 0, 0], [0.6, 0, 0]]), frozenset())
    (found,) = ground_truth(cell.plant, ["W1"])
    assert (found.duct_length, found.in_ducts) == (0.0, 0.0)
