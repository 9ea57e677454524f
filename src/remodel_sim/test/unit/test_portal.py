"""The kinematics of a portal."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from remodel_sim.physics.plant import SimulatedPlant
from remodel_skills.belief_state import Grip
from remodel_skills.cell import Cell
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.motion import PEAK_OVER_MEAN
from remodel_skills.primitives.motions import choose_flip, move_to, swing_to
from remodel_states.core.codes import Code
from remodel_states.edge.wire_material_file import read_wire_materials
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import AbilityError
from remodel_work.geometry import wrap_angle
from remodel_work.panel import WireEnd
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.fingers import PANDA_FINGERS
from remodel_work.robot.portal import TURN_RATE, Portal
from remodel_work.ros.panel_message import read_panel

MOTION = read_parameters().parameters.motion

CONFIG = Path(__file__).parents[2] / "config"
PORTAL = Portal((0.5, 0.0, 0.0, math.pi / 2), (-0.4, -0.6, 0.0), (0.4, 0.6, 0.9), PANDA_FINGERS)


@pytest.mark.parametrize(
    "tool", [ToolPose(0.5, 0.0, 0.1, 0.0), ToolPose(0.2, 0.3, 0.8, 4.0), ToolPose(0.9, -0.3, 0, -1)]
)
def test_joints_bring_the_tool_where_they_were_asked_for(tool):
    again = PORTAL.tool_of(PORTAL.joints_for(tool))
    assert np.allclose(again.position, tool.position)
    assert math.remainder(again.yaw - tool.yaw, 2 * math.pi) == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("tool", "joint"),
    [
        (ToolPose(0.5, 0.5, 0.1, 0.0), "portal_x"),
        (ToolPose(1.2, 0.0, 0.1, 0.0), "portal_y"),
        (ToolPose(0.5, 0.0, 1.0, 0.0), "portal_z"),
    ],
)
def test_a_place_out_of_reach_is_refused_with_the_joint(tool, joint):
    with pytest.raises(AbilityError, match=f"{joint} would stand at .*, allowed") as caught:
        PORTAL.joints_for(tool)
    assert caught.value.code is Code.UNREACHABLE
    assert not PORTAL.reaches(tool)


@pytest.mark.parametrize("then_yaw", [math.pi, 0.0, math.pi / 2, -math.pi / 2])
@pytest.mark.parametrize("tip_yaw", [math.pi / 2, -math.pi / 2, 3.0])
def test_a_wire_is_held_so_that_the_hand_turns_it_the_short_way(tip_yaw, then_yaw):
    flip = choose_flip(PORTAL, (0.3, 0.1), tip_yaw, (0.6, 0.1), then_yaw)
    first = wrap_angle(tip_yaw - flip)
    turned = first + wrap_angle(then_yaw - tip_yaw)
    assert PORTAL.canonical_yaw(0.6, 0.1, turned) == pytest.approx(turned)
    assert math.remainder(turned + flip - then_yaw, 2 * math.pi) == pytest.approx(0.0)


def test_a_hand_leads_a_wire_around_three_corners():
    yaws = [PORTAL.base[3] + 0.75 * math.pi - turn for turn in np.linspace(0, 1.5 * math.pi, 7)]
    assert [PORTAL.canonical_yaw(0.5, 0.0, yaw) for yaw in yaws] == pytest.approx(yaws)


def cell_with_a_wire():
    household = read_panel(CONFIG / "household.yaml", read_wire_materials())
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
