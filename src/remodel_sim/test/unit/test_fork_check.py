"""Whether a wire lies in its forks, in the simulator's pictures and by its truth."""

from contextlib import nullcontext

import pytest
from formboards import HARNESS, in_forks, touching

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import share_in_ducts
from remodel_skills.belief_state import NO_CHANNEL, Feed
from remodel_skills.cell import Cell
from remodel_skills.primitives.observation.checks import check_forks
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import AbilityError
from remodel_work.panel import WireEnd
from remodel_work.routes import ParkedWire

pytestmark = pytest.mark.physics


@pytest.fixture(scope="module")
def cell():
    made = Cell(SimulatedPlant(HARNESS, design=read_cell("two_arms_formboard"), seed=1))
    yield made
    made.close()


def observed(cell, wire_id, parked):
    """Park wires, and check the forks of one of them."""
    cell.plant.load(cell.plant.loaded, parked)
    for context in cell.contexts.values():
        context.belief.start_wire(Feed(wire_id, NO_CHANNEL, 1), {})
    return cell.run(check_forks(cell.context), cell.context.name)


@pytest.mark.parametrize(
    ("aside", "height", "words"),
    [
        (0.0, 0.025, ""),
        (touching(1, 1), 0.040, "beside 'F2'"),
    ],
)
def test_where_a_wire_lies_at_a_fork_decides(cell, aside, height, words):
    shape = ParkedWire(in_forks("W1.4", aside, height), frozenset(WireEnd))
    with pytest.raises(AbilityError, match=words) if words else nullcontext():
        forks = observed(cell, "W1.4", {"W1.4": shape})
    assert share_in_ducts(cell.plant, "W1.4") == pytest.approx(2 / 3 if words else 1.0)
    assert words or [fork.id for fork in forks] == ["F1", "F2", "F3"]
