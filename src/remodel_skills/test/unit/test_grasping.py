"""What closed fingers say about what is between them: on a scripted device, in milliseconds."""

import math

import pytest
from refusals import refused
from scripted_device import HOME, PARAMETERS, TERMINAL, TICK_S, WIRE, before_the_opening

from remodel_skills.belief_state import Grip
from remodel_skills.primitives.grasping import check_grip, close_on_wire, inside_terminal
from remodel_skills.robot_context import run
from remodel_states.core.codes import Code
from remodel_work.panel import WireEnd

GRIP = Grip(WireEnd.A, 0.02, 0.0, 0.0, HOME)


def hand_that_closes_on(gap):
    """Return the context of an empty hand near the plate whose fingers stop so far apart."""
    context, arm = before_the_opening(lambda depth: 0.0)
    context.belief.grip = None
    context.drive(HOME.at(z=0.05))
    context.device.gripper.stops_at = gap
    return context, arm


def test_a_wire_between_the_fingers_is_held():
    context, arm = hand_that_closes_on(WIRE.diameter - 1e-4)
    run(arm.tick, close_on_wire(context, GRIP))
    assert context.belief.grip is GRIP
    assert context.belief.picked_at[WireEnd.A] is GRIP


@pytest.mark.parametrize(
    ("gap", "words"), [(0.0, "it is not between them"), (0.008, "the fingers met something 8.0 mm")]
)
def test_a_hand_that_holds_no_wire_opens_and_rises(gap, words):
    context, arm = hand_that_closes_on(gap)
    with refused(Code.GRASP_MISSED, words):
        run(arm.tick, close_on_wire(context, GRIP))
    assert context.belief.grip is None
    assert context.device.gripper.gap == 2 * PARAMETERS.tool.open_m
    assert arm.tool.z == pytest.approx(PARAMETERS.motion.travel_z_m, abs=1e-6)


def test_fingers_that_begin_to_close_late_are_waited_for():
    context, arm = hand_that_closes_on(WIRE.diameter)
    gripper = context.device.gripper
    gripper.opened = 2 * PARAMETERS.tool.open_m
    begun = []

    def tick():
        arm.tick()
        begun.append(gripper.gap)
        if len(begun) == math.ceil(0.8 * PARAMETERS.tool.fingers_still_s / TICK_S):
            gripper.opened = gripper.stops_at

    gripper.close_on = lambda thickness, slow_before: None
    run(tick, close_on_wire(context, GRIP))
    assert context.belief.grip is GRIP


def test_fingers_that_feel_nothing_have_lost_the_wire():
    context, arm = hand_that_closes_on(WIRE.diameter)
    run(arm.tick, close_on_wire(context, GRIP))
    check_grip(context)
    context.device.gripper.load = PARAMETERS.tool.held_load_n / 2
    with refused(Code.GRASP_SLIPPED):
        check_grip(context)
    assert context.belief.grip is None


def test_a_wire_is_as_deep_in_its_terminal_as_that_is():
    context, _ = hand_that_closes_on(WIRE.diameter)
    assert inside_terminal(context, WireEnd.A) == TERMINAL.depth
