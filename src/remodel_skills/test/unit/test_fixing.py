"""What FixCable makes of a clamp that closes on nothing: on a scripted device."""

import math
from dataclasses import replace

import pytest
from panels import with_springs
from refusals import refused
from scripted_device import COMPONENT, PANEL, PARAMETERS, SOCKET, TERMINAL, before_the_opening

from remodel_skills.abilities.inserting import FixGoal, fix_cable
from remodel_skills.belief_state import EndState
from remodel_skills.primitives.pushing import tool_before
from remodel_skills.robot_context import run
from remodel_states.core.codes import Code
from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd

GOAL = FixGoal("robot_1", "W1", "X1", "1", pull_test_force=5.0)
STIFF_N_M = 2e5


class Clamp:
    """A clamp that stops on what is in its terminal, or on nothing."""

    def __init__(self, *, stops):
        self.stops = stops

    def close_clamp(self, component_id, terminal_id):
        return self.stops


# The same board, held the other way round: its openings are where they were.
TURNED = replace(
    PANEL,
    components=(replace(COMPONENT, pose=(-COMPONENT.pose[0], 0.0, math.pi)),),
    world_from_panel=PANEL.world_from_panel @ Pose.level(0.0, 0.0, 0.0, math.pi),
)


def fixed(*, stops, insertion_force=0.0, panel=PANEL, engaged=SOCKET, seated=True):
    """Fix an end at its bottom, which a spring holds; return the context."""
    context, arm = before_the_opening(
        lambda depth: -STIFF_N_M * max(0.0, TERMINAL.depth - depth),
        with_springs(panel, insertion_force),
    )
    context.device = replace(context.device, fixture=Clamp(stops=stops))
    context.drive(tool_before(SOCKET, context.belief.grip, TERMINAL.depth))
    context.belief.engaged = engaged
    if seated:
        context.belief.seat(WireEnd.A, ("X1", "1"))
    run(arm.tick, fix_cable(context, GOAL))
    return context


def test_an_end_whose_clamp_stops_on_it_is_fixed_and_released():
    context = fixed(stops=True)
    assert context.belief.ends[WireEnd.A] is EndState.FIXED
    assert context.belief.grip is None
    assert context.commanded.z >= PARAMETERS.motion.travel_z_m - 1e-6


@pytest.mark.parametrize("panel", [PANEL, TURNED])
def test_an_end_whose_opening_was_not_seen_is_pulled_out_of_where_the_panel_has_it(panel):
    context = fixed(stops=True, panel=panel, engaged=None)
    assert context.belief.ends[WireEnd.A] is EndState.FIXED


def test_a_spring_clamp_is_not_closed_but_pulled_at():
    context = fixed(stops=False, insertion_force=8.0)
    assert context.belief.ends[WireEnd.A] is EndState.FIXED


def test_a_clamp_that_closes_on_nothing_is_not_seated():
    with refused(Code.NOT_SEATED, "met nothing: the end is not deep enough"):
        fixed(stops=False)


def test_a_spring_clamp_that_no_push_has_filled_is_not_seated():
    with refused(Code.NOT_SEATED, "no push has brought the end to the bottom of 'X1/1'"):
        fixed(stops=True, insertion_force=8.0, seated=False)
