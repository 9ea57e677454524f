"""What an operator can order the engine to do, and the lines of its log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

STEP, FULL = 0, 3  # autonomy levels: the engine asks before each transition, or as good as none
UNATTENDED = 255  # the autonomy level that asks no operator, from FlexBE's wire protocol
LEVELS = {STEP: "off", 1: "low", 2: "high", FULL: "full", UNATTENDED: "unattended"}

Pairs: TypeAlias = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Start:
    """Run a behavior.

    Attributes:
        name: display name, for the record.
        behavior_id: checksum of `package.module`.
        source_checksum: checksum of its source, so that the engine runs the version shown.
        level: autonomy level.
        parameters: (key, literal) pairs.
        inputs: (key, literal) pairs of userdata.
        start_at: path of the state to start at, `/Place/Insert`; empty: the first.
    """

    name: str
    behavior_id: int
    source_checksum: int
    level: int
    parameters: Pairs = ()
    inputs: Pairs = ()
    start_at: str = ""

    def __str__(self) -> str:
        given = " ".join(f"{key}={value}" for key, value in (*self.parameters, *self.inputs))
        where = f" at {self.start_at}" if self.start_at else ""
        level = LEVELS.get(self.level, self.level)
        return f"start '{self.name}'{where} level {level} {given}".rstrip()


@dataclass(frozen=True)
class Switch:
    """Go on in another version of the behavior that runs; its active state is locked there.

    Attributes:
        name: display name, for the record.
        behavior_id: checksum of `package.module`.
        source_checksum: checksum of the source of that version.
        level: autonomy level, which stays.
    """

    name: str
    behavior_id: int
    source_checksum: int
    level: int

    def __str__(self) -> str:
        return f"switch to the saved version of '{self.name}'"


@dataclass(frozen=True)
class Attach:
    """Supervise the running behavior at an autonomy level."""

    level: int

    def __str__(self) -> str:
        return f"attach at level {LEVELS.get(self.level, self.level)}"


@dataclass(frozen=True)
class SetAutonomy:
    """Change the autonomy level of what runs."""

    level: int

    def __str__(self) -> str:
        return f"autonomy {LEVELS.get(self.level, self.level)}"


@dataclass(frozen=True)
class TakeOutcome:
    """Leave the active state with an outcome.

    Attributes:
        path: path of the state.
        index: place of the outcome among those of the state, from 0.
        outcome: its name, for the record.
        is_forced: the engine had not asked for it.
        is_by_path: the engine is given the state's path, as states of one name ask at breakpoints.
    """

    path: str
    index: int
    outcome: str
    is_forced: bool
    is_by_path: bool = False

    def __str__(self) -> str:
        return f"{'force' if self.is_forced else 'confirm'} '{self.outcome}' of {self.path}"


@dataclass(frozen=True)
class Hold:
    """Lock a level of the active path: it is not left until it is released."""

    path: str

    def __str__(self) -> str:
        return f"lock {self.path}"


@dataclass(frozen=True)
class Release:
    """Unlock what is locked."""

    path: str = ""

    def __str__(self) -> str:
        return f"unlock {self.path}".rstrip()


@dataclass(frozen=True)
class Pause:
    """Execute the active state no further."""

    def __str__(self) -> str:
        return "pause"


@dataclass(frozen=True)
class Resume:
    """Execute the active state again."""

    def __str__(self) -> str:
        return "resume"


@dataclass(frozen=True)
class Repeat:
    """Leave the active state and enter it again."""

    def __str__(self) -> str:
        return "repeat"


@dataclass(frozen=True)
class Preempt:
    """Stop the behavior."""

    def __str__(self) -> str:
        return "stop"


@dataclass(frozen=True)
class ShowStructure:
    """Publish the states and their outcomes."""

    def __str__(self) -> str:
        return "show structure"


Order: TypeAlias = (
    Start
    | Switch
    | Attach
    | SetAutonomy
    | TakeOutcome
    | Hold
    | Release
    | Pause
    | Resume
    | Repeat
    | Preempt
    | ShowStructure
)


_SEVERITIES = {0: "info", 1: "warning", 2: "hint", 3: "error", 10: "debug"}


@dataclass(frozen=True)
class LogLine:
    """One line: when [s, wall time], its code in flexbe_msgs/BehaviorLog, and the text."""

    time_s: float
    code: int
    text: str

    @property
    def severity(self) -> str:
        """Return the word for its code."""
        return _SEVERITIES.get(self.code, "info")
