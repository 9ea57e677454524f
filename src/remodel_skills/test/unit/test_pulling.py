"""How pulls end, by what the wrist feels: on a scripted device, in milliseconds."""

from contextlib import nullcontext

import pytest
from refusals import refused
from scripted_device import PARAMETERS, SOCKET, TERMINAL, before_the_opening

from remodel_skills.belief_state import EndState
from remodel_skills.primitives.force_motion import pull_out, pull_test
from remodel_skills.primitives.pushing import tool_before
from remodel_skills.robot_context import run
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.layout import STANDOFF_M
from remodel_work.panel import WireEnd

BOTTOM = TERMINAL.depth
PULL_N, MOST_N = 5.0, 25.0


def held(newtons_per_metre):
    """An end that is held by a spring."""
    return lambda depth: -newtons_per_metre * max(0.0, BOTTOM - depth)


def sliding(newtons):
    """An end that slides, up to the face of its terminal."""
    return lambda depth: -newtons * (0.0 < depth < BOTTOM - 1e-5)


def at_the_bottom(feels):
    """Return the context of a robot whose held end is at its bottom, and its arm."""
    context, arm = before_the_opening(feels)
    context.drive(tool_before(SOCKET, context.belief.grip, BOTTOM))
    arm.tick()
    return context, arm


def test_an_end_in_a_closed_clamp_passes_the_pull_test():
    context, arm = at_the_bottom(held(2e5))
    start = context.commanded
    slip = run(arm.tick, pull_test(context, SOCKET, PULL_N, "X1/1"))
    assert slip < PARAMETERS.terminal.max_slip_m / 3
    assert context.commanded == start, "the hand went back"
    assert max(map(abs, arm.forces)) <= 1.15 * PULL_N + 0.5


WIRE_N = 6.0  # a thick wire, bent behind the hand


@pytest.mark.parametrize(
    ("feels", "is_held"), [(held(2e5), True), (sliding(3.0), False)], ids=["held", "slides"]
)
def test_what_the_wire_behind_the_hand_pulls_with_is_no_pull_at_its_clamp(feels, is_held):
    context, arm = at_the_bottom(lambda depth: feels(depth) - WIRE_N)
    for _ in range(20):
        arm.tick()
    with nullcontext() if is_held else pytest.raises(AbilityError):
        run(arm.tick, pull_test(context, SOCKET, PULL_N, "X1/1"))
    at_the_clamp = -min(arm.forces) - WIRE_N
    assert at_the_clamp <= 1.15 * PULL_N + 0.5
    assert at_the_clamp >= (PULL_N - 1.0 if is_held else 0.0)


@pytest.mark.parametrize(
    "feels", [sliding(3.0), held(500.0), held(1250.0)], ids=["slides", "gives", "creeps"]
)
def test_an_end_that_moves_under_the_pull_is_pulled_out(feels):
    context, arm = at_the_bottom(feels)
    with refused(Code.PULLED_OUT) as caught:
        run(arm.tick, pull_test(context, SOCKET, PULL_N, "X1/1"))
    assert caught.value.found["slip"] > 1e-3


def test_an_end_comes_out_with_the_force_that_holds_it():
    context, arm = at_the_bottom(sliding(6.0))
    context.belief.engaged = SOCKET
    peak = run(arm.tick, pull_out(context, SOCKET, MOST_N))
    assert peak == pytest.approx(6.0, abs=0.5)
    assert context.belief.engaged is None
    tip = SOCKET.inverse().apply(arm.tool.position)[0] + context.belief.grip.distance
    assert tip == pytest.approx(-STANDOFF_M, abs=1e-3)


def test_an_end_that_does_not_come_out_is_released_where_it_was():
    context, arm = at_the_bottom(held(2e4))
    context.belief.engaged = SOCKET
    start = context.commanded
    with refused(Code.EXTRACTION_STUCK, "'X1/1' does not come out at 25 N") as caught:
        run(arm.tick, pull_out(context, SOCKET, MOST_N))
    assert caught.value.found["peak_force"] <= 1.15 * MOST_N + 0.5
    end, terminal = WireEnd.A, ("X1", "1")
    assert context.belief.ends[end] is EndState.SEATED
    assert context.belief.occupied[terminal] == ("W1", end)
    assert context.belief.grip is None
    assert context.belief.engaged is None
    rise = context.commanded.position - start.position
    assert rise == pytest.approx([0.0, 0.0, rise[2]])
    assert context.commanded.z >= PARAMETERS.motion.travel_z_m


def test_an_end_passes_the_pull_test_although_the_controller_is_late_with_its_steps():
    context, arm = at_the_bottom(held(6e4))
    ticks = 0

    def tick():
        nonlocal ticks
        ticks += 1
        # Longer than a motion may stall.
        if ticks > 2 * PARAMETERS.motion.stalled_s / context.tick_s:
            arm.tick()

    assert run(tick, pull_test(context, SOCKET, PULL_N, "X1/1")) < 1e-3
