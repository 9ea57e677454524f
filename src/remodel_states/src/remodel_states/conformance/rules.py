"""The clauses of the contract that all abilities keep (Deliverable 5.1, 3.1).

Each rule takes the messages about one goal and yields what is wrong with them. The rules do not
depend on the ability.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from actionlib_msgs.msg import GoalStatus
from remodel_msgs.msg import ErrorCode

from remodel_states.core.contract import CANCEL_LIMIT_S, GRACE_S, SILENT_LIMIT_S

# What was heard about one goal, from sending it to the last word about it


TERMINAL = frozenset(
    {
        GoalStatus.PREEMPTED,
        GoalStatus.SUCCEEDED,
        GoalStatus.ABORTED,
        GoalStatus.REJECTED,
        GoalStatus.RECALLED,
    }
)
STATUS_NAMES = {
    value: name
    for name, value in vars(GoalStatus).items()
    if isinstance(value, int) and name.isupper()
}


@dataclass(frozen=True)
class Feedback:
    """One feedback message.

    Attributes:
        ros_s: [s] ROS time at which it was heard.
        message: the ability's feedback.
    """

    ros_s: float
    message: Any


@dataclass(frozen=True)
class Result:
    """One result message.

    Attributes:
        ros_s: [s] ROS time at which it was heard.
        wall_s: [s] wall time at which it was heard.
        status: constant of GoalStatus that came with it.
        text: what came with the status.
        message: the ability's result.
    """

    ros_s: float
    wall_s: float
    status: int
    text: str
    message: Any

    @property
    def reason(self) -> str:
        """Whatever the server says about a failure."""
        return f"{self.message.error_message} {self.text}".strip()


@dataclass
class Exchange:
    """One goal and what was heard about it. Times are [s] of one clock each, ROS or wall.

    Attributes:
        goal: the ability's goal.
        sent_ros_s: when it was sent.
        active_ros_s: when the server was first heard to work on it.
        listed: whether the server ever listed it in its status.
        cancelled_wall_s: when it was cancelled.
        feedback: all feedback, in order.
        results: all results, in order; a good server sends one.
    """

    goal: Any
    sent_ros_s: float
    active_ros_s: float | None = None
    listed: bool = False
    cancelled_wall_s: float | None = None
    feedback: list[Feedback] = field(default_factory=list)
    results: list[Result] = field(default_factory=list)

    @property
    def result(self) -> Result | None:
        """The first result."""
        return self.results[0] if self.results else None

    @property
    def is_done(self) -> bool:
        """Whether it ended as it was meant to."""
        result = self.result
        return result is not None and result.status == GoalStatus.SUCCEEDED

    @property
    def is_refused(self) -> bool:
        """Whether the server never began to work on it."""
        result = self.result
        return result is not None and result.status in (GoalStatus.REJECTED, GoalStatus.RECALLED)

    @property
    def took_s(self) -> float:
        """How long [s, ROS] from sending to the result; 0 without one."""
        return self.result.ros_s - self.sent_ros_s if self.result else 0.0


# The clauses

CANCELLED = (GoalStatus.PREEMPTED, GoalStatus.RECALLED)

# [s] ROS time by which the server's clock for a goal may differ from ours, and [1] of its duration.
CLOCK_SLACK_S = 0.5
CLOCK_SLACK = 0.1

# [s] ROS time by which feedback that was sent before the result may be heard after it.
LATE_S = 0.3


@dataclass(frozen=True)
class Violation:
    """A clause that a server does not keep.

    Attributes:
        rule: name of the clause in `clauses.CLAUSES`, stable.
        found: what was seen, and what would have been right.
    """

    rule: str
    found: str


Rule = Callable[[Exchange], Iterator[Violation]]


def answers_once(exchange: Exchange) -> Iterator[Violation]:
    """Every goal ends, with one result of a terminal status."""
    if not exchange.results:
        noticed = "though the server listed it" if exchange.listed else "and was never listed"
        yield Violation("no-answer", f"the goal got no result, {noticed}")
    if len(exchange.results) > 1:
        yield Violation("answers-twice", f"the goal got {len(exchange.results)} results")
    for result in exchange.results[:1]:
        if result.status not in TERMINAL:
            name = STATUS_NAMES.get(result.status, result.status)
            yield Violation(
                "open-status", f"the result came with status {name}, which is not terminal"
            )


def echoes_the_id(exchange: Exchange) -> Iterator[Violation]:
    """Result and feedback carry the goal's id."""
    wanted = exchange.goal.id
    for what, messages in (("result", exchange.results), ("feedback", exchange.feedback)):
        wrong = next((m.message.id for m in messages if m.message.id != wanted), None)
        if wrong is not None:
            yield Violation("wrong-id", f"the {what} of goal {wanted!r} says id {wrong!r}")


def is_consistent(exchange: Exchange) -> Iterator[Violation]:
    """Status, success, error code and error message of a result agree."""
    result = exchange.result
    if result is None:
        return
    message = result.message
    if message.success and message.error_code != ErrorCode.NONE:
        yield Violation("success-with-code", f"success, with error code {message.error_code}")
    if not message.success and message.error_code == ErrorCode.NONE:
        yield Violation("failure-without-code", "no success, and error code 0")
    if message.success != (result.status == GoalStatus.SUCCEEDED):
        name = STATUS_NAMES.get(result.status, result.status)
        yield Violation("status-against-success", f"status {name}, with success {message.success}")
    if not message.success and not result.reason:
        yield Violation(
            "no-reason", "no success, and neither error_message nor status has a reason"
        )
    if message.success and message.error_message:
        yield Violation(
            "reason-of-success", f"success, with error_message {message.error_message!r}"
        )


