"""For tests: scripted states, a way to run a single state without ROS, and waits."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar
from xmlrpc.client import ServerProxy

import rosgraph
import rospy

from flexbe_core.core.event_state import EventState
from flexbe_core.core.operatable_state_machine import OperatableStateMachine
from flexbe_core.engine.engine import Engine, ErrorPolicy
from flexbe_core.engine.user_data import UserData
from flexbe_core.ros.master import senders

Log = list[tuple[str, str]]

# [s] Wall time between two checks of a condition.
_POLL_S = 0.005

Found = TypeVar("Found")


def wait_until(condition: Callable[[], Found], limit_s: float = 90.0) -> Found:
    """Return what the condition returns, as soon as that is true or after `limit_s` [s, wall]."""
    end = time.monotonic() + limit_s
    while not (found := condition()) and time.monotonic() < end:
        time.sleep(_POLL_S)
    return found


def is_sent_to(subscriber: rospy.Subscriber) -> bool:
    """Return whether a publisher sends to a subscriber.

    A node enters a connection after it has answered, which is all that the subscriber knows of:
    what the node publishes in between is lost. So it is asked, by getBusInfo of the slave API.
    """
    own, topic = rospy.get_name(), subscriber.resolved_name
    for node in senders(subscriber):
        try:
            slave: Any = ServerProxy(rosgraph.Master(own).lookupNode(node))
            _, _, connections = slave.getBusInfo(own)
        except (rosgraph.MasterException, OSError):
            continue
        if any((end[1], end[2], end[4]) == (own, "o", topic) for end in connections):
            return True
    return False


def run_state(
    state: EventState, inputs: Mapping[str, Any] | None = None, executions: int = 10
) -> tuple[str | None, dict[str, Any]]:
    """Run one state, as a behavior would.

    Args:
        state: the state.
        inputs: its userdata.
        executions: give up after this many.

    Returns:
        its outcome, None if there is none by then, and the userdata afterwards.

    Raises:
        BehaviorFailure: if it raises, or returns an outcome that it does not have.
    """
    machine = OperatableStateMachine(outcomes=[f"{name} of it" for name in state.outcomes])
    for key, value in (inputs or {}).items():
        machine.userdata[key] = value
    transitions = {name: f"{name} of it" for name in state.outcomes}
    with machine:
        OperatableStateMachine.add("state", state, transitions)
    data = UserData()
    engine = Engine(machine, ErrorPolicy.FAIL)
    engine.begin(data)
    for now in range(executions):
        outcome = engine.run(float(now))
        if outcome is not None:
            return outcome.removesuffix(" of it"), dict(data._data)
    return None, dict(data._data)


class ScriptedState(EventState):
    """A state whose executions are scripted.

    Each execution takes the next item of the script, the last one over and over: an outcome or
    None is returned, an exception is raised.
    """

    def __init__(
        self,
        script: Sequence[str | Exception | None] = ("done",),
        outcomes: Sequence[str] = ("done",),
        log: Log | None = None,
        input_keys: Sequence[str] = (),
        output_keys: Sequence[str] = (),
    ) -> None:
        """Follow `script`, and append (label, event) to `log`."""
        super().__init__(outcomes=outcomes, input_keys=input_keys, output_keys=output_keys)
        self.log: Log = [] if log is None else log
        self._script = list(script)
        self._step = 0

    def execute(self, userdata: UserData) -> str | None:
        """Do the next step."""
        self._log_event("execute")
        item = self._script[min(self._step, len(self._script) - 1)]
        self._step += 1
        if isinstance(item, Exception):
            raise item
        return item

    def on_start(self) -> None:
        """Remember the call."""
        self._log_event("start")

    def on_stop(self) -> None:
        """Remember the call."""
        self._log_event("stop")

    def on_enter(self, userdata: UserData) -> None:
        """Remember the call."""
        self._log_event("enter")

    def on_exit(self, userdata: UserData) -> None:
        """Remember the call."""
        self._log_event("exit")

    def on_pause(self) -> None:
        """Remember the call."""
        self._log_event("pause")

    def on_resume(self, userdata: UserData) -> None:
        """Remember the call."""
        self._log_event("resume")

    def _log_event(self, event: str) -> None:
        self.log.append((self.name or "", event))
