"""FixCable sees from above whether the wire's first end is still where it was fixed."""

import pytest
from holds import pull_out
from place_wire import ROBOT, carry, do, fix, insert, locate
from stored import put_live

from remodel_sim.physics.truth import ground_truth
from remodel_skills.abilities.extracting import DiscardGoal, discard_cable
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.panel import WireEnd, unit_x
from remodel_work.routes import opening_of

pytestmark = pytest.mark.physics

FIRST, SECOND = ("X1", "1"), ("X2", "1")
# Out of its opening by this much, an end lies before it [m].
OUT_M = 0.040


def with_both_ends_in(cell):
    """Insert the second end of W1, whose first one is fixed; return the first opening's frame."""
    put_live(cell, "W1")
    socket = opening_of(FIRST, cell.context.panel, cell.context.belief.seen)
    carry(cell, "W1", "A")
    insert(cell, "W1", WireEnd.B, *SECOND, locate(cell, *SECOND))
    return socket


@pytest.mark.slow
def test_an_end_that_came_out_while_the_other_one_was_placed_is_noticed(cell):
    socket = with_both_ends_in(cell)
    cell.plant.open_clamp(*FIRST)
    cable = cell.plant.live.cable
    while (cable.tip(WireEnd.A)[0] - socket.position) @ -unit_x(socket) < OUT_M:
        pull_out(cell.plant.world, cable, WireEnd.A, -unit_x(socket), 10.0)
    with pytest.raises(AbilityError, match="end a of 'W1' was fixed in 'X1/1'") as caught:
        fix(cell, "W1", *SECOND)
    assert caught.value.code is Code.CAME_OUT
    (truth,) = ground_truth(cell.plant, ["W1"])
    assert truth.b.fixed and not truth.a.seated
    do(cell, discard_cable, DiscardGoal(ROBOT, "W1"))
    assert cell.plant.live is None and cell.context.belief.fed == []


def test_an_end_that_stayed_is_not_missed(cell):
    with_both_ends_in(cell)
    fix(cell, "W1", *SECOND)
    (truth,) = ground_truth(cell.plant, ["W1"])
    assert truth.a.fixed and truth.b.fixed
