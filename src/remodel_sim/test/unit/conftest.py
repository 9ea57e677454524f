import sys
from pathlib import Path

import pytest

sys.path.insert(
    0, str(Path(__file__).parent)
)  # elastica, panels and place_wire are shared by tests

from force_record import recorded
from panels import panel

from remodel_sim.cell import Cell


@pytest.fixture(autouse=True)
def pushes():
    """Records of the pushes and pulls of a test; none may go far beyond its force limit.

    What 99 % of them must keep to, evaluate_abilities.py measures: now and then the wire jerks
    between the pads.
    """
    with recorded() as records:
        yield records
    beyond = [(r.limit, r.peak, r.motion.peak) for r in records if r.peak > 1.3 * r.allowed]
    assert not beyond, f"limit, peak and peak as reported [N]: {beyond}"


@pytest.fixture
def cell():
    """A freshly built cell."""
    made = Cell(panel(), seed=1)
    yield made
    made.close()
