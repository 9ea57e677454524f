"""What the cameras show of the ends in the terminals, against the truth."""

import pytest
from place_wire import carry, connect, do
from stored import put_live

from remodel_sim.physics.truth import ground_truth
from remodel_skills.abilities.inspection import CheckGoal, check_connection
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.panel import WireEnd


def is_connected(cell, wire, end, terminal=None):
    terminal = terminal or cell.context.panel.wire(wire).goes_to(end)
    return do(cell, check_connection, CheckGoal(wire, end, *terminal)).connected


@pytest.mark.physics
def test_a_fixed_end_is_seen_and_neither_its_neighbour_nor_its_other_end(cell):
    put_live(cell, "W1")
    assert is_connected(cell, "W1", WireEnd.A)
    assert not is_connected(cell, "W1", WireEnd.B)
    assert not is_connected(cell, "W1", WireEnd.A, ("X1", "2"))
    assert not is_connected(cell, "W2", WireEnd.A, ("X1", "1")), "that wire is blue, W2 is brown"


@pytest.mark.slow
@pytest.mark.physics
def test_the_answer_does_not_come_from_the_belief_state(cell):
    put_live(cell, "W1")
    cell.context.belief.loosen(WireEnd.A)
    assert is_connected(cell, "W1", WireEnd.A)
    cell.context.belief.seat(WireEnd.B, ("X2", "1"))
    assert not is_connected(cell, "W1", WireEnd.B)


@pytest.mark.slow
@pytest.mark.physics
def test_a_component_that_was_moved_is_found_where_it_stands(cell):
    cell.feed("W1", "A")
    cell.plant.disturb("component_moved", "X1", [0.008, -0.006, 0.1])
    assert not is_connected(cell, "W1", WireEnd.A)
    connect(cell, "W1", WireEnd.A)
    assert is_connected(cell, "W1", WireEnd.A)


@pytest.mark.slow
@pytest.mark.physics
def test_an_observation_with_a_wire_in_the_hand_moves_nothing(cell):
    put_live(cell, "W1")
    carry(cell, "W1", "A")
    held = cell.context.commanded
    for end in WireEnd:
        try:
            assert is_connected(cell, "W1", end) is (end is WireEnd.A)
        except AbilityError as error:
            assert error.code in (Code.CABLE_OCCLUDED, Code.COMPONENT_OCCLUDED)
            assert "place what the hand holds" in str(error)
    assert cell.context.commanded == held
    (truth,) = ground_truth(cell.plant, ["W1"])
    assert truth.a.seated and truth.a.fixed


def test_unknown_names_are_refused_with_those_that_there_are(cell):
    with pytest.raises(AbilityError, match="X1, X2, X3, X4"):
        is_connected(cell, "W1", WireEnd.A, ("Q9", "1"))
