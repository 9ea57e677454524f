"""What happens in a run, what an operator may ask of it, and what a state may do then."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum, IntEnum
from typing import Any

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


# Everything that an operator has in force over a running behavior, in one value


# Autonomy level of an unsupervised behavior: no transition asks, no state is controlled.
UNSUPERVISED = 255

# Stock FlexBE's level until one is set.
DEFAULT_AUTONOMY = 3

# Outcome of a stopped state or container; reserved, every container passes it on.
PREEMPTED = "preempted"


@dataclass(frozen=True, slots=True)
class Supervision:
    """What is in force. Only one state of a behavior is supervised at a time.

    Attributes:
        autonomy_level: transitions that need this level or more ask the operator.
        preempt: the behavior is to stop.
        paused: nothing is executed.
        locks: paths of states and containers that must not be left.
        breakpoints: paths of states in which every transition asks.
        forced: outcome that the operator wants the active state to take.
        repeat: the active state is to be left and entered again.
        stored: outcome that the active state has, kept until its lock ends.
        requested: outcome that the operator has been asked for.
    """

    autonomy_level: int = DEFAULT_AUTONOMY
    preempt: bool = False
    paused: bool = False
    locks: frozenset[str] = frozenset()
    breakpoints: frozenset[str] = frozenset()
    forced: str | None = None
    repeat: bool = False
    stored: str | None = None
    requested: str | None = None

    def after_visit(self) -> Supervision:
        """Return the supervision without what concerned only the visit that has ended."""
        if self.forced is self.stored is self.requested is None and not self.repeat:
            return self
        return replace(self, forced=None, repeat=False, stored=None, requested=None)


# What an operator may ask of a running behavior, as values


@dataclass(frozen=True, slots=True)
class Preempt:
    """Stop the behavior."""


@dataclass(frozen=True, slots=True)
class SetAutonomy:
    """Take transitions that need less than `level` without asking the operator."""

    level: int


@dataclass(frozen=True, slots=True)
class Attach:
    """Supervise the behavior from now on, at `level`."""

    level: int


@dataclass(frozen=True, slots=True)
class Sync:
    """Publish the active state for mirrors."""


@dataclass(frozen=True, slots=True)
class ShowStructure:
    """Publish the behavior's structure for mirrors; operators supervise it from now on."""


@dataclass(frozen=True, slots=True)
class ShowValues:
    """Publish the active state with its values, for a node that has just subscribed."""


@dataclass(frozen=True, slots=True)
class ForceOutcome:
    """Take the outcome with this index in the active state, if `target` is its name."""

    target: str
    index: int


@dataclass(frozen=True, slots=True)
class Lock:
    """Do not leave the state or container at `path`; empty is the active state."""

    path: str


@dataclass(frozen=True, slots=True)
class Unlock:
    """End a lock; empty is the active state."""

    path: str


@dataclass(frozen=True, slots=True)
class Pause:
    """Execute nothing until resumed."""


@dataclass(frozen=True, slots=True)
class Resume:
    """Continue after a pause."""


@dataclass(frozen=True, slots=True)
class Repeat:
    """Leave the active state and enter it again."""


@dataclass(frozen=True, slots=True)
class Release:
    """Detach the active state, for another version of the behavior, and end the run.

    Attributes:
        offer: called with the active state (None if there is none); returns whether the other
            version has attached it. If not, the run continues.
    """

    offer: Callable[[Any], bool]


StateCommand = ForceOutcome | Lock | Unlock | Pause | Resume | Repeat
Command = (
    Preempt | SetAutonomy | Attach | Sync | ShowStructure | ShowValues | Release | StateCommand
)


# What a state may do now: the precedence of all supervision, as two tables.
#
# A state is asked about twice per execution. BEFORE it is executed (its outcome is PENDING): is it
# executed at all? AFTER, with the outcome it returned: may it leave? The first rule of the table
# that applies decides. A rule may read the supervision, the moment, and nothing else.
#
# Leaves and containers carry out the act (leaf.py, containers.py), where a new act needs a
# branch. tools/draw_engine.py draws both tables into docs/engine.md.


class Pending(Enum):
    """The outcome of a state that has not been executed yet."""

    PENDING = "pending"


PENDING = Pending.PENDING


class Act(Enum):
    """What is done with a state.

    The first five come before execution, the others after it; STAY and WITHDRAW may be either.
    """

    PREEMPT = "leave at once with 'preempted'"
    SKIP = "do not execute it; call on_pause once"
    RELEASE = "take the outcome that was kept while it was locked"
    FORCE = "take the outcome that the operator wants"
    EXECUTE = "execute it"
    STAY = "keep it active"
    WITHDRAW = "keep it active, and withdraw its request to the operator"
    STORE = "keep it active, and keep its outcome until the lock ends"
    REPEAT = "exit it and enter it again"
    REQUEST = "keep it active, and ask the operator for the transition"
    LEAVE = "take the transition"


@dataclass(frozen=True, slots=True)
class Moment:
    """What a decision depends on, besides the supervision.

    Attributes:
        path: the state's path.
        supervised: whether an operator controls it.
        shadowed: whether a priority container that does not hold it is active.
        outcome: what it wants to leave with; None to stay, PENDING before execution.
        required_autonomy: level that this outcome needs; -1 if it needs none.
        leaves_locked: whether this outcome (before execution: the stored one) leaves a locked
            container.
    """

    path: str
    supervised: bool
    shadowed: bool = False
    outcome: str | Pending | None = PENDING
    required_autonomy: int = -1
    leaves_locked: bool = False


