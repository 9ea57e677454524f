"""What happens in a run, as values. The engine returns them; the shell publishes them."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from enum import IntEnum

# Outcome index that withdraws a request (flexbe_msgs/OutcomeRequest).
NO_OUTCOME = 255


@dataclass(frozen=True, slots=True)
class Entered:
    """A state begins; its on_enter comes next."""

    path: str


@dataclass(frozen=True, slots=True)
class Left:
    """A supervised state took one of its declared outcomes; `index` counts them."""

    path: str
    outcome: str
    index: int


@dataclass(frozen=True, slots=True)
class Requested:
    """A supervised state requests to take an outcome; NO_OUTCOME withdraws the last request."""

    path: str
    index: int


@dataclass(frozen=True, slots=True)
class Answered:
    """A command was handled: the CommandFeedback to give."""

    command: str
    args: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Synced:
    """A mirror shall continue from this state."""

    path: str


@dataclass(frozen=True, slots=True)
class Shown:
    """Mirrors of this engine show this state from now on; empty at the end of the run.

    Mirrors of stock FlexBE follow Left and Synced, on two topics that may overtake each other.
    """

    path: str


@dataclass(frozen=True, slots=True)
class Refused:
    """A command cannot be applied; the text says why."""

    text: str


@dataclass(frozen=True, slots=True)
class Raised:
    """A state or container raised, and the run continues.

    Attributes:
        path: its path.
        error: what was raised.
        held: whether it stays active for the operator; otherwise its visit ended with the error.
    """

    path: str
    error: Exception
    held: bool


@dataclass(frozen=True, slots=True)
class Forced:
    """An operator forced an outcome; `requested` is the outcome that the state had requested.

    Returned only for the run log (Engine.recording).
    """

    path: str
    outcome: str
    requested: str | None


@dataclass(frozen=True, slots=True)
class Ended:
    """A state took an outcome, supervised or not; only for the run log (Engine.recording)."""

    path: str
    outcome: str


Event = Entered | Left | Requested | Answered | Synced | Shown | Refused | Raised | Forced | Ended


# The codes of FlexBE's wire protocol for what an engine does


class StatusCode(IntEnum):
    """Codes of flexbe_msgs/BEStatus that engines publish."""

    STARTED = 0
    FINISHED = 1
    FAILED = 2
    SWITCHING = 6
    ERROR = 11
    READY = 20


# The checksum by which FlexBE's wire protocol names sources, library entries and paths


def checksum(text: str) -> int:
    """Return the Adler-32 sum of the UTF-8 bytes, cut to 31 bits so that it fits an int32 >= 0."""
    return zlib.adler32(text.encode("utf-8")) & 0x7FFFFFFF
