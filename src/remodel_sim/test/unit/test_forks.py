"""Wires that are let down into the forks of a formboard: what fits the cell, and how it goes."""

import math

import numpy as np
import pytest
from panels import example
from place_wire import do, fix, insert, locate

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import share_in_ducts
from remodel_skills.abilities.inserting import FixGoal, InsertGoal, fix_cable, insert_cable
from remodel_skills.abilities.picking import DetectGoal, PickGoal, detect_cable, pick_cable
from remodel_skills.abilities.route_wire import RouteGoal, route_wire
from remodel_skills.cell import Cell
from remodel_states.core.codes import Code
from remodel_work.board_rules import GRASP_M
from remodel_work.cell.presenting import LEAST_GRASP_M
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, WireEnd

DESIGN = read_cell("two_arms_formboard")
HARNESS = example("harness")
WIRE = "W1.4"
HOLDER = "robot_2"
# How far the other end's insertion may pull an end back, and how far it may not [m]; in how many
# steps it is pushed here.
SLID_M, SLID_TOO_FAR_M, SLIDING_STEPS = 0.006, 0.012, 120


def path_of(cell):
    """Return the wire's route as the use case gives it to RouteWire."""
    (ax, ay, _), (bx, by, _) = cell.plant.panel.wire(WIRE).route
    yaw = math.atan2(by - ay, bx - ax)
    return tuple(BOARD @ Pose.level(x, y, 0.06, yaw) for x, y in ((ax, ay), (bx, by)))


def route(cell):
    holder = cell.contexts[HOLDER]
    goal = RouteGoal(HOLDER, WIRE, path_of(cell))
    return cell.run(route_wire(holder, goal), HOLDER)


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_is_let_down_into_its_forks_once_its_other_end_is_fixed_and_is_seen_there():
    cell = Cell(SimulatedPlant(HARNESS, design=DESIGN, seed=1))
    wire = cell.plant.panel.wire(WIRE)
    holder = cell.contexts[HOLDER]
    cell.feed(WIRE, "")
    do(cell, detect_cable, DetectGoal(WIRE))
    key = wire.goes_to(WireEnd.A)
    socket = locate(cell, *key)
    pick = PickGoal(HOLDER, WIRE, WireEnd.B, 0.0)
    cell.run(pick_cable(holder, pick), HOLDER)
    with pytest.raises(AbilityError, match="end a of 'W1\\.4' is not fixed") as raised:
        route(cell)
    assert raised.value.code is Code.INVALID_GOAL
    cell.close()

    cell = Cell(SimulatedPlant(HARNESS, design=DESIGN, seed=1))
    holder = cell.contexts[HOLDER]
    cell.feed(WIRE, "")
    do(cell, detect_cable, DetectGoal(WIRE))
    other = wire.goes_to(WireEnd.B)
    other_socket = locate(cell, *other)
    insert(cell, WIRE, WireEnd.A, *key, socket)
    fix(cell, WIRE, *key, 5.0)
    do(cell, detect_cable, DetectGoal(WIRE))
    cell.run(pick_cable(holder, pick), HOLDER)
    assert route(cell).message == f"{WIRE} laid into F1, F2, F3"
    # In front of its opening, by the physics.
    opening = BOARD @ cell.plant.panel.panel_from_socket(*wire.goes_to(WireEnd.B))
    tip = opening.inverse().apply(cell.plant.live.cable.nodes()[-1])
    assert -0.015 < tip[0] < 0
    assert abs(tip[1]) < 0.003
    push = InsertGoal(HOLDER, WIRE, WireEnd.B, *other, other_socket, 8.0)
    cell.run(insert_cable(holder, push), HOLDER)
    done = cell.run(fix_cable(holder, FixGoal(HOLDER, WIRE, *other, 5.0)), HOLDER)
    assert done.message.endswith("; the wire lies in F1, F2, F3")
    assert share_in_ducts(cell.plant, WIRE) == 1.0
    cell.close()


def push_back(cell, link, far):
    """Push the last link of end b back into its clips, along y, so far [m]."""
    bullet, cable = cell.plant.world.bullet, cell.plant.live.cable
    start, turn = cable.link_pose(link)
    holder = bullet.createConstraint(
        *link, -1, -1, bullet.JOINT_FIXED, [0, 0, 0],
        [0, 0, 0], start.tolist(), [0, 0, 0, 1], turn.tolist(),
    )  # fmt: skip
    for step in range(1, SLIDING_STEPS + 1):
        at = start - np.array([0.0, far * step / SLIDING_STEPS, 0.0])
        bullet.changeConstraint(holder, at.tolist(), turn.tolist(), maxForce=500)
        cell.plant.step()
    bullet.removeConstraint(holder)


@pytest.mark.physics
def test_an_end_that_has_slid_back_into_its_clips_is_grasped_before_them():
    cell = Cell(SimulatedPlant(HARNESS, design=DESIGN, seed=1))
    cell.feed(WIRE, "")
    cable = cell.plant.live.cable
    push_back(cell, cable.ferrule(WireEnd.B), SLID_M)
    do(cell, detect_cable, DetectGoal(WIRE))
    pick = PickGoal(HOLDER, WIRE, WireEnd.B, 0.0)
    cell.run(pick_cable(cell.contexts[HOLDER], pick), HOLDER)
    tool, tip = cell.contexts[HOLDER].device.arm.tool, cable.tip(WireEnd.B)[0]
    assert LEAST_GRASP_M - 0.002 < tip[1] - tool.y < GRASP_M - 0.001
    cell.close()


@pytest.mark.physics
def test_fingers_that_meet_the_clips_do_not_take_the_wire_out_of_them():
    cell = Cell(SimulatedPlant(HARNESS, design=DESIGN, seed=1))
    cell.feed(WIRE, "")
    push_back(cell, cell.plant.live.cable.ferrule(WireEnd.B), SLID_TOO_FAR_M)
    do(cell, detect_cable, DetectGoal(WIRE))
    pick = PickGoal(HOLDER, WIRE, WireEnd.B, 0.0)
    with pytest.raises(AbilityError, match="the fingers met something") as caught:
        cell.run(pick_cable(cell.contexts[HOLDER], pick), HOLDER)
    assert caught.value.code is Code.GRASP_MISSED
    assert cell.contexts[HOLDER].belief.grip is None
    cell.close()
