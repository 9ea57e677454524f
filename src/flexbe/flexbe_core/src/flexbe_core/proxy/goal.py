"""One goal at an action server, as its client knows it."""

from __future__ import annotations

from actionlib_msgs.msg import GoalStatus
from genpy import Message

_TERMINAL = frozenset(
    {
        GoalStatus.PREEMPTED,
        GoalStatus.SUCCEEDED,
        GoalStatus.ABORTED,
        GoalStatus.REJECTED,
        GoalStatus.RECALLED,
        GoalStatus.LOST,
    }
)

# What a simple client calls the server's intermediate states.
_SIMPLE = {GoalStatus.RECALLING: GoalStatus.PENDING, GoalStatus.PREEMPTING: GoalStatus.ACTIVE}


# [s] A server lists a goal as soon as it has it. A server that publishes its list for this long
# without the goal never received it: the goal was sent into a connection that was about to end.
UNNOTICED_S = 5.0


class Goal:
    """The client's view of a goal.

    Attributes:
        goal_id: its name on the wire.
        sent_at: [s] when it was sent, by time.monotonic.
        status: a constant of GoalStatus.
        text: what the server says about the status.
        result: the server's result, until it is removed.
        feedback: the server's last feedback, until it is removed.
        gone_since: [s] when the server was first found missing; None while it is there.
    """

    def __init__(self, goal_id: str, sent_at: float = 0.0) -> None:
        """Begin as a goal that is being sent."""
        self.goal_id = goal_id
        self.sent_at = sent_at
        self.status: int = GoalStatus.PENDING
        self.text = ""
        self.result: Message | None = None
        self.feedback: Message | None = None
        self.gone_since: float | None = None
        self._is_known = False

    @property
    def is_active(self) -> bool:
        """Return whether the server may still answer."""
        return self.status not in _TERMINAL

    @property
    def simple_status(self) -> int:
        """Return the status as actionlib's simple client reports it."""
        return _SIMPLE.get(self.status, self.status)

    def take_status(self, listed: GoalStatus | None, now: float = 0.0) -> bool:
        """Take what the server lists about the goal at `now` [s]; None if it lists nothing.

        A goal that the server knew and no longer lists is lost: the server was restarted. A goal
        that it never lists is lost too. A terminal status counts only with its result, which
        arrives on another topic.

        Returns:
            whether the status changed.
        """
        if not self.is_active:
            return False
        if listed is None:
            if not self._is_known and now - self.sent_at < UNNOTICED_S:
                return False
            self.status = GoalStatus.LOST
            self.text = (
                "the server no longer knows the goal; it was restarted"
                if self._is_known
                else "the server never received the goal"
            )
            return True
        self._is_known = True
        if listed.status in _TERMINAL or listed.status == self.status:
            return False
        self.status, self.text = listed.status, listed.text
        return True

    def take_result(self, status: GoalStatus, result: Message) -> None:
        """Take the server's answer."""
        self.status, self.text, self.result = status.status, status.text, result
