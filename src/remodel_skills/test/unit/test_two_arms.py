"""Hands that share a cell keep out of each other's way: on scripted devices."""

import math
from dataclasses import replace

import numpy as np
import pytest
from panels import example, panel
from refusals import refused
from scripted_device import PARAMETERS, TICK_S, ScriptedPlant

from remodel_skills.belief_state import NO_CHANNEL, Grip
from remodel_skills.cell import Cell
from remodel_skills.motion import PEAK_OVER_MEAN
from remodel_skills.primitives.motions import move_to, swing_to
from remodel_skills.primitives.together import concurrently
from remodel_skills.robot_context import occupy, run
from remodel_states.core.codes import Code
from remodel_work.edge.cell_file import read_cell
from remodel_work.panel import WireEnd
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.portal import TURN_RATE

MOTION = PARAMETERS.motion
CABINET = read_cell("two_arms_cabinet")


@pytest.fixture
def pandas():
    """Two Pandas that face each other, W1 fed."""
    cell = Cell(ScriptedPlant(panel(), read_cell("two_pandas")))
    cell.feed("W1", "A")
    yield cell
    cell.close()


@pytest.fixture
def portals():
    """Two portals over a household board, one of its wires fed."""
    household = example("household")
    cell = Cell(ScriptedPlant(household, CABINET))
    cell.feed(household.wires[0].id, NO_CHANNEL)
    yield cell
    cell.close()


def hold(context, end=WireEnd.B):
    context.belief.grip = Grip(end, 0.01, 0.0, 0.0, context.commanded)


def go(cell, context, place, speed=MOTION.free_speed_m_s):
    cell.run(move_to(context, place, speed), context.name)


def test_an_idle_empty_hand_makes_way_and_one_that_holds_a_wire_does_not(pandas):
    one, two = pandas.contexts.values()
    here = ToolPose(0.50, 0.20, 0.20, 0.0)
    there = ToolPose(0.50, 0.20, MOTION.travel_z_m, two.home.yaw)
    go(pandas, one, here)
    go(pandas, two, there)
    assert one.commanded == one.home
    go(pandas, two, two.home)
    go(pandas, one, here)
    hold(one)
    with refused(Code.ROBOT_IN_THE_WAY, r"robot_1 stands at .* place what it holds"):
        go(pandas, two, there)
    assert two.commanded == two.home, "nothing has moved"


def test_two_arms_in_each_others_way_do_not_wait_forever(pandas):
    one, two = pandas.contexts.values()
    go(pandas, one, ToolPose(0.50, -0.2, 0.2, 0.0))
    go(pandas, two, ToolPose(0.50, 0.2, 0.2, 3.0))
    crossing = concurrently(
        occupy([one], move_to(one, ToolPose(0.50, 0.2, 0.2, 0.0), 0.6)),
        occupy([two], move_to(two, ToolPose(0.50, -0.2, 0.2, 3.0), 0.6)),
    )
    with refused(Code.ROBOT_IN_THE_WAY, "in each other's way"):
        run(pandas.plant.tick, crossing)
    assert not one.busy and not two.busy


def test_a_hand_goes_around_one_that_holds_a_wire(portals):
    one, other = portals.contexts.values()
    for context, place in (
        (one, ToolPose(0.39, 0.383, 0.1, 0.0)),
        (other, ToolPose(0.2, 0.059, 0.069, math.pi / 2)),
    ):
        go(portals, context, replace(place, z=0.35))
        go(portals, context, place)
    hold(other)
    stands, target = other.commanded, ToolPose(0.318, -0.357, 0.088, -math.pi / 2)
    portals.plant.trace[one.name].clear()
    portals.run(swing_to(one, target), one.name)
    passed = np.array([tool.position for tool, _ in portals.plant.trace[one.name]])
    assert passed[-1] == pytest.approx(target.position, abs=1e-3)
    away = np.linalg.norm(passed[:, :2] - stands.position[:2], axis=1)
    assert away.min() > 2 * MOTION.robots_apart_m, "around the other hand, not through it"
    assert other.commanded == stands


@pytest.mark.parametrize("holds_a_wire", [False, True])
def test_an_empty_hand_turns_faster_than_one_with_a_wire(portals, holds_a_wire):
    context = portals.context
    if holds_a_wire:
        hold(context, WireEnd.A)
    here = context.commanded
    portals.plant.trace[context.name].clear()
    go(portals, context, replace(here, yaw=here.yaw + math.pi / 2))
    seconds = len(portals.plant.trace[context.name]) * TICK_S
    rate = MOTION.wire_turn_rate_rad_s if holds_a_wire else TURN_RATE
    assert seconds == pytest.approx(PEAK_OVER_MEAN * math.pi / 2 / rate, abs=0.05)
