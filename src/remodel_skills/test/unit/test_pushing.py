"""How a push ends, by what the wrist feels: on a scripted device, in milliseconds."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from refusals import refused
from scripted_device import GRIP_M, PARAMETERS, SOCKET, TERMINAL, before_the_opening

from remodel_skills.primitives.pushing import (
    PushMonitor,
    judge_alignment,
    judge_depth,
    push_in,
    tool_before,
)
from remodel_skills.robot_context import run
from remodel_states.core.codes import Code
from remodel_work.layout import STANDOFF_M
from remodel_work.robot.fingers import PANDA_FINGERS

BOTTOM, FACE_M = TERMINAL.depth, PARAMETERS.terminal.face_m
NEAR_BOTTOM_M = 0.0115
LIMIT_N = 8.0
STIFF = 2e4  # of a wire in the grip against what stops it [N/m]
PADS_AT_FACE_M = GRIP_M - PANDA_FINGERS.width / 2  # the depth at which they are there
RUBBING_N = 0.8  # of a ferrule in its opening


def wall(at, depth):
    return STIFF * max(0.0, depth - at)


def seats(depth):
    return RUBBING_N * (depth > 0) + wall(BOTTOM, depth)


def jams(depth):
    return RUBBING_N * (depth > 0) + wall(0.006, depth)


def jams_just_before_the_bottom(depth):
    return RUBBING_N * (depth > 0) + wall(NEAR_BOTTOM_M, depth)


def meets_the_face(depth):
    return wall(0.0005, depth)


def gives_way(depth):
    """An end that slides in the grip or bends aside: at last the fingers meet the rigid face."""
    return 1e6 * max(0.0, depth - PADS_AT_FACE_M)


def rubs(depth):
    return 2 * PARAMETERS.wire.rubs_n * (depth > FACE_M) + wall(BOTTOM, depth)


# What a wrist felt in the simulated cell.
RECORDED = json.loads(Path(__file__).with_name("recorded_pushes.json").read_text())


def recorded(push):
    """Return what resists at a depth [N]: as recorded, and beyond that like what stopped it."""
    depths, forces = push["depths_m"], push["forces_n"]
    return lambda depth: float(np.interp(depth, depths, forces)) + wall(depths[-1], depth)


def pushed(feels, until_in=float("inf"), held_m=GRIP_M):
    """Push the end in; return how that went, and the arm."""
    context, arm = before_the_opening(feels)
    context.belief.grip = replace(context.belief.grip, distance=held_m)
    context.drive(tool_before(SOCKET, context.belief.grip, -STANDOFF_M))
    push = run(arm.tick, push_in(context, SOCKET, BOTTOM, LIMIT_N, until_in=until_in))
    return push, arm


def test_an_end_that_meets_the_bottom_is_seated():
    push, _ = pushed(seats)
    assert push.stopped
    assert push.depth == pytest.approx(BOTTOM, abs=1e-3)
    judge_alignment(push, SOCKET, TERMINAL, "X1/1")
    judge_depth(push, BOTTOM, "X1/1", PARAMETERS.terminal)


@pytest.mark.parametrize(
    ("feels", "code", "depth"),
    [
        (jams, Code.INSERTION_JAMMED, 0.006),
        (jams_just_before_the_bottom, Code.INSERTION_JAMMED, NEAR_BOTTOM_M),
        (meets_the_face, Code.INSERTION_MISALIGNED, 0.0005),
        (gives_way, Code.INSERTION_NO_CONTACT, PADS_AT_FACE_M),
    ],
)
def test_an_end_that_does_not_reach_the_bottom_is_refused(feels, code, depth):
    push, _ = pushed(feels)
    assert push.depth == pytest.approx(depth, abs=1e-3)
    with refused(code) as caught:
        judge_depth(push, BOTTOM, "X1/1", PARAMETERS.terminal)
    assert caught.value.found["peak_force"] == push.peak_force


@pytest.mark.parametrize("one", RECORDED, ids=lambda one: one["name"])
def test_a_recorded_push_is_judged_as_it_ended(one):
    push, arm = pushed(recorded(one))
    assert push.depth == pytest.approx(one["depths_m"][-1], abs=5e-4)
    assert max(arm.forces) <= 1.15 * LIMIT_N + 0.5
    if one["ended"] == "SEATED":
        judge_depth(push, BOTTOM, "X1/1", PARAMETERS.terminal)
        return
    with refused(Code[one["ended"]]):
        judge_depth(push, BOTTOM, "X1/1", PARAMETERS.terminal)


@pytest.mark.parametrize("feels", [seats, jams, meets_the_face, rubs, gives_way])
def test_no_push_goes_far_beyond_its_limit(feels):
    push, arm = pushed(feels)
    assert max(arm.forces) <= 1.15 * LIMIT_N + 0.5
    assert push.peak_force <= 1.15 * LIMIT_N + 0.5
    assert push.peak_force >= 0.8 * LIMIT_N or feels is gives_way


def test_an_end_that_is_held_too_near_to_its_tip_is_not_pushed():
    with refused(Code.UNREACHABLE, r"would come 11.* mm deep.*pick it farther"):
        pushed(seats, held_m=0.021)


def test_a_tip_that_may_rub_along_the_face_is_pushed_no_further_than_halfway():
    push, _ = pushed(rubs, until_in=5.0)
    assert push.rubs
    assert push.depth == pytest.approx(BOTTOM / 2, abs=1e-3)
    push, _ = pushed(seats, until_in=5.0)
    assert not push.rubs, "one that slides in with less is in its opening"
    push, _ = pushed(rubs)
    assert not push.rubs, "and so is one whose push may be as hard all the way"


def test_a_tip_that_meets_the_face_is_pushed_gently_until_it_is_in():
    push, arm = pushed(meets_the_face, until_in=3.0)
    assert push.stopped and push.depth < FACE_M
    assert max(arm.forces) <= 1.15 * 3.0 + 0.5


# Forces as the cell has felt them [N].
FREE = (0.6, 0.7, 0.7)
HANGING = (9.1, 19.7, 7.7, 5.0)


def gives_way_after(before, near, buckles=True):
    """Return how many forces near the bottom show that it gives way; None if it does not."""
    monitor = PushMonitor(buckles, PARAMETERS.wire)
    for force in before:
        monitor = monitor.then(force, near_bottom=False)
    assert not monitor.gave_way
    for count, force in enumerate(near, 1):
        monitor = monitor.then(force, near_bottom=True)
        if monitor.gave_way:
            return count
    return None


@pytest.mark.parametrize(
    ("before", "near", "count"),
    [
        (FREE, (2.6, 4.7, 6.4, 7.6, 8.1), None),  # the bottom, met under force control
        (FREE, (5.6, 6.4, 6.0, 5.6, 5.5), 4),  # a wire that buckles there
        (FREE, (2.1, 1.4, 1.2), None),  # one that rubs
        (FREE, (5.6, 6.4, 7.0), None),  # one that still resists
        (HANGING, (5.6, 5.4, 4.4, 2.3), None),  # one that is bent before the opening
    ],
)
def test_a_wire_gives_way_where_the_force_at_the_bottom_was_great_and_falls(before, near, count):
    assert gives_way_after(before, near) == count


def test_what_does_not_buckle_never_gives_way():
    assert gives_way_after(FREE, (12.0, 11.0, 5.0), buckles=False) is None
