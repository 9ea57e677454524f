"""Pull a held end straight out of a terminal, by its force."""

from __future__ import annotations

from remodel_skills.force_control import ForceControl
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
