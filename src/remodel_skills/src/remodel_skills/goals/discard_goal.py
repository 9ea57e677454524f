"""The goal of DiscardCable."""

from __future__ import annotations

from dataclasses import dataclass

from remodel_skills.belief_state import BeliefState
from remodel_skills.goals.checks import check_hands_empty, check_held
from remodel_skills.goals.requirements import require_robot
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.panel import Panel


@dataclass(frozen=True)
class DiscardGoal:
    """Take a wire off the panel; an empty `cable_id` means the one in the hand."""

    robot_name: str
    cable_id: str

    def __post_init__(self) -> None:
        """Refuse unknown robots."""
        require_robot(self.robot_name)

    def check(self, panel: Panel, belief: BeliefState) -> None:
        """Raise when nothing is held, or a hand holds what it must place first."""
        if not self.cable_id:
            check_held(belief)
        elif panel.wire(self.cable_id).id not in belief.fed:
            return  # there is nothing to discard
        if belief.feed is not None and self.cable_id not in ("", belief.feed.wire_id):
            check_hands_empty(belief)
        for robot, grip in belief.hands.items():
            if robot != belief.robot:
                raise AbilityError(
                    Code.OTHER_CABLE_HELD,
                    f"{robot} holds end {grip.end.value}; have it placed first",
                )