@dataclass(frozen=True)
class Rule:
    """One row of a table."""

    name: str
    act: Act
    applies: Callable[[Supervision, Moment], bool]


def _locked(supervision: Supervision, moment: Moment) -> bool:
    return moment.supervised and (moment.path in supervision.locks or moment.leaves_locked)


def _kept(supervision: Supervision, moment: Moment) -> bool:
    return moment.supervised and supervision.stored is not None


def _blocked(supervision: Supervision, moment: Moment) -> bool:
    """Return whether the outcome needs the operator's consent."""
    if not moment.supervised or moment.outcome in (None, supervision.forced):
        return False
    return (
        moment.required_autonomy >= supervision.autonomy_level
        or moment.path in supervision.breakpoints
    )


BEFORE: tuple[Rule, ...] = (
    Rule("preempted", Act.PREEMPT, lambda s, m: s.preempt),
    Rule("shadowed", Act.SKIP, lambda s, m: m.shadowed),
    Rule("paused", Act.SKIP, lambda s, m: m.supervised and s.paused),
    Rule(
        "locked, no longer asking",
        Act.WITHDRAW,
        lambda s, m: _kept(s, m) and _locked(s, m) and s.requested is not None,
    ),
    Rule("locked with an outcome", Act.STAY, lambda s, m: _kept(s, m) and _locked(s, m)),
    Rule("unlocked with an outcome", Act.RELEASE, _kept),
    Rule("forced", Act.FORCE, lambda s, m: m.supervised and s.forced is not None),
    Rule("free to run", Act.EXECUTE, lambda s, m: True),
)

AFTER: tuple[Rule, ...] = (
    Rule("preempted itself", Act.LEAVE, lambda s, m: m.outcome == PREEMPTED),
    Rule("locked", Act.STORE, lambda s, m: m.outcome is not None and _locked(s, m)),
    Rule(
        "repeated",
        Act.REPEAT,
        lambda s, m: m.supervised and s.repeat and (m.outcome is None or _blocked(s, m)),
    ),
    Rule(
        "changed its mind",
        Act.WITHDRAW,
        lambda s, m: m.supervised and m.outcome is None and s.requested is not None,
    ),
    Rule("not done", Act.STAY, lambda s, m: m.outcome is None),
    Rule("asked already", Act.STAY, lambda s, m: _blocked(s, m) and m.outcome == s.requested),
    Rule("needs consent", Act.REQUEST, _blocked),
    Rule("done", Act.LEAVE, lambda s, m: True),
)


def decide(supervision: Supervision, moment: Moment) -> Act:
    """Return what is done with the state: the act of the first rule that applies."""
    rules = BEFORE if moment.outcome is PENDING else AFTER
    return next(rule.act for rule in rules if rule.applies(supervision, moment))


# Apply commands: how each command to the active state changes the supervision


Applied = tuple[Supervision, tuple[Event, ...]]


@dataclass(frozen=True, slots=True)
class ActiveState:
    """The state to which commands apply.

    Attributes:
        name: its label; forced outcomes name it, or its path, by which the operator was asked.
        path: its path; locks name it.
        outcomes: what it declares, in order.
        ancestors: paths of the containers around it, the root's (empty) last.
    """

    name: str
    path: str
    outcomes: Sequence[str]
    ancestors: tuple[str, ...] = ()


def apply_command(supervision: Supervision, command: StateCommand, state: ActiveState) -> Applied:
    """Return the supervision after a command, and the events that answer the operator."""
    match command:
        case ForceOutcome():
            return _force(supervision, command, state)
        case Lock() | Unlock():
            return _lock_or_unlock(supervision, command, state)
        case Pause():
            return replace(supervision, paused=True), (Answered("pause"),)
        case Resume():
            return replace(supervision, paused=False), (Answered("resume"),)
        case Repeat():
            return replace(supervision, repeat=True), (Answered("repeat"),)


def _force(supervision: Supervision, command: ForceOutcome, state: ActiveState) -> Applied:
    if command.target not in (state.name, state.path):
        answer = Answered("transition", (command.target, state.name))
        text = f"asked for an outcome of {command.target!r}, but {state.name!r} is active"
        return supervision, (answer, Refused(text))
    answer = Answered("transition", (command.target, command.target))
    if not 0 <= command.index < len(state.outcomes):
        declared = ", ".join(f"{index}: {name}" for index, name in enumerate(state.outcomes))
        text = f"asked for outcome {command.index} of {state.name!r}; it has {declared}"
        return supervision, (answer, Refused(text))
    return replace(supervision, forced=state.outcomes[command.index]), (answer,)


def _lock_or_unlock(
    supervision: Supervision, command: Lock | Unlock, state: ActiveState
) -> Applied:
    word, path, locks = type(command).__name__.lower(), command.path, supervision.locks
    if not path and (word == "lock" or state.path in locks):
        path = state.path
    # An unlock of nothing is answered with empty paths, which operator interfaces take for success.
    if path and path not in (state.path, *state.ancestors):
        text = f"asked to {word} {path!r}, which is not active; active is {state.path!r}"
        return supervision, (Answered(word, (path, "")), Refused(text))
    locks = locks | {path} if word == "lock" else locks - {path}
    return replace(supervision, locks=locks), (Answered(word, (path, path)),)
