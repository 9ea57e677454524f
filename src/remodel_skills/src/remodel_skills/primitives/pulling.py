"""Pull a held end out of its terminal, or test that it is held there, as steps of an ability."""

from __future__ import annotations

from remodel_skills.force_control import RIGID, ForceControl, Yielding
from remodel_skills.primitives.force_motion import ForceMotion
from remodel_skills.primitives.motions import wait
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.layout import STANDOFF_M
from remodel_work.panel import unit_x

PULL_SPEED = 0.04  # [m/s]
# A tip so far before the opening is out of its terminal [m].
OUT_M = 0.003
# A hand that gives up waits for the wire's tension to relax before anything else is done [s].
RELAX_S = 0.15


def pull_out(context: RobotContext, socket: Pose, most_n: float) -> Steps[float]:
    """Pull the held end straight back to where a push begins, or until its tip is out at least.

    Args:
        context: the cell; its hand holds the end.
        socket: the opening's frame, x into the terminal.
        most_n: a force at which the end counts as stuck; the hand goes back to where it was [N].

    Returns:
        The peak force [N].

    Raises:
        AbilityError: EXTRACTION_STUCK.
    """
    out = -unit_x(socket)
    grip, start = context.belief.grip, context.commanded
    assert grip is not None, "the end is held"
    ahead = float((start.position - socket.position) @ -out) + grip.distance
    inside = max(0.0, ahead)
    motion = ForceMotion(context, out, ForceControl(most_n))
    while motion.travel < inside + STANDOFF_M:
        yield from motion.advance(PULL_SPEED)
        if motion.met_limit and motion.travel > inside + OUT_M:
            break  # What holds it now is not the terminal, such as the slot that it passes.
        if motion.met_limit:
            stuck_at = motion.force  # before the hand goes back and the wire relaxes
            context.drive(start)
            yield from wait(context, RELAX_S)
            raise AbilityError(
                Code.EXTRACTION_STUCK,
                f"it does not come out at {stuck_at:.0f} N",
                peak_force=motion.loop.peak,
            )
    motion.stop()
    context.belief.engaged = None
    return motion.loop.peak


TEST_SPEED = 0.015  # [m/s]
# The pads damp what is clamped with 2300 N s/m, measured: within the control's time constant that
# is as hard as 2e5 N/m. With less than this the control overcorrects, and the force swings at
# each step, from 3.5 to 6.4 N about 5 N with 1.2e5 [N/m].
CLAMPED_STIFFNESS = 4e5
# A straight, firmly held end takes up the pull within this travel: slack, pads and contacts give so
# much.
PULL_TRAVEL_M = 0.006
# The slip is counted from here on [share of the pull].
TAKEN_UP = 0.4
MAX_SLIP_M = 0.0015


def pull_test(
    context: RobotContext,
    socket: Pose,
    newtons: float,
    where: str,
    stiffness: float = CLAMPED_STIFFNESS,
    yielding: Yielding = RIGID,
) -> Steps[float]:
    """Pull the held end outwards until the force is reached; return the slip [m].

    Args:
        context: the cell; its hand holds the end.
        socket: the opening's frame, x into the terminal.
        newtons: the force [N].
        where: the terminal's name.
        stiffness: with which a held end takes up the pull [N/m].
        yielding: how the hand gives way across the pull: an end that it holds askew leans on its
            opening, and would jerk between the pads.

    Raises:
        AbilityError: PULLED_OUT.
    """
    out = -unit_x(socket)
    start = context.commanded
    # The push left the end under load; the pull counts from the free hand.
    motion = ForceMotion(context, out, ForceControl(newtons, stiffness))
    motion.yield_to(yielding)
    taken_up = None
    while not motion.met_limit and motion.travel < PULL_TRAVEL_M:
        yield from motion.advance(TEST_SPEED)
        if taken_up is None and motion.force >= TAKEN_UP * newtons:
            taken_up = motion.travel
    motion.stop()
    slip = motion.travel - (taken_up if taken_up is not None else 0.0)
    # An end that creeps under less than the pull has not met it: the motion only stalled.
    if not motion.met_limit or motion.loop.pressed_at is None or slip > MAX_SLIP_M:
        raise AbilityError(
            Code.PULLED_OUT,
            f"the end moved {slip * 1e3:.1f} mm in {where} at {motion.force:.1f} of {newtons:.1f} "
            "N; extract, locate again, insert again",
            slip=slip,
        )
    context.drive(start)
    yield from wait(context, 0.15)
    return slip
