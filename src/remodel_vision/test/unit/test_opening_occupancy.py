"""What several pictures of an opening say together."""

from remodel_vision.opening_occupancy import Occupancy, OpeningObservation, combine


def test_one_empty_opening_decides_it_and_one_wire_does_not():
    wire, empty = (
        OpeningObservation(Occupancy.WIRE, False),
        OpeningObservation(Occupancy.EMPTY, True),
    )
    unclear = OpeningObservation(Occupancy.UNCLEAR, False)
    assert combine([]) is Occupancy.UNCLEAR
    assert combine([wire]) is Occupancy.UNCLEAR
    assert combine([wire, unclear]) is Occupancy.UNCLEAR
    assert combine([wire, unclear, wire]) is Occupancy.WIRE
    assert combine([OpeningObservation(Occupancy.WIRE, True)]) is Occupancy.WIRE
    assert (
        combine([wire, OpeningObservation(Occupancy.LOOSE_END, False), wire]) is Occupancy.UNCLEAR
    )
    assert combine([wire, wire, empty]) is Occupancy.EMPTY
