"""What the abilities of the cell are doing, by their feedback and status."""

from __future__ import annotations

from dataclasses import dataclass

import rospy
from actionlib_msgs.msg import GoalStatus, GoalStatusArray
from remodel_msgs import msg

_FEEDBACK = "ActionFeedback"
ABILITIES = tuple(
    name.removesuffix(_FEEDBACK)
    for name, value in sorted(vars(msg).items())
    if name.endswith(_FEEDBACK) and isinstance(value, type) and not name.startswith("RunUseCase")
)
_RUNNING = (GoalStatus.PENDING, GoalStatus.ACTIVE, GoalStatus.PREEMPTING, GoalStatus.RECALLING)


@dataclass(frozen=True)
class Doing:
    """What an ability says that it does.

    Attributes:
        text: for a person.
        percent: [%] 0 to 100.
        since_s: [s] ROS time of its acceptance.
    """

    ability: str
    text: str
    percent: float
    since_s: float


class AbilityFeedback:
    """Listens to all abilities."""

    def __init__(self) -> None:
        """Subscribe to feedback and status of every ability of remodel_msgs."""
        self.latest: Doing | None = None
        self._statuses: dict[str, bool] = {}
        self._subscribers: dict[str, rospy.Subscriber] = {}
        for ability in ABILITIES:
            topic = f"remodel_abilities/{ability.lower()}"
            kind = getattr(msg, f"{ability}ActionFeedback")
            rospy.Subscriber(f"{topic}/feedback", kind, self._on_feedback, ability)
            self._subscribers[ability] = rospy.Subscriber(
                f"{topic}/status", GoalStatusArray, self._on_status, ability
            )

    def is_there(self, ability: str) -> bool:
        """Tell whether the server of an ability is connected."""
        return self._subscribers[ability].get_num_connections() > 0

    @property
    def running(self) -> bool:
        """Whether an ability has a goal, as far as its server has said."""
        return any(self._statuses.values())

    def _on_feedback(self, message: object, ability: str) -> None:
        told = message.feedback  # type: ignore[attr-defined]
        since_s = message.header.stamp.to_sec() - told.elapsed_time  # type: ignore[attr-defined]
        self.latest = Doing(ability, told.message, told.completed_percentage, since_s)

    def _on_status(self, array: GoalStatusArray, ability: str) -> None:
        self._statuses[ability] = any(s.status in _RUNNING for s in array.status_list)
        if not self._statuses[ability] and self.latest and self.latest.ability == ability:
            self.latest = None
