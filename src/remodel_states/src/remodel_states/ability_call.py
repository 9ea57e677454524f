"""The base of all ability states: one goal to one ability server, from sending to record.

A state owns an `AbilityCall` and forwards its events to it:

    on_enter           -> start(goal)   send the goal
    execute            -> outcome()     None while it runs, then the state's outcome
    on_exit, on_stop   -> finish()      cancel what still runs, publish the record

on_stop too, since stock FlexBE calls no on_exit on preempt; the second call does nothing.

It is a part of the state, not a parent class: the FlexBE App reads only states whose base is
`EventState` itself.

How an execution ends (first row that holds):

    the goal could not be sent, no server               command_error  SERVER_LOST
    the server refused the goal                         command_error  its code, or INVALID_GOAL
    the answer contradicts itself, or has another id    failed         CONTRADICTORY_RESULT
    the server answered: success                        <done>
    the server answered: not successful                 failed         its code
    the server has gone away during the goal            command_error  SERVER_LOST
    timeout_s + GRACE_S have passed without an answer   failed         SERVER_HUNG

The server ends a goal at its timeout; the last row only bounds the wait for one that does not.

With a recorder (see record_keeping), `outcome()` stays None until the record is kept. One that is
not kept in time ends the state with command_error, SERVER_LOST; the record still says how the
operation itself ended.
"""

from __future__ import annotations

import rospy
from actionlib_msgs.msg import GoalStatus
from genpy import Message
from geometry_msgs.msg import PoseStamped
from remodel_msgs.msg import AbilityRecord, ErrorCode

from flexbe_core import EventState, Logger
from flexbe_core.core import UserData
from flexbe_core.proxy import ProxyActionClient, ProxyPublisher
from remodel_states.record_keeping import (
    KEEP_LIMIT_S,
    RECORDER_PARAMETER,
    Keeping,
    keeper,
    recorder,
)

RECORD_TOPIC = "remodel/ability_records"

# [s] ROS time that a server gets beyond the goal's timeout to report that it ended by itself.
GRACE_S = 2.0

# [Hz] of polling: FlexBE's default, and while the record is on its way, which takes milliseconds.
_RATE_HZ = 10.0
_KEEPING_RATE_HZ = 250.0

# What every result has; the rest is what the ability found out.
_COMMON = frozenset({"id", "success", "message", "elapsed_time", "error_code", "error_message"})

COMMAND_ERROR = "command_error"
FAILED = "failed"


