"""Run one behavior from the command line."""

from __future__ import annotations

import queue
import sys
import time
from collections.abc import Collection

from flexbe_msgs.msg import BehaviorLog, BehaviorSelection

from flexbe_widget.core.run_watch import (
    SILENCE_S,
    START_LIMIT_S,
    Ending,
    ExitCode,
    RunEnd,
    RunWatch,
    exit_code,
    is_busy,
)
from flexbe_widget.ros.engine_link import (
    ActionFeedback,
    EngineLink,
    Entered,
    Logged,
    Progressed,
    Status,
)

# [s] Wall time between two checks of the heartbeat.
_CHECK_EVERY_S = 0.5

# [s] Wall time between two checks whether the engine is there and free.
_CHECK_ENGINE_EVERY_S = 0.01

# [s] Wall time after which waiting for the engine is printed.
_PRINT_AFTER_S = 0.5

# [s] Wall time by which log messages may arrive after a status that was sent later, at most and
# until there is a gap.
_LATE_LOG_S = 0.5
_GAP_S = 0.05

_PRINTED = {BehaviorLog.WARN: "warning", BehaviorLog.ERROR: "error", BehaviorLog.HINT: "hint"}


class Launch:
    """One behavior, from the request to its end, with its progress printed on the terminal."""

    def __init__(self, name: str, success: Collection[str] = ()) -> None:
        """Connect to the engine, to run the behavior with this display name.

        Args:
            name: display name of the behavior.
            success: outcomes that are a success; none for all but 'failed' and 'preempted'.
        """
        self._name = name
        self._success = success
        self._events: queue.SimpleQueue[object] = queue.SimpleQueue()
        self._link = EngineLink(self._events.put)
        self._feedback = ActionFeedback(self._events.put)

    def run(self, request: BehaviorSelection, wait_s: float) -> ExitCode:
        """Run the behavior and return how it ended.

        Args:
            request: the request to send to the engine.
            wait_s: [s] how long to wait for an engine that is there and free.
        """
        if not self._wait_for_engine(wait_s):
            return ExitCode.NO_ENGINE
        watch = RunWatch(request.behavior_checksum)
        ending = self._follow(watch, self._link.start(request))
        if ending.end in (RunEnd.FAILED, RunEnd.REFUSED):
            self._link.why()
        self._print_late_log()
        say(self._end_text(ending))
        return exit_code(ending, self._success)

    def _wait_for_engine(self, wait_s: float) -> bool:
        """Wait until the engine is there and free; return whether it is."""
        begin = time.monotonic()
        printed = ""
        while self._hindrance():
            waited_s = time.monotonic() - begin
            if waited_s >= wait_s:
                say(f"{self._hindrance()}; gave up after {wait_s:g} s")
                return False
            if waited_s >= _PRINT_AFTER_S and printed != self._hindrance():
                printed = self._hindrance()
                say(f"{printed}; waiting up to {wait_s:g} s")
            self._next_event(min(_CHECK_ENGINE_EVERY_S, wait_s - waited_s))
        return True

    def _hindrance(self) -> str:
        """Return why the behavior cannot be started now; empty if it can."""
        status = self._link.last_status
        if status is not None and not self._link.is_there and self._link.silent_s() <= SILENCE_S:
            return (
                "the engine does not listen to this node "
                "(does each resolve the other's host name, and are both of one version?)"
            )
        if status is None or not self._link.is_there:
            return (
                "there is no behavior engine "
                "(start it with: roslaunch flexbe_onboard behavior_onboard.launch)"
            )
        if is_busy(status.code):
            return (
                "the engine runs another behavior "
                "(stop it with: rostopic pub -1 /flexbe/commands/preempt std_msgs/Empty)"
            )
        return ""

    def _follow(self, watch: RunWatch, older: int) -> Ending:
        ending = None
        asked = time.monotonic()
        while ending is None:
            event = self._next_event(_CHECK_EVERY_S)
            if isinstance(event, Status) and event.number <= older:
                continue
            if isinstance(event, Status):
                was_running = watch.is_running
                ending = watch.on_status(event.code, event.behavior_id, event.args)
                if watch.is_running and not was_running:
                    say(f"'{self._name}' started")
                    self._feedback.begin()
            elif isinstance(event, Entered) and event.path:
                say(f"'{self._name}' is at {event.path}")
            elif isinstance(event, Progressed):
                say(event.text)
            elif isinstance(event, Logged):
                self._print_log(event)
            else:
                ending = watch.on_time(time.monotonic() - asked, self._link.silent_s())
        if ending.end is RunEnd.LATE:
            self._link.preempt()
        return ending

    def _print_log(self, event: Logged) -> None:
        if event.severity in _PRINTED:
            say(f"{_PRINTED[event.severity]}: {event.text}")

    def _print_late_log(self) -> None:
        """Print what was logged before the behavior ended, but arrives after its last status."""
        end = time.monotonic() + _LATE_LOG_S
        while time.monotonic() < end and (event := self._next_event(_GAP_S)) is not None:
            if isinstance(event, Logged):
                self._print_log(event)

    def _next_event(self, timeout_s: float) -> object:
        """Return the next event, None if there is none in time."""
        try:
            return self._events.get(timeout=max(0.0, timeout_s))
        except queue.Empty:
            return None

    def _end_text(self, ending: Ending) -> str:
        text = {
            RunEnd.FINISHED: f"ended with outcome '{ending.outcome}'",
            RunEnd.PREEMPTED: "was stopped",
            RunEnd.FAILED: "failed",
            RunEnd.REFUSED: "was not started",
            RunEnd.LATE: f"has not started after {START_LIMIT_S:g} s, and is cancelled",
            RunEnd.RESTARTED: "is lost: the engine was restarted",
            RunEnd.LOST: "is lost: the engine is silent",
        }[ending.end]
        return f"'{self._name}' {text}"


def say(text: str) -> None:
    """Print a line on the terminal."""
    sys.stdout.write(f"be_launcher: {text}\n")
    sys.stdout.flush()
