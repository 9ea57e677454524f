"""The base of all ability states: one goal to one ability server, from sending to record.

A state owns an `AbilityCall` and forwards its events to it:

    on_enter           -> start(goal)   send the goal
    execute            -> outcome()     None while it runs, then the state's outcome
    on_exit, on_stop   -> finish()      cancel what still runs, publish the record

on_stop too, since stock FlexBE calls no on_exit on preempt; the second call does nothing.

It is a part of the state, not a parent class: the FlexBE App reads only states whose base is
`EventState` itself.

How an execution ends (first row that holds):

    the supervisor refused the goal                     command_error  PREEMPTED, without a record
    more than one server serves the action              command_error  SEVERAL_SERVERS
    the goal could not be sent, no server               command_error  SERVER_LOST
    the server refused the goal                         command_error  its code, or INVALID_GOAL
    the answer contradicts itself, or has another id    failed         CONTRADICTORY_RESULT
    the server answered: success                        <done>
    the server answered: not successful                 failed         its code
    the server stopped during the goal                  command_error  SERVER_LOST
    timeout_s + GRACE_S have passed without an answer   failed         SERVER_HUNG

The server ends a goal at its timeout; the last row only bounds the wait for one that does not. A
goal whose end is not known is always cancelled: a server that was only stopped must not continue it
later.

With a supervisor (see record_keeping), `start()` asks for a permit, and `outcome()` sends the goal
once it is granted; the timeout counts from then. `outcome()` stays None until the record is kept.
Both waits have no time limit: while the parameter names a supervisor, nothing moves without it.
"""

from __future__ import annotations

import time

import rospy
from actionlib_msgs.msg import GoalStatus
from genpy import Message
from remodel_msgs.msg import AbilityRecord, ErrorCode
from remodel_msgs.srv import BeginOperationRequest

from flexbe_core import EventState
from flexbe_core.core import UserData
from remodel_states.core.contract import GRACE_S, RosStopwatch
from remodel_states.core.tables import COMMON_RESULT
from remodel_states.line import Keeping, Permit, described, line, owned_id

# [Hz] of polling: FlexBE's default, and while the supervisor is asked, which takes milliseconds.
_RATE_HZ = 10.0
_ASKING_RATE_HZ = 250.0

COMMAND_ERROR = "command_error"
FAILED = "failed"


