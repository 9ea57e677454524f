"""PickCable: grasp a loose end by friction and lift it."""

from __future__ import annotations

from dataclasses import dataclass

from remodel_skills.abilities.ability import ability
from remodel_skills.goal_checks import Message, parse_end
from remodel_skills.goals import PickGoal
from remodel_skills.primitives.grasping import pick_end
from remodel_skills.robot_context import RobotContext, Steps
from remodel_work.geometry import Pose
from remodel_work.robot.arm import ToolPose


@dataclass(frozen=True)
class CablePicked:
    """A wire in the hand.

    Attributes:
        message: for a person.
        grasp_pose: tool centre at the grasp.
        grip_width: between the pads [m].
    """

    message: str
    grasp_pose: ToolPose
    grip_width: float


def _goal(message: Message, board: Pose) -> PickGoal:
    return PickGoal(
        message.robot_name, message.cable_id, parse_end(message.cable_end), message.grasp_distance
    )


@ability("PickCable", _goal)
def pick_cable(context: RobotContext, goal: PickGoal) -> Steps[CablePicked]:
    """Find the end, grasp it so that the hand can insert it where it belongs, and lift it."""
    socket = context.panel.world_from_panel @ context.panel.panel_from_socket(
        *context.wire.goes_to(goal.end)
    )
    yield from pick_end(context, goal.end, goal.grasp_distance, socket, shares=(0.0, 1.0))
    gap = context.device.gripper.gap
    message = f"end {goal.end.value} of {goal.cable_id} held, {gap * 1e3:.1f} mm between the pads"
    return CablePicked(message, context.belief.picked_at[goal.end].tool, gap)
