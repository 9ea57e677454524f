"""What the ability servers of the cell do, by their feedback and status."""

from __future__ import annotations

import time
from dataclasses import dataclass

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from remodel_msgs import msg

from remodel_planner.supervisors.ports import Doing, server_of

_FEEDBACK = "ActionFeedback"
ABILITIES = tuple(
    name.removesuffix(_FEEDBACK)
    for name, value in sorted(vars(msg).items())
    if name.endswith(_FEEDBACK) and isinstance(value, type) and not name.startswith("RunUseCase")
)

# A goal that is recalled never begins. A server that is asked to cancel a goal it does not know,
# such as one of its predecessor, lists it as recalled, and for ever if it has no clock yet.
_RUNNING = (GoalStatus.PENDING, GoalStatus.ACTIVE, GoalStatus.PREEMPTING)


@dataclass(frozen=True)
class _Status:
    """What a server has published last.

    Attributes:
        at_s: [s] wall time at which it arrived.
        is_running: whether a goal is on its way.
    """

    at_s: float
    is_running: bool


class AbilityWatch:
    """Listens to all abilities, and can cancel what they do, past the engine."""

    def __init__(self) -> None:
        """Subscribe to feedback and status of every ability of remodel_msgs."""
        self.latest: Doing | None = None
        self._statuses: dict[str, _Status] = {}
        self._subscribers: dict[str, rospy.Subscriber] = {}
        self._cancels: list[rospy.Publisher] = []
        for ability in ABILITIES:
            topic = f"remodel_abilities/{ability.lower()}"
            kind = getattr(msg, f"{ability}ActionFeedback")
            rospy.Subscriber(f"{topic}/feedback", kind, self._on_feedback, ability)
            self._subscribers[ability] = rospy.Subscriber(
                f"{topic}/status", GoalStatusArray, self._on_status, ability
            )
            self._cancels.append(rospy.Publisher(f"{topic}/cancel", GoalID, queue_size=10))

    def cancel(self) -> None:
        """Cancel every goal of every ability, whoever sent it."""
        for publisher in self._cancels:
            publisher.publish(GoalID())

    def is_connected(self, ability: str) -> bool:
        """Return whether the server of an ability is connected, whether it answers or not."""
        return self._subscribers[ability].get_num_connections() > 0

    def answers(self, ability: str, since_s: float) -> bool:
        """Return whether the server of an ability is there, and has reported rest since [s]."""
        return self.is_connected(ability) and self._rests(ability, since_s)

    def are_quiet(self, since_s: float) -> bool:
        """Return whether all connected servers have reported since then [s] that they rest."""
        return not self.restless(since_s)

    def restless(self, since_s: float) -> tuple[str, ...]:
        """Return those that do not rest or do not report, for a person."""
        return tuple(
            server_of(ability)
            for ability in ABILITIES
            if self.is_connected(ability) and not self._rests(ability, since_s)
        )

    def _rests(self, ability: str, since_s: float) -> bool:
        status = self._statuses.get(ability)
        return status is not None and status.at_s >= since_s and not status.is_running

    def _on_feedback(self, message: object, ability: str) -> None:
        feedback = message.feedback  # type: ignore[attr-defined]
        since_s = message.header.stamp.to_sec() - feedback.elapsed_time  # type: ignore[attr-defined]
        self.latest = Doing(ability, feedback.message, feedback.completed_percentage, since_s)

    def _on_status(self, array: GoalStatusArray, ability: str) -> None:
        is_running = any(status.status in _RUNNING for status in array.status_list)
        self._statuses[ability] = _Status(time.monotonic(), is_running)
        latest = self.latest
        if not is_running and latest is not None and latest.ability == ability:
            self.latest = None
