import sys
from pathlib import Path

import pytest

sys.path.insert(
    0, str(Path(__file__).parent)
)  # elastica, panels and place_wire are shared by tests

from panels import panel

from remodel_sim.cell import Cell


@pytest.fixture
def cell():
    """A freshly built cell."""
    made = Cell(panel(), seed=1)
    yield made
    made.close()
