"""The kinematics of a portal."""

import math
from dataclasses import replace

import numpy as np
import pytest
from panels import example

from remodel_sim.physics.plant import SimulatedPlant
from remodel_skills.belief_state import Grip
from remodel_skills.cell import Cell
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.motion import PEAK_OVER_MEAN
from remodel_skills.primitives.motions import move_to, swing_to
from remodel_work.edge.cell_file import read_cell
from remodel_work.panel import WireEnd
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.portal import TURN_RATE

MOTION = read_parameters().parameters.motion


def cell_with_a_wire():
    household = example("household")
    cell = Cell(SimulatedPlant(household, design=read_cell("two_arms_cabinet")))
    cell.feed(household.wires[0].id, "")
    return cell


@pytest.mark.physics
def test_a_hand_goes_around_one_that_holds_a_wire():
    cell = cell_with_a_wire()
    one, other = cell.contexts.values()
    for context, place in (
        (one, ToolPose(0.39, 0.383, 0.1, 0.0)),
        (other, ToolPose(0.2, 0.059, 0.069, math.pi / 2)),
    ):
        cell.run(move_to(context, replace(place, z=0.35), MOTION.free_speed_m_s), context.name)
        cell.run(move_to(context, place, MOTION.free_speed_m_s), context.name)
    other.belief.grip = Grip(WireEnd.B, 0.01, 0.0, 0.0, other.commanded)
    target = ToolPose(0.318, -0.357, 0.088, -math.pi / 2)
    cell.run(swing_to(one, target), one.name)
    assert np.allclose(one.device.arm.tool.position, target.position, atol=1e-3)
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
@pytest.mark.parametrize("holds_a_wire", [False, True])
def test_an_empty_hand_turns_faster_than_one_with_a_wire(holds_a_wire):
    cell = cell_with_a_wire()
    context, world = cell.context, cell.plant.world
    before, here = world.steps, context.commanded
    if holds_a_wire:
        context.belief.grip = Grip(WireEnd.A, 0.01, 0.0, 0.0, here)
    cell.run(move_to(context, replace(here, yaw=here.yaw + math.pi / 2), MOTION.free_speed_m_s))
    seconds = (world.steps - before) * world.time_step - MOTION.force_still_s
    rate = MOTION.wire_turn_rate_rad_s if holds_a_wire else TURN_RATE
    assert seconds == pytest.approx(PEAK_OVER_MEAN * math.pi / 2 / rate, abs=0.05)
    cell.close()
