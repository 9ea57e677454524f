"""Pull a held end out of its terminal, or test that it is held there, as steps of an ability."""

from __future__ import annotations

from remodel_skills.force_control import RIGID, Yielding
from remodel_skills.primitives.force_motion import ForceMotion
from remodel_skills.primitives.grasping import release
from remodel_skills.primitives.motions import rise, wait
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.layout import STANDOFF_M
from remodel_work.panel import unit_x
from remodel_work.routes import TerminalKey, nearest_terminal


def pull_out(context: RobotContext, socket: Pose, most_n: float) -> Steps[float]:
    """Pull the held end straight back to where a push begins, or until its tip is out at least.

    Args:
        context: the cell; its hand holds the end.
        socket: the opening's frame, x into the terminal.
        most_n: a force at which the end counts as stuck [N]: the hand goes back to where it was,
            releases the end there, and rises.

    Returns:
        The peak force [N].

    Raises:
        AbilityError: EXTRACTION_STUCK, the hand empty.
    """
    out = -unit_x(socket)
    grip, start = context.belief.grip, context.commanded
    assert grip is not None, "the end is held"
    ahead = float((start.position - socket.position) @ -out) + grip.distance
    inside = max(0.0, ahead)
    motion = ForceMotion(context, out, most_n)
    while motion.travel < inside + STANDOFF_M:
        yield from motion.advance(context.parameters.motion.pull_speed_m_s)
        if motion.met_limit and motion.travel > inside + context.parameters.terminal.out_m:
            break  # What holds it now is not the terminal, such as the slot that it passes.
        if motion.met_limit:
            stuck_at = motion.force  # before the hand goes back and the wire relaxes
            context.drive(start)
            yield from wait(context, context.parameters.motion.force_still_s)
            where = yield from _leave_in_terminal(context, socket)
            raise AbilityError(
                Code.EXTRACTION_STUCK,
                f"end {grip.end.value} in '{'/'.join(where)}' does not come out at {stuck_at:.0f} "
                "N; it was released there, the hand is empty",
                peak_force=motion.loop.peak,
            )
    motion.stop()
    context.belief.engaged = None
    return motion.loop.peak


def _leave_in_terminal(context: RobotContext, socket: Pose) -> Steps[TerminalKey]:
    """Release the held end where it sits, and rise; return its terminal."""
    belief = context.belief
    assert belief.grip is not None, "the end is held"
    where = nearest_terminal(socket.position, context.panel, belief.seen)
    belief.seat(belief.grip.end, where)
    yield from release(context, context.parameters.tool.release_opening_m)
    yield from rise(context)
    return where


def pull_test(
    context: RobotContext,
    socket: Pose,
    newtons: float,
    where: str,
    stiffness: float | None = None,
    yielding: Yielding = RIGID,
) -> Steps[float]:
    """Pull the held end outwards until the force is reached; return the slip [m].

    Args:
        context: the cell; its hand holds the end.
        socket: the opening's frame, x into the terminal.
        newtons: the force [N].
        where: the terminal's name.
        stiffness: with which a held end takes up the pull [N/m]; None: as a clamped wire.
        yielding: how the hand gives way across the pull: an end that it holds askew leans on its
            opening, and would jerk between the pads.

    Raises:
        AbilityError: PULLED_OUT.
    """
    wire = context.parameters.wire
    out = -unit_x(socket)
    start = context.commanded
    if stiffness is None:
        stiffness = wire.clamped_stiffness_n_m
    # The push left the end under load; the pull counts from the free hand.
    motion = ForceMotion(context, out, newtons, stiffness)
    motion.yield_to(yielding)
    if motion.force >= wire.taken_up_share * newtons:
        motion.tare()  # a thick wire, bent behind the hand, pulls at it before the end does
    taken_up = None
    while not motion.met_limit and motion.travel < wire.pull_travel_m:
        yield from motion.advance(context.parameters.motion.test_speed_m_s)
        if taken_up is None and motion.force >= wire.taken_up_share * newtons:
            taken_up = motion.travel
    motion.stop()
    slip = motion.travel - (taken_up if taken_up is not None else 0.0)
    # An end that creeps under less than the pull has not met it: the motion only stalled.
    if (
        not motion.met_limit
        or motion.loop.pressed_at is None
        or slip > context.parameters.terminal.max_slip_m
    ):
        raise AbilityError(
            Code.PULLED_OUT,
            f"the end moved {slip * 1e3:.1f} mm in {where} at {motion.force:.1f} of {newtons:.1f} "
            "N; extract, locate again, insert again",
            slip=slip,
        )
    context.drive(start)
    yield from wait(context, context.parameters.motion.force_still_s)
    return slip
