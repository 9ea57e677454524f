"""Whole abilities by physics, without ROS."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import place_wire as do
import pytest
from fingerprint import fingerprint_elsewhere
from panels import example, panel
from refusals import refused
from stored import put_live

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills.abilities.inserting import InsertGoal
from remodel_skills.abilities.picking import PickGoal
from remodel_skills.cell import Cell
from remodel_states.core.codes import Code
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd

pytestmark = pytest.mark.physics


@pytest.mark.slow
def test_the_same_seed_and_goals_give_the_same_bits_in_two_processes():
    assert fingerprint_elsewhere() == fingerprint_elsewhere()


def test_a_board_that_a_cell_holds_elsewhere_is_wired_there():
    board = Pose.level(0.52, 0.01, 0.0, np.radians(4.0))
    made = Cell(
        SimulatedPlant(panel(), design=replace(read_cell(), world_from_panel=board), seed=7)
    )
    made.feed("W1", "A")
    socket = do.locate(made, "X1", "1")
    true = board @ made.plant.panel.panel_from_socket("X1", "1")
    assert np.linalg.norm(socket.position - true.position) < 1e-3
    do.insert(made, "W1", WireEnd.A, "X1", terminal="1", socket=socket)
    (truth,) = ground_truth(made.plant, ["W1"])
    assert truth.a.at == "X1/1"
    made.close()


def test_a_wire_that_lies_nowhere_is_not_taken_up_and_nothing_changes(cell):
    cell.feed("W1", "A")
    with refused(Code.WIRE_NOT_FED, "no piece of wire 'W2' lies in the cell; there are: W1; feed"):
        cell.plant.take_up("W2", {})
    assert cell.plant.is_at_hand("W1")


@pytest.mark.slow
def test_a_whole_wire_is_placed_by_physics(cell):
    do.place(cell, "W1")
    (truth,) = ground_truth(cell.plant, ["W1"])
    assert truth.placed
    assert (truth.a.at, truth.b.at) == ("X1/1", "X2/1")
    assert cell.plant.live is None, "a placed wire is parked"


@pytest.mark.slow
def test_six_millimetres_beside_the_opening_is_refused(cell):
    cell.feed("W1", "A")
    socket = do.locate(cell, "X1", "1")
    beside = Pose(socket.position + np.array([0.0, 0.006, 0.0]), socket.quaternion)
    with pytest.raises(AbilityError) as caught:
        do.insert(cell, "W1", WireEnd.A, "X1", terminal="1", socket=beside)
    assert caught.value.code is Code.INSERTION_MISALIGNED
    assert caught.value.found["depth"] < 0.003
    assert caught.value.found["peak_force"] >= 8.0
    assert "6.0 mm beside the axis of 'X1/1'" in str(caught.value)
    do.extract(cell, "W1", "X1", "1", socket=beside)
    assert cell.context.belief.grip is None
    do.insert(cell, "W1", WireEnd.A, "X1", terminal="1", socket=do.locate(cell, "X1", "1"))


@pytest.mark.slow
def test_an_opening_below_the_pose_of_the_goal_is_felt_for(cell):
    cell.feed("W1", "A")
    socket = do.locate(cell, "X1", "1")
    above = Pose(socket.position + np.array([0.0, 0.0, 0.006]), socket.quaternion)
    do.insert(cell, "W1", WireEnd.A, "X1", terminal="1", socket=above)
    (truth,) = ground_truth(cell.plant, ["W1"])
    assert truth.a.seated


@pytest.mark.slow
def test_a_blocked_socket_jams_and_yields_when_cleared(cell):
    cell.feed("W1", "A")
    cell.plant.block_socket("X1", "1")
    socket = do.locate(cell, "X1", "1")
    with pytest.raises(AbilityError) as caught:
        do.insert(cell, "W1", WireEnd.A, "X1", terminal="1", socket=socket)
    assert caught.value.code is Code.INSERTION_JAMMED
    do.extract(cell, "W1", "X1", "1", socket=socket)
    cell.plant.clear_socket("X1", "1")
    do.insert(cell, "W1", WireEnd.A, "X1", terminal="1", socket=socket)


@pytest.mark.slow
def test_a_weak_clamp_lets_the_end_slip_in_the_pull_test():
    weak = panel()
    first = weak.components[0]
    first = replace(
        first, terminals=tuple(replace(t, retention_force=3.0) for t in first.terminals)
    )
    made = Cell(SimulatedPlant(panel(components=(first, *weak.components[1:])), seed=1))
    made.feed("W1", "A")
    do.insert(made, "W1", WireEnd.A, "X1", terminal="1", socket=do.locate(made, "X1", "1"))
    with pytest.raises(AbilityError) as caught:
        do.fix(made, "W1", "X1", "1", pull=12.0)
    assert caught.value.code is Code.PULLED_OUT
    made.close()


@pytest.mark.slow
def test_a_fixed_end_can_be_extracted_and_inserted_again(cell):
    put_live(cell, "W1")
    socket = do.locate(cell, "X1", "1")
    do.extract(cell, "W1", "X1", "1", socket=socket)
    (truth,) = ground_truth(cell.plant, ["W1"])
    assert truth.a.at == ""
    do.insert(cell, "W1", WireEnd.A, "X1", terminal="1", socket=socket)


@pytest.mark.slow
def test_a_stopped_ability_leaves_a_scene_that_the_next_one_can_use(cell):
    cell.feed("W1", "A")
    socket = do.locate(cell, "X1", "1")
    goal = InsertGoal(
        robot_name=do.ROBOT,
        cable_id="W1",
        end=WireEnd.A,
        component_id="X1",
        terminal_id="1",
        socket=socket,
        force_limit=8.0,
    )
    steps = do.insert_cable(cell.context, goal)
    while cell.context.progress.message != "pushing":
        next(steps)
        for _ in range(cell.plant.steps_per_tick):
            cell.plant.step()
    for _ in range(10):
        next(steps)
    steps.close()
    assert cell.context.belief.grip is not None
    do.insert(cell, "W1", WireEnd.A, "X1", terminal="1", socket=socket)


def left_behind(cell, wire, channel="A"):
    with pytest.raises(AbilityError) as caught:
        cell.feed(wire, channel)
    assert caught.value.code is Code.WIRE_LEFT_BEHIND
    return str(caught.value)


@pytest.mark.slow
def test_no_piece_is_fed_beside_another_one_of_the_same_wire(cell):
    cell.feed("W1", "A")
    do.do(cell, do.pick_cable, PickGoal(do.ROBOT, "W1", WireEnd.A, 0.0))
    do.lay_down(cell, "W1")
    touched = cell.plant.live
    assert "moved or connected" in left_behind(cell, "W1")
    assert cell.plant.live is touched
    cell.feed("W2", "A")
    assert "left on the panel" in left_behind(cell, "W1")
    assert set(cell.plant.parked) == {"W1"} and cell.plant.live.wire.id == "W2"


@pytest.mark.slow
def test_a_wire_is_placed_over_one_that_lies_in_its_channel():
    board = example("panel")
    cell = Cell(SimulatedPlant(board, seed=1))
    do.place(cell, "W1")
    do.place(cell, "W2")
    assert all(truth.placed for truth in ground_truth(cell.plant, ["W1", "W2"]))
    one, other = (dense(cell.plant.parked[wire].nodes) for wire in ("W1", "W2"))
    nearest = np.linalg.norm(one[:, None] - other, axis=2).min()
    thickness = board.wire("W1").radius + board.wire("W2").radius
    assert 0.6 * thickness < nearest < 2 * thickness, "they touch, and do not pass through"
    cell.close()


def dense(nodes):
    """Return points along a wire's nodes (n, 3), some millimetres apart."""
    parts = [np.linspace(a, b, 12, endpoint=False) for a, b in pairwise(nodes)]
    return np.concatenate(parts)