class AbilityCall:
    """One state's connection to one ability server."""

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
        self._line = line()
        self._client = self._line.client(topic, action_type)
        self._goals_sent = 0
        self._goal: Message | None = None
        self._running = False
        self.result: Message | None = None
        self.error_code = ErrorCode.NONE
        self.error_message = ""
        self._outcome: str | None = None
        self._record: AbilityRecord | None = None
        self._permit: Permit | None = None
        self._keeping: Keeping | None = None
        self._recorder: str | None = None
        self._stopwatch = _stopwatch()

    def start(self, goal: Message) -> None:
        """Fill the goal's id (unless it has one) and timeout, and send it when that is granted."""
        self._goals_sent += 1
        goal.id = goal.id or f"{self._behavior()}{self._state.path}#{self._goals_sent}"
        goal.timeout = self._timeout_s
        self._goal = goal
        self.result = None
        self._running = False
        self._outcome = None
        self._record = None
        self._keeping = None
        self.error_code, self.error_message = ErrorCode.NONE, ""
        trouble = ""
        if self._recorder is None:
            # Asked once: behaviors are built again for each run.
            try:
                self._recorder = self._line.recorder()
            except Exception as error:  # noqa: BLE001 - a missing master may cause anything
                trouble = f"no ROS master: {error}"
        if self._recorder or trouble:
            operation = BeginOperationRequest(self._behavior(), self._state.path, self._ability)
            self._permit = self._line.keeper().ask(operation, self._recorder or "", trouble)
            self._state.set_rate(_ASKING_RATE_HZ)
        else:
            self._send()

    def outcome(self) -> str | None:
        """Return the state's outcome; None while it asks, runs, or its record is not kept."""
        if self._permit is not None:
            self._check_permit(self._permit)
        if self._running:
            self._check_goal()
        if self._keeping is not None:
            self._check_keeping(self._keeping)
        return None if self._permit or self._keeping else self._outcome

    def finish(self) -> None:
        """Cancel the goal if it still runs, and publish the record, once per goal sent."""
        if self._goal is None:
            return
        if self._permit is not None or self._running:
            self._leave()
        if self._keeping is not None:
            self._line.keeper().withdraw(self._keeping)
            self._stop_keeping()
        if self._record is not None:
            self._line.publish(self._record)
        self._goal = None

    def write_errors(self, userdata: UserData) -> None:
        """Write error_code and error_message of a failure; a success leaves them as they are."""
        if self.error_code != ErrorCode.NONE:
            userdata.error_code = self.error_code
            userdata.error_message = self.error_message

    def _leave(self) -> None:
        """End as a state that is left before its operation has ended."""
        self.error_code = ErrorCode.PREEMPTED
        if self._permit is not None:
            self.error_message = "the state was left before its goal was sent"
            self._line.keeper().give_back(self._permit, self._written_record())
            self._permit = None
            self._state.set_rate(_RATE_HZ)
        else:
            self._client.cancel(self._topic)
            self._running = False
            self.error_message = "the state was left while the ability ran; its goal is cancelled"
            self._close_record()

    def _check_permit(self, permit: Permit) -> None:
        if not permit.is_final:
            self._warn(permit)
            return
        self._permit = None
        self._state.set_rate(_RATE_HZ)
        if permit.is_refused:
            text = f"the supervisor refused goal {self._goal.id}: {permit.message}"
            self._set_end(COMMAND_ERROR, ErrorCode.PREEMPTED, text)
            return
        self._recorder = permit.recorder
        self._goal.id = owned_id(permit.owner, self._goal.id)
        self._send()

    def _send(self) -> None:
        self._stopwatch = _stopwatch()
        servers = self._servers()
        if len(servers) > 1:
            text = (
                f"{self._topic} is served by {' and '.join(servers)}, so goal {self._goal.id} was "
                "not sent: each of them would execute it. Stop all but one"
            )
            self._end(COMMAND_ERROR, ErrorCode.SEVERAL_SERVERS, text)
            return
        try:
            self._client.send_goal(self._topic, self._goal)
            self._running = True
        except Exception as error:  # noqa: BLE001 - stock's proxy promises no narrower type
            text = f"could not send the goal: {error}"
            self._end(COMMAND_ERROR, ErrorCode.SERVER_LOST, text)

    def _servers(self) -> tuple[str, ...]:
        """Return the nodes that serve the action; none with stock FlexBE, which cannot know."""
        servers = getattr(self._client, "servers", None)
        return servers(self._topic) if servers is not None else ()

    def _check_goal(self) -> None:
        if self._client.has_result(self._topic):
            self._end_by(self._client.get_result(self._topic), self._client.get_state(self._topic))
        elif not self._client.is_available(self._topic):
            self._client.cancel(self._topic)
            text = f"the server of {self._topic} stopped during goal {self._goal.id}"
            self._end(COMMAND_ERROR, ErrorCode.SERVER_LOST, text)
        elif self._stopwatch.read() > self._timeout_s + GRACE_S:
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
        """Return the contradiction in an answer; empty if there is none."""
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
        self._set_end(outcome, code, text)
        self._close_record()

    def _set_end(self, outcome: str, code: int, text: str) -> None:
        self._outcome = outcome
        self.error_code, self.error_message = code, text
        if code != ErrorCode.NONE:
            self._line.warn(f"{self._ability} {outcome}: error {code}: {text}")

    def _check_keeping(self, keeping: Keeping) -> None:
        if keeping.is_final:
            self._stop_keeping()
        else:
            self._warn(keeping)

    def _stop_keeping(self) -> None:
        self._keeping = None
        self._state.set_rate(_RATE_HZ)

    def _close_record(self) -> None:
        """Write the record of a call that has ended, and begin to have it kept if it must be."""
        self._record = self._written_record()
        if self._recorder:
            self._keeping = self._line.keeper().keep(self._record, self._recorder)
            self._state.set_rate(_ASKING_RATE_HZ)

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
            elapsed_time=self._stopwatch.read(),
            parameters=described(self._goal, ("id",)),
            measurements=described(self.result, COMMON_RESULT) if self.result else [],
        )

    def _warn(self, request: Permit | Keeping) -> None:
        """Log what a request waits for, if that is due."""
        if warning := request.warning:
            self._line.warn(warning)

    def _behavior(self) -> str:
        """Return the root state machine's name, which is the behavior's; empty for a lone state."""
        node = self._state.parent
        while node is not None and node.parent is not None:
            node = node.parent
        return node.name or "" if node is not None else ""


def _stopwatch() -> RosStopwatch:
    """Return a stopwatch that starts now."""
    return RosStopwatch(lambda: rospy.Time.now().to_sec(), time.monotonic)
