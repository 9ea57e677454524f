"""The force limit of a push holds, for what the wrist feels in every step of the physics.

Every test of this folder that runs a cell checks each push and pull for a coarse excess, see
conftest.py; here are those with the highest stakes: an opening that is blocked, and the lowest and
highest limits.
"""

import re

import pytest
from panels import example, panel
from place_wire import insert

from remodel_sim.physics import plant
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills.cell import Cell
from remodel_skills.edge.parameter_files import read_parameters
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.panel import WireEnd

PARAMETERS = read_parameters().parameters
WIRES = PARAMETERS.wire

pytestmark = pytest.mark.physics

# In a terminal of 14 mm, 43 ends were seated 13.5 mm deep or more [m].
NEAR_BOTTOM_M = 0.0115
FORCE_LIMIT_N = 14.0


@pytest.fixture
def cell_of():
    cells = []

    def make(rate_hz):
        cells.append(Cell(SimulatedPlant(panel(), seed=1, rate_hz=rate_hz)))
        return cells[-1]

    yield make
    for cell in cells:
        cell.close()


def push(cell, limit, wire=None):
    """Insert end a of a wire, by default the first one."""
    wire = wire or cell.plant.panel.wires[0]
    component, terminal = wire.goes_to(WireEnd.A)
    channel = cell.plant.panel.channel_in_front_of(
        cell.plant.panel.panel_from_socket(component, terminal).position
    )
    cell.feed(wire.id, channel.id)
    socket = cell.plant.world_from_socket(component, terminal)
    return insert(cell, wire.id, WireEnd.A, component, terminal, socket, force=limit)


@pytest.mark.slow
@pytest.mark.parametrize(("limit", "rate_hz"), [(4.0, 500.0), (25.0, 240.0)])
def test_an_end_is_seated_with_the_force_that_was_allowed(cell_of, pushes, limit, rate_hz):
    cell = cell_of(rate_hz)
    inserted = push(cell, limit)
    (truth,) = ground_truth(cell.plant, [cell.plant.panel.wires[0].id])
    assert truth.a.seated
    *until_in, record = pushes
    assert [before.limit for before in until_in] == (
        [limit, WIRES.feel_n] if limit > WIRES.gentle_above_n else []
    )
    assert limit <= inserted.peak_force <= record.allowed
    # The wire may jerk between the pads once more when the push has ended.
    assert record.peak == pytest.approx(inserted.peak_force, rel=0.12)


@pytest.mark.slow
@pytest.mark.parametrize(("limit", "rate_hz"), [(4.0, 240.0), (14.0, 500.0)])
def test_a_blocked_opening_is_pressed_no_harder_than_allowed(cell_of, pushes, limit, rate_hz):
    cell = cell_of(rate_hz)
    cell.plant.block_socket(*cell.plant.panel.wires[0].goes_to(WireEnd.A))
    with pytest.raises(AbilityError) as caught:
        push(cell, limit)
    assert caught.value.code is Code.INSERTION_JAMMED
    *felt, pushed = pushes
    assert caught.value.found["peak_force"] <= pushed.allowed
    assert all(record.peak <= record.allowed for record in pushes)
    first = [limit, WIRES.feel_n] if limit > WIRES.gentle_above_n else [limit]
    feel = [limit, WIRES.feel_n]
    assert [record.limit for record in felt] == [*first, *feel * len(PARAMETERS.terminal.feels_m)]
    assert pushed.limit == limit


# A wire that is pushed so hard at an obstacle slides in the grip, or buckles behind the hand into a
# loop that draws its end out of the fingers: the last bit decides.
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "seed", "rate_hz", "limit"), [("W3", 5, 240.0, 18.0), ("W1", 6, 500.0, 25.0)]
)
def test_an_end_that_slides_in_the_grip_at_an_obstacle_is_not_reported_at_the_bottom(
    name, seed, rate_hz, limit
):
    board = example("panel")
    cell = Cell(SimulatedPlant(board, seed=seed, rate_hz=rate_hz))
    wire = board.wire(name)
    cell.plant.block_socket(*wire.goes_to(WireEnd.A))
    with pytest.raises(AbilityError) as caught:
        push(cell, limit, wire)
    if caught.value.code is Code.INSERTION_JAMMED:
        (depth,) = re.findall(r"at (\d+\.\d) of 14\.0 mm", str(caught.value))
        assert 1e-3 * float(depth) == pytest.approx(plant.PLUG_FROM_M, abs=0.0011)
    else:
        assert caught.value.code is Code.GRASP_SLIPPED
    cell.close()


@pytest.mark.slow
def test_an_obstacle_just_before_the_bottom_is_not_taken_for_it(cell_of, monkeypatch):
    monkeypatch.setattr(plant, "PLUG_FROM_M", NEAR_BOTTOM_M)
    cell = cell_of(240.0)
    cell.plant.block_socket(*cell.plant.panel.wires[0].goes_to(WireEnd.A))
    with pytest.raises(AbilityError, match=r"at 11\.\d of 14\.0 mm") as caught:
        push(cell, FORCE_LIMIT_N)
    assert caught.value.code is Code.INSERTION_JAMMED
