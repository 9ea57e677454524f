"""Pull a held end straight out of a terminal, by its force."""

from __future__ import annotations

import math

from remodel_sim.abilities.execution.robot_context import RobotContext, Steps
from remodel_sim.abilities.primitives.motions import wait
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Pose
from remodel_sim.core.workpiece.panel import unit_x
from remodel_states.core.codes import Code

PULL_SPEED = 0.04  # [m/s]
# The tip is pulled so far out of the opening.
CLEAR_M = 0.015
# A hand that gives up waits for the wire's tension to relax before anything else is done [s].
RELAX_S = 0.15


def pull_out(context: RobotContext, socket: Pose, most_n: float) -> Steps[float]:
    """Pull the held end straight back until its tip is clear of the opening.

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
    length = max(0.0, ahead) + CLEAR_M
    peak = 0.0
    for tick in range(1, math.ceil(length / PULL_SPEED / context.tick_s) + 1):
        context.drive(start.moved(out, min(length, tick * PULL_SPEED * context.tick_s)))
        yield
        force = float((context.force - context.free_force) @ out)
        peak = max(peak, force)
        if force > most_n:
            context.drive(start)
            yield from wait(context, RELAX_S)
            raise AbilityError(
                Code.EXTRACTION_STUCK, f"it does not come out at {force:.0f} N", peak_force=peak
            )
    context.belief.engaged = None
    return peak
