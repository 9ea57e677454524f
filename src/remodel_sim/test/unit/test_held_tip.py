"""InsertCable with an end that turned in the grip, in the cell of two heads."""

from dataclasses import replace

import pytest
from panels import example
from place_wire import do, locate

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills.abilities.inserting import InsertGoal, insert_cable
from remodel_skills.abilities.picking import DetectGoal, PickGoal, detect_cable, pick_cable
from remodel_skills.cell import Cell
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.primitives.pushing import bring_before, push_in
from remodel_work.edge.cell_file import read_cell
from remodel_work.panel import WireEnd

FEEL_N = read_parameters().parameters.wire.feel_n

pytestmark = pytest.mark.physics

HOLDER = "robot_2"


class Held:
    """A cell whose second robot holds an end, `above` [m] where it takes the tip to be."""

    def __init__(self, wire, end, above):
        panel = example("household")
        self.cell = cell = Cell(SimulatedPlant(panel, design=read_cell("two_arms_cabinet"), seed=1))
        self.holder, self.wire, self.end = cell.contexts[HOLDER], wire, end
        cell.feed(wire, "")
        do(cell, detect_cable, DetectGoal(wire))
        self.key = panel.wire(wire).goes_to(end)
        self.socket = locate(cell, *self.key)
        cell.run(pick_cable(self.holder, PickGoal(HOLDER, wire, end, 0.0)), HOLDER)
        grip = self.holder.belief.grip
        self.holder.belief.grip = replace(grip, height=grip.height - above)

    def insert(self):
        goal = InsertGoal(HOLDER, self.wire, self.end, *self.key, self.socket, 14.0)
        self.cell.run(insert_cable(self.holder, goal), HOLDER)

    def is_seated(self):
        (truth,) = ground_truth(self.cell.plant, [self.wire])
        return getattr(truth, self.end.value).seated


@pytest.fixture
def hold():
    held = []

    def make(*args):
        held.append(Held(*args))
        return held[-1]

    yield make
    for each in held:
        each.cell.close()


@pytest.mark.slow
@pytest.mark.parametrize("above", [0.0045, -0.0055])
def test_a_tip_that_is_not_where_the_hand_holds_it_is_seen_and_brought_to_its_opening(
    hold, pushes, above
):
    held = hold("W8", WireEnd.A, above)
    held.insert()
    assert held.is_seated()
    limits = [push.limit for push in pushes]
    assert set(limits) == {14.0, FEEL_N}
    assert 2 <= limits.count(14.0) <= 3, "the first push misses the opening"


# Which of the three comes of a tip beside its opening, the last bit decides: it jumps in, the face
# stops it, or it rubs along the face. In 28 pushes, disturbed by 1e-9 m, one that was given up had
# met 2.8 N or more in the mean, one that was seated at most 1.58 N.
@pytest.mark.slow
@pytest.mark.parametrize("above", [-0.003, 0.004])
def test_a_push_reports_an_end_in_its_opening_only_where_it_is(hold, above):
    held = hold("W107", WireEnd.B, above)
    context, bottom = held.holder, 0.014

    def push():
        yield from bring_before(context, held.socket)
        return (yield from push_in(context, held.socket, bottom, 14.0, until_in=6.0))

    found = held.cell.run(push(), HOLDER)
    assert held.is_seated() == (not found.rubs and found.depth >= bottom / 2)
    if found.rubs:
        assert found.depth < bottom / 2 + 0.001, "it is pushed no further than halfway"
