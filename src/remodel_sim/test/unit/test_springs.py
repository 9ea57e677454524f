"""An end in a spring clamp: it goes in, holds without being closed, and comes out when opened."""

import pytest
from panels import panel, with_springs
from place_wire import extract, fix, insert, locate

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills.belief_state import EndState
from remodel_skills.cell import Cell
from remodel_work.panel import WireEnd

PANEL = with_springs(panel(), 10.0)
TERMINAL = PANEL.wire("W1").goes_to(WireEnd.A)
FORCE_LIMIT_N = 18.0
PULL_N = 15.0


@pytest.mark.slow
@pytest.mark.physics
def test_an_end_is_held_by_its_spring_and_comes_out_when_that_is_opened():
    cell = Cell(SimulatedPlant(PANEL, seed=1))
    cell.feed("W1", "A")
    socket = locate(cell, *TERMINAL)
    inserted = insert(cell, "W1", WireEnd.A, *TERMINAL, socket, force=FORCE_LIMIT_N)
    assert inserted.peak_force >= FORCE_LIMIT_N

    def truth():
        (found,) = ground_truth(cell.plant, ["W1"])
        return found.a

    assert truth().seated and truth().fixed
    fixed = fix(cell, "W1", *TERMINAL, pull=PULL_N)
    assert fixed.slip < 0.001
    assert cell.context.belief.ends[WireEnd.A] is EndState.FIXED
    assert truth().seated and truth().fixed
    extract(cell, "W1", *TERMINAL, socket=socket)
    assert truth().at == "" and not truth().fixed
    cell.close()
