"""A cell that is killed finds again what a real one would: placed wires, and the time."""

import place_wire as do
import pytest
from panels import panel
from remodel_msgs.msg import FixCableGoal
from stored import put, put_live

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills.abilities.ability import cell_abilities
from remodel_skills.cell import Cell
from remodel_skills.edge.cell_memory import CellMemory
from remodel_skills.primitives.picking_up import take_up
from remodel_skills.ros.owner import Job
from remodel_states.edge.exported_tables import read_abilities
from remodel_states.serving import RunningGoal
from remodel_work.panel import BOARD, WireEnd

OTHER = panel(name="other")


@pytest.fixture
def memory(tmp_path):
    memory = CellMemory(tmp_path / "cell")
    yield memory
    memory.close()


@pytest.mark.physics
def test_a_placed_wire_is_there_after_the_cell_was_killed(memory):
    cell = Cell(SimulatedPlant(panel(), seed=1), memory=memory)
    put(cell, "W1", *WireEnd)
    take_up(cell.context, "W1")
    cell.come_to_rest()
    before = ground_truth(cell.plant, ["W1"])
    assert [truth.placed for truth in before] == [True]
    cell.close()

    again = Cell(SimulatedPlant(OTHER, seed=1), memory=memory)
    assert again.plant.parked == {}
    again.load(panel(), keep=True)
    try:
        assert ground_truth(again.plant, again.context.belief.fed) == before
        assert again.plant.parked["W1"].nodes == pytest.approx(cell.plant.parked["W1"].nodes)
        assert again.context.belief.occupied[("X1", "1")] == ("W1", WireEnd.A)
        again.feed("W2", "A")
        assert ground_truth(again.plant, ["W1"]) == before, "the next wire lies beside it"
    finally:
        again.close()


class KilledError(Exception):
    """The process ends here."""


class DyingHandle:
    """A goal's handle in a process that is killed as soon as the result is published."""

    def __init__(self, goal):
        self._goal = goal

    def get_goal(self):
        return self._goal

    def publish_feedback(self, feedback):
        pass

    def set_succeeded(self, result, text):
        raise KilledError(text)


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_whose_last_end_is_reported_fixed_is_there_after_a_kill_at_that_moment(memory):
    cell = Cell(SimulatedPlant(panel(), seed=1), memory=memory)
    put_live(cell, "W1")
    do.carry(cell, "W1", "A")
    do.insert(cell, "W1", WireEnd.B, "X2", terminal="1", socket=do.locate(cell, "X2", "1"))
    goal = FixCableGoal("17:fix b", do.ROBOT, "W1", "X2", "1", 10.0, 60.0)
    fix = cell_abilities()["FixCable"]
    running = RunningGoal(read_abilities()["FixCable"], DyingHandle(goal), lambda: 0.0)
    job = Job(
        fix,
        running,
        [cell.context],
        fix.parse(goal, BOARD),
        keep=cell.keep,
        finish=lambda end: end(),
    )
    with pytest.raises(KilledError, match="end b of W1 fixed"):
        while not job.step():
            cell.plant.tick()
    cell.close()

    again = Cell(SimulatedPlant(panel(), seed=1), memory=memory)
    try:
        (truth,) = ground_truth(again.plant, again.context.belief.fed)
        assert truth.wire_id == "W1" and truth.placed
        assert again.context.belief.occupied[("X2", "1")] == ("W1", WireEnd.B)
    finally:
        again.close()
