"""The work of a search follows from the limit of time, and is cut into slices."""

import pytest

from remodel_cable_tree.problem import rounds
from remodel_tasks.core.search import moves_per_second, slices


@pytest.mark.parametrize("arms", [1, 2])
@pytest.mark.parametrize("wires", [2, 30, 1000])
@pytest.mark.parametrize("limit_s", [0.0, 0.01, 1.0, 10.0])
def test_slices_add_up_to_what_the_limit_allots(wires, arms, limit_s):
    parts = list(slices(wires, arms, limit_s))
    allotted = int(limit_s * moves_per_second(wires, arms))
    assert sum(part.moves for part in parts) <= allotted
    if wires == 1000:
        assert sum(part.moves for part in parts) == allotted
    for part in parts:
        assert part.start_temperature >= part.end_temperature > 0
        assert part.moves <= 0.05 * moves_per_second(wires, arms) + 1
    if parts:
        assert parts[0].opens_round


def test_a_single_wire_needs_no_search():
    assert not list(slices(1, 1, 10.0))


@pytest.mark.parametrize("ends", [2, 40, 198])
def test_rounds_grow_with_the_limit(ends):
    moves = [sum(part.moves for part in rounds(ends, limit)) for limit in (0.1, 1.0, 10.0)]
    assert moves == sorted(moves)
    assert moves[0] > 0
    assert not list(rounds(ends, 0.0))