class AbilityCall:
    """One state's line to one ability server."""

    def __init__(
        self, state: EventState, action_type: type, topic: str, timeout_s: float, done: str
    ) -> None:
        """Connect to the server; stock FlexBE's proxies warn now if it is not there.

        Args:
            state: the state that owns this call; its path names the record.
            action_type: `...Action` class of the ability.
            topic: action topic.
            timeout_s: [s] ROS time that the ability gets, > 0.
            done: the state's outcome when the ability succeeds.

        Raises:
            ValueError: if timeout_s is not a positive number.
        """
        if not 0 < timeout_s < float("inf"):
            raise ValueError(f"timeout_s of {topic} must be a positive number, found {timeout_s!r}")
        self._state = state
        self._ability = action_type.__name__.removesuffix("Action")
        self._topic = topic
        self._timeout_s = float(timeout_s)
        self._done = done
        self._client = ProxyActionClient({topic: action_type})
        self._records = ProxyPublisher({RECORD_TOPIC: AbilityRecord})
        self._goals_sent = 0
        self._goal: Message | None = None
        self._running = False
        self.result: Message | None = None
        self.error_code = ErrorCode.NONE
        self.error_message = ""
        self._outcome: str | None = None
        self._record: AbilityRecord | None = None
        self._keeping: Keeping | None = None
        self._recorder: str | None = None

    def start(self, goal: Message) -> None:
        """Fill the goal's id (unless it has one) and timeout, and send it."""
        self._goals_sent += 1
        goal.id = goal.id or f"{self._behavior()}{self._state.path}#{self._goals_sent}"
        goal.timeout = self._timeout_s
        self._goal = goal
        self.result = None
        self._outcome = None
        self._record = None
        self._keeping = None
        self.error_code, self.error_message = ErrorCode.NONE, ""
        self._running = True
        self._started = rospy.Time.now()
        trouble = self._send(goal)
        if self._recorder is None:
            # Asked while the ability works, and once: behaviors are built anew for each run.
            self._recorder = recorder()
        if trouble:
            self._end(COMMAND_ERROR, ErrorCode.SERVER_LOST, trouble)

    def outcome(self) -> str | None:
        """Return the state's outcome, or None while the ability runs or its record is not kept."""
        if self._running:
            self._look()
        if self._keeping is not None:
            self._look_at_keeping(self._keeping)
        return None if self._keeping is not None else self._outcome

    def finish(self) -> None:
        """Cancel the goal if it still runs, and publish the record, once per start."""
        if self._goal is None:
            return
        if self._running:
            self._client.cancel(self._topic)
            self._running = False
            self.error_code = ErrorCode.PREEMPTED
            self.error_message = "the state was left while the ability ran; its goal is cancelled"
            self._close_record()
        if self._keeping is not None:
            self._keeping.give_up()
            self._stop_keeping()
        self._records.publish(RECORD_TOPIC, self._record)
        self._goal = None

    def write_errors(self, userdata: UserData) -> None:
        """Write error_code and error_message of a failure; a success leaves them as they are."""
        if self.error_code != ErrorCode.NONE:
            userdata.error_code = self.error_code
            userdata.error_message = self.error_message

    def _send(self, goal: Message) -> str:
        """Send a goal; return why that was not possible, or nothing."""
        try:
            self._client.send_goal(self._topic, goal)
        except Exception as error:  # noqa: BLE001 - stock's proxy promises no narrower type
            return f"could not send the goal: {error}"
        return ""

    def _look(self) -> None:
        if self._client.has_result(self._topic):
            self._end_by(self._client.get_result(self._topic), self._client.get_state(self._topic))
        elif not self._client.is_available(self._topic):
            text = f"the server of {self._topic} went away during goal {self._goal.id}"
            self._end(COMMAND_ERROR, ErrorCode.SERVER_LOST, text)
        elif (rospy.Time.now() - self._started).to_sec() > self._timeout_s + GRACE_S:
            self._client.cancel(self._topic)
            text = f"{self._topic} did not end goal {self._goal.id} within {self._timeout_s:g} s"
            self._end(FAILED, ErrorCode.SERVER_HUNG, text)

    def _end_by(self, result: Message | None, status: int) -> None:
        self.result = result
        refused = status in (GoalStatus.REJECTED, GoalStatus.LOST) or result is None
        if refused:
            code = result.error_code if result else ErrorCode.NONE
            text = (result.error_message if result else "") or self._status_text()
            self._end(COMMAND_ERROR, code or ErrorCode.INVALID_GOAL, text)
        elif contradiction := self._contradiction(result, status):
            self._end(FAILED, ErrorCode.CONTRADICTORY_RESULT, contradiction)
        elif status == GoalStatus.SUCCEEDED and result.success:
            self._end(self._done, ErrorCode.NONE, "")
        else:
            text = result.error_message or self._status_text()
            self._end(FAILED, result.error_code or ErrorCode.INTERNAL, text)

    def _contradiction(self, result: Message, status: int) -> str:
        """Return what cannot be true about an answer; empty if it makes sense."""
        if result.id != self._goal.id:
            return f"the result is of goal {result.id!r}, not of {self._goal.id!r}"
        if result.success and result.error_code != ErrorCode.NONE:
            return f"the result says success, with error code {result.error_code}"
        if result.success != (status == GoalStatus.SUCCEEDED):
            return f"the result says success {result.success}, with action status {status}"
        return ""

    def _status_text(self) -> str:
        return self._client.get_goal_status_text(self._topic) or "the server gave no reason"

    def _end(self, outcome: str, code: int, text: str) -> None:
        self._running = False
        self._outcome = outcome
        self.error_code, self.error_message = code, text
        if code != ErrorCode.NONE:
            Logger.logwarn(f"{self._ability} {outcome}: error {code}: {text}")
        self._close_record()

    def _look_at_keeping(self, keeping: Keeping) -> None:
        if keeping.is_settled:
            self._stop_keeping()
        elif keeping.is_overdue:
            keeping.give_up()
            self._stop_keeping()
            self._outcome = COMMAND_ERROR
            self.error_code = ErrorCode.SERVER_LOST
            self.error_message = (
                f"the record of {self._goal.id} was not kept within {KEEP_LIMIT_S:g} s by "
                f"{keeping.recorder}: {keeping.trouble or 'no answer'}. Start it; `rosparam delete "
                f"{rospy.resolve_name(RECORDER_PARAMETER)}` lets behaviors run unrecorded"
            )
            Logger.logwarn(f"{self._ability} {COMMAND_ERROR}: {self.error_message}")

    def _stop_keeping(self) -> None:
        self._keeping = None
        self._state.set_rate(_RATE_HZ)

    def _close_record(self) -> None:
        """Write the record of a call that has ended, and begin to have it kept if it must be."""
        self._record = self._written_record()
        if self._recorder:
            self._keeping = keeper().keep(self._record, self._recorder)
            self._state.set_rate(_KEEPING_RATE_HZ)

    def _written_record(self) -> AbilityRecord:
        return AbilityRecord(
            stamp=rospy.Time.now(),
            behavior=self._behavior(),
            state_path=self._state.path,
            ability=self._ability,
            topic=self._topic,
            goal_id=self._goal.id,
            outcome=self._outcome or "",
            success=self._outcome == self._done,
            error_code=self.error_code,
            message=getattr(self.result, "message", ""),
            error_message=self.error_message,
            elapsed_time=(rospy.Time.now() - self._started).to_sec(),
            parameters=_told(self._goal, frozenset({"id"})),
            measurements=_told(self.result, _COMMON) if self.result else [],
        )

    def _behavior(self) -> str:
        """Return the root state machine's name, which is the behavior's; empty for a lone state."""
        node = self._state.parent
        while node is not None and node.parent is not None:
            node = node.parent
        return node.name or "" if node is not None else ""


def _told(message: Message, left_out: frozenset[str]) -> list[str]:
    """Return the numbers, truth values, texts and poses of a message as "name=value"."""
    fields = {name: getattr(message, name) for name in message.__slots__ if name not in left_out}
    texts = {name: _text(value) for name, value in fields.items()}
    return [f"{name}={text}" for name, text in texts.items() if text is not None]


def _text(value: object) -> str | None:
    """Return a value as text; None of what is neither plain nor a pose, or several."""
    if isinstance(value, bool | int | float | str):
        return str(value)
    if isinstance(value, PoseStamped):
        position, turn = value.pose.position, value.pose.orientation
        numbers = (position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w)
        return " ".join(
            [value.header.frame_id or "-", *(f"{round(n, 6) + 0.0:g}" for n in numbers)]
        )
    if isinstance(value, list) and value and all(isinstance(item, PoseStamped) for item in value):
        return "; ".join(str(_text(item)) for item in value)
    return None
