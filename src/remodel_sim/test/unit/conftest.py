import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # elastica and place_wire are shared by tests
sys.path.insert(0, str(Path(__file__).parents[3] / "remodel_work/test"))

from disturbance import disturbed
from force_record import recorded
from panels import panel

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.world import World
from remodel_skills.cell import Cell


def pytest_addoption(parser):
    parser.addoption(
        "--disturb",
        type=int,
        metavar="SEED",
        help="begin arms and wires of remodel_sim 1e-9 m and 1e-9 rad beside their places",
    )


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    """Disturb the whole test, with what its fixtures build."""
    seed = item.config.getoption("disturb", None)
    if seed is None or item.get_closest_marker("repeats"):
        return (yield)
    with disturbed(seed):
        return (yield)


@pytest.fixture(autouse=True)
def is_marked(request, monkeypatch):
    """Refuse a test that simulates physics without the marker by which `make physics` finds it."""
    if request.node.get_closest_marker("physics"):
        return

    def refuse(world):
        raise AssertionError("it steps the physics: mark it `physics`")

    monkeypatch.setattr(World, "step", refuse)


@pytest.fixture(autouse=True)
def pushes():
    """Records of the pushes and pulls of a test; none may go far beyond its force limit.

    What 99 % of them must keep to, `make evaluate-abilities` measures: now and then the wire jerks
    between the pads.
    """
    with recorded() as records:
        yield records
    beyond = [(r.limit, r.peak, r.loop.peak) for r in records if r.peak > 1.5 * r.allowed]
    assert not beyond, f"limit, peak and peak as reported [N]: {beyond}"


@pytest.fixture
def cell():
    """A freshly built cell."""
    made = Cell(SimulatedPlant(panel(), seed=1))
    yield made
    made.close()
