"""What the cameras tell of the ends in the terminals, against the truth."""

import pytest
from place_wire import carry, connect, do

from remodel_sim.abilities.check_connection import check_connection
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.goals import CheckGoal
from remodel_sim.core.vision.opening_occupancy import MouthSight, Sight, settle
from remodel_sim.core.workpiece.panel import End
from remodel_sim.physics.truth import ground_truth
from remodel_states.core.codes import Code


def is_connected(cell, wire, end, terminal=None):
    terminal = terminal or cell.station.panel.wire(wire).goes_to(end)
    return do(cell, check_connection, CheckGoal(wire, end, *terminal)).connected


def test_a_fixed_end_is_seen_and_neither_its_neighbour_nor_its_other_end(cell):
    cell.feed("W1", "A")
    assert not is_connected(cell, "W1", End.A)
    connect(cell, "W1", End.A)
    assert is_connected(cell, "W1", End.A)
    assert not is_connected(cell, "W1", End.B)
    assert not is_connected(cell, "W1", End.A, ("X1", "2"))
    assert not is_connected(cell, "W2", End.A, ("X1", "1")), "that wire is blue, W2 is brown"


def test_the_answer_does_not_come_from_the_book(cell):
    cell.feed("W1", "A")
    connect(cell, "W1", End.A)
    cell.station.book.loosen(End.A)
    assert is_connected(cell, "W1", End.A)
    cell.station.book.seat(End.B, ("X2", "1"))
    assert not is_connected(cell, "W1", End.B)


def test_a_component_that_was_moved_is_found_where_it_stands(cell):
    cell.feed("W1", "A")
    cell.plant.disturb("component_moved", "X1", [0.008, -0.006, 0.1])
    assert not is_connected(cell, "W1", End.A)
    connect(cell, "W1", End.A)
    assert is_connected(cell, "W1", End.A)


def test_a_look_with_a_wire_in_the_hand_moves_nothing(cell):
    cell.feed("W1", "A")
    connect(cell, "W1", End.A)
    carry(cell, "W1", "A")
    held = cell.station.commanded
    for end in End:
        try:
            assert is_connected(cell, "W1", end) is (end is End.A)
        except AbilityError as error:
            assert error.code in (Code.CABLE_OCCLUDED, Code.COMPONENT_OCCLUDED)
            assert "place what the hand holds" in str(error)
    assert cell.station.commanded == held
    (truth,) = ground_truth(cell.plant, ["W1"])
    assert truth.a.seated and truth.a.fixed


def test_unknown_names_are_refused_with_those_that_there_are(cell):
    with pytest.raises(AbilityError, match="X1, X2, X3, X4"):
        is_connected(cell, "W1", End.A, ("Q9", "1"))


def test_one_empty_sight_settles_it_and_one_wire_does_not():
    wire, empty = MouthSight(Sight.WIRE, False), MouthSight(Sight.EMPTY, True)
    unclear = MouthSight(Sight.UNCLEAR, False)
    assert settle([]) is Sight.UNCLEAR
    assert settle([wire]) is Sight.UNCLEAR
    assert settle([wire, unclear]) is Sight.UNCLEAR
    assert settle([wire, unclear, wire]) is Sight.WIRE
    assert settle([MouthSight(Sight.WIRE, True)]) is Sight.WIRE
    assert settle([wire, MouthSight(Sight.LOOSE_END, False), wire]) is Sight.UNCLEAR
    assert settle([wire, wire, empty]) is Sight.EMPTY
