"""What makes a fake cell move: goals of its abilities, and the ledger of its world."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace

import rospy
from remodel_msgs import msg

from remodel_states.edge.exported_tables import read_abilities
from remodel_states.testing.world_file import WorldFile

# [s] The end of a goal that has not ended.
_NEVER_S = float("inf")

# [s] wall time that a message may take, on a machine that is busy.
_LAG_S = 30.0


@dataclass(frozen=True)
class Motion:
    """Something that moved.

    Attributes:
        what: name of an ability, or what the ledger has, such as "feed W1".
        begun_s: [s] time at which it was sent or done, by the sender's stamp, since 1970.
        ended_s: [s] time of the result; infinite until it has arrived.
    """

    what: str
    begun_s: float
    ended_s: float


class MotionWatch:
    """Notes each goal that is sent to an ability server, and its end.

    A message that was sent before a command was answered may arrive after the answer, so the
    stamps of the senders count. ROS time must be the wall's.
    """

    def __init__(self, world: WorldFile) -> None:
        """Subscribe to the abilities; `world` is that of the cell."""
        self._world = world
        self._goals: dict[str, Motion] = {}
        self._arrived = threading.Condition()
        for ability in read_abilities():
            topic = f"remodel_abilities/{ability.lower()}"
            goal = getattr(msg, f"{ability}ActionGoal")
            result = getattr(msg, f"{ability}ActionResult")
            rospy.Subscriber(f"{topic}/goal", goal, self._on_goal, ability, tcp_nodelay=True)
            rospy.Subscriber(f"{topic}/result", result, self._on_result, ability, tcp_nodelay=True)

    @property
    def running(self) -> tuple[Motion, ...]:
        """The goals whose results have not arrived."""
        with self._arrived:
            return tuple(goal for goal in self._goals.values() if goal.ended_s == _NEVER_S)

    def under_way(self, at_s: float) -> tuple[Motion, ...]:
        """Return the goals that ran at a time [s]."""
        with self._arrived:
            # A result that was sent before may be on its way.
            self._arrived.wait_for(lambda: not self._at(at_s), _LAG_S)
            return self._at(at_s)

    def after(self, at_s: float, window_s: float) -> tuple[Motion, ...]:
        """Return what began after a time [s]: as soon as something has, or nothing for a window.

        Args:
            at_s: time, since 1970.
            window_s: [s] wall time in which something may still begin.
        """
        with self._arrived:
            self._arrived.wait_for(lambda: self._since(at_s), window_s)
            goals = self._since(at_s)
        deeds = (entry for entry in self._world.ledger() if entry.at_s > at_s)
        return goals + tuple(
            Motion(f"{entry.deed.value} {entry.wire}", entry.at_s, entry.at_s) for entry in deeds
        )

    def _at(self, at_s: float) -> tuple[Motion, ...]:
        goals = self._goals.values()
        return tuple(goal for goal in goals if goal.begun_s <= at_s < goal.ended_s)

    def _since(self, at_s: float) -> tuple[Motion, ...]:
        return tuple(goal for goal in self._goals.values() if goal.begun_s > at_s)

    def _on_goal(self, goal: object, ability: str) -> None:
        sent_s = goal.header.stamp.to_sec()  # type: ignore[attr-defined]
        identity = goal.goal_id.id  # type: ignore[attr-defined]
        with self._arrived:
            # A quick result may arrive before its goal, on another connection.
            self._goals.setdefault(identity, Motion(ability, sent_s, _NEVER_S))
            self._arrived.notify_all()

    def _on_result(self, result: object, ability: str) -> None:
        ended_s = result.header.stamp.to_sec()  # type: ignore[attr-defined]
        goal_id = result.status.goal_id  # type: ignore[attr-defined]
        with self._arrived:
            begun = Motion(ability, goal_id.stamp.to_sec(), ended_s)
            self._goals[goal_id.id] = replace(self._goals.get(goal_id.id, begun), ended_s=ended_s)
            self._arrived.notify_all()