def knows_its_codes(codes: Collection[int]) -> Rule:
    """Return the rule that error codes are those of the table."""

    def rule(exchange: Exchange) -> Iterator[Violation]:
        result = exchange.result
        if result is not None and result.message.error_code not in codes:
            yield Violation(
                "unknown-code",
                f"error code {result.message.error_code}; codes are those of "
                "remodel_msgs/config/faults.yaml, and of the packages that export a table",
            )

    return rule


def reports_elapsed_time(exchange: Exchange) -> Iterator[Violation]:
    """The result's elapsed_time is that from acceptance to result."""
    result = exchange.result
    if result is None or exchange.is_refused:
        return
    reported = result.message.elapsed_time
    took = exchange.took_s
    slack = CLOCK_SLACK_S + CLOCK_SLACK * took
    if not abs(reported - took) <= slack:
        yield Violation("wrong-time", f"elapsed_time {reported:g} s; the goal took {took:.2f} s")


def reports_progress(exchange: Exchange) -> Iterator[Violation]:
    """Feedback is in range, never decreases and arrives before the result."""
    messages = [feedback.message for feedback in exchange.feedback]
    shares = [message.completed_percentage for message in messages]
    times = [message.elapsed_time for message in messages]
    wrong = next((share for share in shares if not 0.0 <= share <= 100.0), None)
    if wrong is not None:
        yield Violation("percentage-range", f"completed_percentage {wrong:g}; it is 0 to 100")
    fall = next((pair for pair in pairwise(shares) if pair[1] < pair[0]), None)
    if fall is not None:
        yield Violation(
            "percentage-falls", f"completed_percentage went from {fall[0]:g} to {fall[1]:g}"
        )
    wrong = next((time for time in times if not 0.0 <= time < math.inf), None)
    if wrong is not None:
        yield Violation("feedback-time", f"elapsed_time {wrong:g} s in feedback")
    fall = next((pair for pair in pairwise(times) if pair[1] < pair[0]), None)
    if fall is not None:
        yield Violation("feedback-time", f"elapsed_time went from {fall[0]:g} to {fall[1]:g} s")
    if exchange.result is not None and not exchange.is_refused:
        late = [f for f in exchange.feedback if f.ros_s > exchange.result.ros_s + LATE_S]
        if late:
            yield Violation("feedback-after-end", f"{len(late)} feedback messages after the result")


def gives_feedback(exchange: Exchange) -> Iterator[Violation]:
    """A goal that takes long reports its progress."""
    if not exchange.feedback and exchange.took_s > SILENT_LIMIT_S:
        yield Violation("no-feedback", f"no feedback in {exchange.took_s:.1f} s")


def keeps_its_timeout(exchange: Exchange) -> Iterator[Violation]:
    """A goal ends within its timeout, and says so if that was the reason."""
    result = exchange.result
    limit_s = exchange.goal.timeout
    if result is None or exchange.is_refused:
        return
    if exchange.took_s > limit_s + GRACE_S:
        yield Violation(
            "timeout-ignored",
            f"timeout {limit_s:g} s; the goal ended after {exchange.took_s:.1f} s",
        )
    elif exchange.took_s >= limit_s and not result.message.success:
        yield from _has_code(
            result, ErrorCode.TIMEOUT, "TIMEOUT", "timeout-code", cause="its timeout"
        )


def ends_when_cancelled(exchange: Exchange) -> Iterator[Violation]:
    """A cancelled goal ends at once, as cancelled."""
    result, asked = exchange.result, exchange.cancelled_wall_s
    if asked is None or result is None or result.wall_s < asked:
        return
    took = result.wall_s - asked
    if took > CANCEL_LIMIT_S:
        yield Violation(
            "slow-cancel", f"ended {took:.2f} s after the cancel; {CANCEL_LIMIT_S} s are allowed"
        )
    if result.status not in CANCELLED:
        name = STATUS_NAMES.get(result.status, result.status)
        yield Violation("cancel-status", f"a cancelled goal ended {name}; it ends PREEMPTED")
    yield from _has_code(result, ErrorCode.PREEMPTED, "PREEMPTED", "cancel-code", cause="a cancel")


def refuses_invalid_goal(field: str) -> Rule:
    """Return the rule for a goal that is invalid in this field."""

    def rule(exchange: Exchange) -> Iterator[Violation]:
        result = exchange.result
        if exchange.active_ros_s is not None or (result and not exchange.is_refused):
            yield Violation(
                "accepts-invalid-goal", "the goal was accepted; it must be REJECTED, without motion"
            )
        elif result is not None:
            code = result.message.error_code
            if code != ErrorCode.INVALID_GOAL:
                yield Violation(
                    "invalid-goal-code", f"refused with error code {code}; it is INVALID_GOAL (3)"
                )
            if field not in result.reason:
                yield Violation(
                    "invalid-goal-unnamed", f"the reason {result.reason!r} does not name {field}"
                )

    return rule


def fails_with_unknown_name(exchange: Exchange) -> Iterator[Violation]:
    """A goal with an unknown name fails."""
    if exchange.is_done:
        yield Violation("accepts-unknown-name", "the goal succeeded")


def _has_code(result: Result, code: int, name: str, rule: str, cause: str) -> Iterator[Violation]:
    if result.message.error_code != code:
        found = result.message.error_code
        yield Violation(rule, f"ended by {cause} with error code {found}; it is {name} ({code})")
