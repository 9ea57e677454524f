"""Exit codes of be_launcher: how the behavior ended."""

from __future__ import annotations

from enum import IntEnum

from flexbe_widget.core.run_watch import End, Ending

# Outcome by which behaviors say, by custom, that they did not reach what they were for.
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
    ExitCode.FINISHED: "it ended with an outcome other than 'failed' and 'preempted'",
    ExitCode.FAILED_OUTCOME: "it ended with the outcome 'failed'",
    ExitCode.USAGE: "the command line makes no sense",
    ExitCode.UNKNOWN_BEHAVIOR: "there is no behavior with this name",
    ExitCode.NO_ENGINE: "no ROS master or behavior engine was there, or the engine free, in time",
    ExitCode.REFUSED: "the engine did not start it, see its log",
    ExitCode.FAILED: "a state failed in a way that the behavior does not foresee",
    ExitCode.PREEMPTED: "it was stopped",
    ExitCode.ENGINE_LOST: "the engine went away, or was restarted, while it ran",
    ExitCode.INTERRUPTED: "interrupted from the keyboard; the behavior goes on",
}

_BY_END = {
    End.FINISHED: ExitCode.FINISHED,
    End.PREEMPTED: ExitCode.PREEMPTED,
    End.FAILED: ExitCode.FAILED,
    End.REFUSED: ExitCode.REFUSED,
    End.LATE: ExitCode.REFUSED,
    End.RESTARTED: ExitCode.ENGINE_LOST,
    End.LOST: ExitCode.ENGINE_LOST,
}


def exit_code(ending: Ending) -> ExitCode:
    """Return the exit code that tells how a run ended."""
    if ending.outcome == FAILED_OUTCOME:
        return ExitCode.FAILED_OUTCOME
    return _BY_END[ending.end]
