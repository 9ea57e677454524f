"""Follow one run by the statuses of the engine, and choose which progress is worth a line.

    SENT --STARTED--> RUNNING --FINISHED, FAILED--> ended    (--SWITCHING, STARTED--> RUNNING)
      |                  |
      +--ERROR----> ended (refused)
      +--READY-----------+----> ended (the engine was restarted)
      +--silence---------+----> ended (the engine is gone)
      +--START_LIMIT_S--> ended (the engine is still preparing it)

Statuses carry the checksum of the behavior's source; those of other behaviors are ignored. An
operator may switch the behavior to another version: from then on that version is followed. Any
number of statuses may have arrived before the request was sent; they show what the engine does.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass
from enum import Enum, IntEnum

from flexbe_core.engine.supervision import PREEMPTED, StatusCode

# [s] Wall time without a heartbeat (1 Hz) after which the engine counts as gone.
SILENCE_S = 5.0

# [s] Wall time that the engine gets to prepare a behavior. Each missing action server delays it by
# up to 10 s.
START_LIMIT_S = 300.0

# Beginnings of the status text of an aborted goal, by which clients distinguish a failed behavior
# from a lost engine: part of the interface, see the README.
FAILED_TEXT = "failed: "
NOT_STARTED_TEXT = "not started: "
ENGINE_LOST_TEXT = "engine lost: "
SERVER_ENDED_TEXT = "action server ended: "


class RunEnd(Enum):
    """How a run ended."""

    FINISHED = "finished"
    PREEMPTED = "preempted"
    FAILED = "failed"
    REFUSED = "refused"
    LATE = "late"
    RESTARTED = "restarted"
    LOST = "lost"


@dataclass(frozen=True)
class Ending:
    """How a run ended, and with what outcome if it has one."""

    end: RunEnd
    outcome: str = ""


class RunWatch:
    """One run, from the request on.

    Attributes:
        is_running: whether the engine has begun with it.
    """

    def __init__(self, behavior_id: int) -> None:
        """Follow the run of the behavior whose source has this checksum; it was just requested."""
        self._behavior_id = behavior_id
        self._is_switching = False
        self.is_running = False

    def on_status(self, code: int, behavior_id: int, args: tuple[str, ...]) -> Ending | None:
        """Return how the run ended, if a status says so."""
        if code == StatusCode.READY:
            return Ending(RunEnd.RESTARTED)
        if self._is_switching and code == StatusCode.STARTED:
            self._behavior_id, self._is_switching = behavior_id, False
        if not self.concerns(behavior_id):
            return None
        if code == StatusCode.STARTED:
            self.is_running = True
        elif code == StatusCode.SWITCHING:
            self._is_switching = True
        elif code == StatusCode.ERROR and not self.is_running:
            return Ending(RunEnd.REFUSED)
        elif self.is_running and code == StatusCode.FAILED:
            return Ending(RunEnd.FAILED)
        elif self.is_running and code == StatusCode.FINISHED:
            outcome = args[0] if args else ""
            return Ending(RunEnd.PREEMPTED if outcome == PREEMPTED else RunEnd.FINISHED, outcome)
        return None

    def on_time(self, waited_s: float, silent_s: float) -> Ending | None:
        """Return how the run ended, if it ended without a status.

        Args:
            waited_s: [s] since the request.
            silent_s: [s] since the last message of the engine.
        """
        if silent_s > SILENCE_S:
            return Ending(RunEnd.LOST)
        is_late = not self.is_running and waited_s > START_LIMIT_S
        return Ending(RunEnd.LATE) if is_late else None

    def concerns(self, behavior_id: int) -> bool:
        """Return whether a status with this checksum is about this run."""
        return behavior_id == self._behavior_id


def is_busy(code: int) -> bool:
    """Return whether an engine whose last status this is runs a behavior."""
    return code in (StatusCode.STARTED, StatusCode.SWITCHING)


# Exit codes of be_launcher: how the behavior ended


# Outcome that, by convention, means that a behavior did not reach its purpose.
FAILED_OUTCOME = "failed"


class ExitCode(IntEnum):
    """How the behavior ended."""

    FINISHED = 0
    FAILED_OUTCOME = 1
    USAGE = 2
    UNKNOWN_BEHAVIOR = 3
    NO_ENGINE = 4
    REFUSED = 5
    FAILED = 6
    PREEMPTED = 7
    ENGINE_LOST = 8
    INTERRUPTED = 130


MEANINGS = {
    ExitCode.FINISHED: "it ended with an outcome of --success, or else not 'failed' or 'preempted'",
    ExitCode.FAILED_OUTCOME: "it ended with another outcome than those, such as 'failed'",
    ExitCode.USAGE: "usage error",
    ExitCode.UNKNOWN_BEHAVIOR: "there is no behavior with this name",
    ExitCode.NO_ENGINE: "no ROS master or no free behavior engine in time",
    ExitCode.REFUSED: "the engine did not start it, see its log",
    ExitCode.FAILED: "a state failed in a way that the behavior does not handle",
    ExitCode.PREEMPTED: "it was stopped",
    ExitCode.ENGINE_LOST: "the engine stopped, or was restarted, while it ran",
    ExitCode.INTERRUPTED: "interrupted from the keyboard; the behavior continues",
}

_BY_END = {
    RunEnd.FINISHED: ExitCode.FINISHED,
    RunEnd.PREEMPTED: ExitCode.PREEMPTED,
    RunEnd.FAILED: ExitCode.FAILED,
    RunEnd.REFUSED: ExitCode.REFUSED,
    RunEnd.LATE: ExitCode.REFUSED,
    RunEnd.RESTARTED: ExitCode.ENGINE_LOST,
    RunEnd.LOST: ExitCode.ENGINE_LOST,
}


def exit_code(ending: Ending, success: Collection[str] = ()) -> ExitCode:
    """Return the exit code for the end of a run; any outcome but these is no success, if given."""
    is_failed = ending.outcome not in success if success else ending.outcome == FAILED_OUTCOME
    if ending.end is RunEnd.FINISHED and is_failed:
        return ExitCode.FAILED_OUTCOME
    return _BY_END[ending.end]


# [%] An action that reports nothing else is printed again after this much more.
_STEP = 25.0

_NUMBER = re.compile(r"\d+(?:\.\d+)?")


class Progress:
    """The progress of one action: a line for each step, and for each quarter of its work."""

    def __init__(self, name: str) -> None:
        """Begin with nothing printed.

        Args:
            name: of the action, such as InsertCable.
        """
        self._name = name
        self._goal = self._step = ""
        self._printed = 0.0

    def line(self, goal: str, step: str, percentage: float) -> str:
        """Return what is worth printing of a feedback; empty if nothing is.

        Args:
            goal: its actionlib id.
            step: what is being done, for a person. Another number in it is no other step.
            percentage: how much is done, 0 to 100.
        """
        what = _NUMBER.sub("", step)
        if goal == self._goal and what == self._step and percentage < self._printed + _STEP:
            return ""
        self._goal, self._step, self._printed = goal, what, percentage
        return f"{self._name} {percentage:.0f} %: {step}"
