"""Carry a held wire and stop when it snags, as steps of an ability."""

from __future__ import annotations

import numpy as np

from remodel_sim.abilities.execution.robot_context import RobotContext, Steps
from remodel_sim.abilities.primitives.motions import move_to
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Array
from remodel_sim.core.robot.arm import ToolPose
from remodel_states.core.codes import Code

# A wire that hangs on something pulls at the hand with so much more than a free one, and longer
# than it takes to speed the hand up [N], [s]. A free one pulls with no more than its bending
# stiffness over the square of the tightest bend into a channel [m]: 16 N were measured of 10 mm2.
SNAG_N = 9.5
SNAG_S = 0.05
TIGHTEST_BEND_M = 0.020


def carry(
    context: RobotContext, tool: ToolPose, speed: float, free: Array, most: float | None = None
) -> Steps[None]:
    """Move as `move_to`; raises SNAGGED, the arm stopped, when the wire pulls back.

    Args:
        context: the cell, a wire in its hand.
        tool: where to.
        speed: peak speed of the tool centre [m/s].
        free: what the wrist feels without the wire's pull, world frame (3,) [N].
        most: by which it may pull, level [N]; None for what a free wire of its stiffness does.
    """
    if most is None:
        most = SNAG_N + context.wire.bending_stiffness / TIGHTEST_BEND_M**2
    pulled_s = 0.0
    for _ in move_to(context, tool, speed):
        yield
        pull = float(np.linalg.norm((context.force - free)[:2]))
        pulled_s = pulled_s + context.tick_s if pull > most else 0.0
        if pulled_s > SNAG_S:
            context.drive(context.tool)
            raise AbilityError(
                Code.SNAGGED,
                f"{context.wire.id!r} pulls at the hand with {pull:.0f} N at {context.tool}: it "
                "hangs on something or is too short; move back, observe it, take another route",
            )
