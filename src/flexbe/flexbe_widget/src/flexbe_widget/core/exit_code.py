"""Exit codes of be_launcher: how the behavior ended."""

from __future__ import annotations

from collections.abc import Collection
from enum import IntEnum

from flexbe_widget.core.run_watch import Ending, RunEnd

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
