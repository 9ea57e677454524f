"""What the ability servers of the cell do, by their feedback and status."""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray

from remodel_states.core.codes import Code
from remodel_states.core.contract import owner_of
from remodel_states.edge.exported_tables import read_abilities
from remodel_states.serving import message_class
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.state import PERSON_FIRST
from remodel_supervision.supervisors.ports import Doing, server_of

# A goal that is recalled never begins. A server that is asked to cancel a goal it does not know,
# such as one of its predecessor, lists it as recalled, and for ever if it has no clock yet.
_RUNNING = (GoalStatus.PENDING, GoalStatus.ACTIVE, GoalStatus.PREEMPTING)

# Goals of an ability whose owners are known; a server has one at a time.
_GOALS_KNOWN = 20


@dataclass(frozen=True)
class _Status:
    """What a server has published last.

    Attributes:
        at_s: [s] wall time at which it arrived.
        running: actionlib's ids of the goals that are on their way.
    """

    at_s: float
    running: frozenset[str]


class AbilityWatch:
    """Listens to all abilities, and can cancel what they do, past the engine."""

    def __init__(self) -> None:
        """Subscribe to what every ability publishes.

        Raises:
            remodel_states.core.tables.TableError: if a table of abilities cannot be read.
        """
        self._abilities = read_abilities()
        self.latest: Doing | None = None
        self._statuses: dict[str, _Status] = {}
        self._subscribers: dict[str, rospy.Subscriber] = {}
        self._stops: deque[Operation] = deque()
        self._cancels: dict[str, rospy.Publisher] = {}
        # Ability -> actionlib's id of a goal -> token of the owner who granted it, the latest last.
        self._owners: dict[str, dict[str, int]] = {ability: {} for ability in self._abilities}
        for ability, row in self._abilities.items():
            topic, kind = row.topic, message_class(row, "ActionFeedback")
            rospy.Subscriber(f"{topic}/feedback", kind, self._on_feedback, ability)
            self._subscribers[ability] = rospy.Subscriber(
                f"{topic}/status", GoalStatusArray, self._on_status, ability
            )
            result = message_class(row, "ActionResult")
            rospy.Subscriber(f"{topic}/result", result, self._on_result, ability)
            goal = message_class(row, "ActionGoal")
            rospy.Subscriber(f"{topic}/goal", goal, self._on_goal, ability)
            self._cancels[ability] = rospy.Publisher(f"{topic}/cancel", GoalID, queue_size=10)

    def cancel(self, owner: int | None = None) -> None:
        """Cancel every goal of every ability, or only those that an owner of the cell granted."""
        for ability, publisher in self._cancels.items():
            if owner is None:
                publisher.publish(GoalID())
                continue
            for goal_id, token in list(self._owners[ability].items()):
                if token == owner:
                    publisher.publish(GoalID(id=goal_id))

    def is_connected(self, ability: str) -> bool:
        """Return whether the server of an ability is connected, whether it answers or not."""
        return self._subscribers[ability].get_num_connections() > 0

    def answers(self, ability: str, since_s: float) -> bool:
        """Return whether the server of an ability is there, and has reported rest since [s]."""
        return self.is_connected(ability) and self._rests(ability, since_s)

    def are_quiet(self, since_s: float, owner: int | None = None) -> bool:
        """Return whether all connected servers have reported since then [s] that they rest."""
        return not self.restless(since_s, owner)

    def restless(self, since_s: float, owner: int | None = None) -> tuple[str, ...]:
        """Return those that do not rest or do not report, for a person."""
        return tuple(
            server_of(ability)
            for ability in self._abilities
            if self.is_connected(ability) and not self._rests(ability, since_s, owner)
        )

    def take_stops(self) -> tuple[Operation, ...]:
        """Return, once, the results after which nothing may move before a person has answered."""
        stops = []
        while self._stops:
            stops.append(self._stops.popleft())
        return tuple(stops)

    def _rests(self, ability: str, since_s: float, owner: int | None = None) -> bool:
        status, owners = self._statuses.get(ability), self._owners[ability]
        if status is None or status.at_s < since_s:
            return False
        if owner is None:
            return not status.running
        return all(owners.get(goal_id) != owner for goal_id in status.running)

    def _on_goal(self, message: object, ability: str) -> None:
        owners = {
            **self._owners[ability],
            message.goal_id.id: owner_of(message.goal.id),  # type: ignore[attr-defined]
        }
        self._owners[ability] = dict(list(owners.items())[-_GOALS_KNOWN:])

    def _on_result(self, message: object, ability: str) -> None:
        result, header = message.result, message.header  # type: ignore[attr-defined]
        # A server that refuses the goals of an earlier owner of the cell does as it should.
        if result.error_code not in PERSON_FIRST - {Code.STALE_OWNER}:
            return
        at_s, goal_id = header.stamp.to_sec(), result.id or message.status.goal_id.id  # type: ignore[attr-defined]
        took_s, text = result.elapsed_time, result.error_message
        self._stops.append(
            Operation(
                "",
                ability,
                "",
                result.error_code,
                text=text,
                ended_s=at_s,
                elapsed_s=took_s,
                goal_id=goal_id,
            )
        )

    def _on_feedback(self, message: object, ability: str) -> None:
        feedback = message.feedback  # type: ignore[attr-defined]
        since_s = message.header.stamp.to_sec() - feedback.elapsed_time  # type: ignore[attr-defined]
        self.latest = Doing(ability, feedback.message, feedback.completed_percentage, since_s)

    def _on_status(self, array: GoalStatusArray, ability: str) -> None:
        running = frozenset(s.goal_id.id for s in array.status_list if s.status in _RUNNING)
        self._statuses[ability] = _Status(time.monotonic(), running)
        latest = self.latest
        if not running and latest is not None and latest.ability == ability:
            self.latest = None
