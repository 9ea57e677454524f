"""Mating a connector with its header: by physics, and what is refused before anything moves."""

import numpy as np
import pytest
from panels import example
from place_wire import ROBOT, do, extract, locate

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills.abilities.inserting import ConnectGoal, place_connector
from remodel_skills.belief_state import EndState
from remodel_skills.cell import Cell
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, WireEnd

PANEL = example("connectors")
FACE = BOARD @ PANEL.panel_from_socket("U1", "J1")


@pytest.fixture
def cell():
    """A freshly built cell, W1 with its connector P1 fed."""
    made = Cell(SimulatedPlant(PANEL, seed=1))
    made.feed("W1", "A")
    yield made
    made.close()


def connection(**changes):
    fields = dict(
        robot_name=ROBOT,
        connector_id="P1",
        cable_id="W1",
        component_id="U1",
        terminal_id="J1",
        socket=FACE,
        force_limit=30.0,
    )
    return ConnectGoal(**{**fields, **changes})


def place(cell, socket, force=30.0):
    return do(cell, place_connector, connection(socket=socket, force_limit=force))


def truth_of(cell):
    (truth,) = ground_truth(cell.plant, ["W1"])
    return truth.a


@pytest.mark.physics
def test_a_connector_latches_when_pushed_hard_enough_and_comes_out_when_its_latch_is_opened(cell):
    socket = locate(cell, "U1", "J1")
    with pytest.raises(AbilityError, match="did not latch") as caught:
        place(cell, socket, force=4.0)
    assert caught.value.code is Code.INSUFFICIENT_FORCE
    assert not truth_of(cell).fixed
    placed = place(cell, socket)
    assert placed.peak_force >= 30.0
    assert truth_of(cell).seated and truth_of(cell).fixed
    assert cell.context.belief.ends[WireEnd.A] is EndState.FIXED
    assert cell.context.belief.grip is None
    extract(cell, "W1", "U1", "J1", socket=socket)
    assert truth_of(cell).at == "" and not truth_of(cell).fixed


@pytest.mark.slow
@pytest.mark.physics
def test_pins_beside_their_openings_and_an_obstacle_in_one_have_different_codes(cell):
    socket = locate(cell, "U1", "J1")
    beside = Pose(socket.position + np.array([0.0, 0.006, 0.0]), socket.quaternion)
    with pytest.raises(AbilityError) as caught:
        place(cell, beside)
    assert caught.value.code is Code.INSERTION_MISALIGNED
    extract(cell, "W1", "U1", "J1", socket=beside)
    cell.plant.block_socket("U1", "J1")
    with pytest.raises(AbilityError) as caught:
        place(cell, socket)
    assert caught.value.code is Code.INSERTION_JAMMED
    assert 0.003 < caught.value.found["depth"] < 0.0065
