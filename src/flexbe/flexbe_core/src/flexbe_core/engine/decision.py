"""What a state may do now: the precedence of all supervision, as two tables.

A state is asked about twice per execution. BEFORE it is executed (its outcome is PENDING): is it
executed at all? AFTER, with the outcome it returned: may it leave? The first rule of the table that
applies decides. A rule may read the record, the moment, and nothing else.

Leaves and containers carry out the act (leaf.py, oversight.py); a new act needs a branch there.
docs/engine.md draws both tables; tools/draw_engine.py writes them there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from flexbe_core.engine.supervision import PREEMPTED, Supervision


class Pending(Enum):
    """The outcome of a state that has not been executed yet."""

    PENDING = "pending"


PENDING = Pending.PENDING


class Act(Enum):
    """What is done with a state.

    The first five come before execution, the others after it; STAY and WITHDRAW may be either.
    """

    PREEMPT = "leave at once with 'preempted'"
    SKIP = "do not execute it; tell it that it is paused"
    RELEASE = "take the outcome that was kept while it was locked"
    FORCE = "take the outcome that the operator wants"
    EXECUTE = "execute it"
    STAY = "keep it active"
    WITHDRAW = "keep it active, and tell the operator that it no longer asks"
    STORE = "keep it active, and keep its outcome until the lock ends"
    REPEAT = "exit it and enter it again"
    REQUEST = "keep it active, and ask the operator for the transition"
    LEAVE = "take the transition"


@dataclass(frozen=True, slots=True)
class Moment:
    """What a decision must know about the state.

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


def _locked(record: Supervision, moment: Moment) -> bool:
    return moment.supervised and (moment.path in record.locks or moment.leaves_locked)


def _kept(record: Supervision, moment: Moment) -> bool:
    return moment.supervised and record.stored is not None


def _blocked(record: Supervision, moment: Moment) -> bool:
    """Return whether the outcome needs the operator's consent."""
    return (
        moment.supervised
        and moment.outcome is not None
        and moment.outcome != record.forced
        and (moment.required_autonomy >= record.autonomy_level or moment.path in record.breakpoints)
    )


BEFORE: tuple[Rule, ...] = (
    Rule("preempted", Act.PREEMPT, lambda r, m: r.preempt),
    Rule("shadowed", Act.SKIP, lambda r, m: m.shadowed),
    Rule("paused", Act.SKIP, lambda r, m: m.supervised and r.paused),
    Rule(
        "locked, no longer asking",
        Act.WITHDRAW,
        lambda r, m: _kept(r, m) and _locked(r, m) and r.requested is not None,
    ),
    Rule("locked with an outcome", Act.STAY, lambda r, m: _kept(r, m) and _locked(r, m)),
    Rule("unlocked with an outcome", Act.RELEASE, _kept),
    Rule("forced", Act.FORCE, lambda r, m: m.supervised and r.forced is not None),
    Rule("free to run", Act.EXECUTE, lambda r, m: True),
)

AFTER: tuple[Rule, ...] = (
    Rule("preempted itself", Act.LEAVE, lambda r, m: m.outcome == PREEMPTED),
    Rule("locked", Act.STORE, lambda r, m: m.outcome is not None and _locked(r, m)),
    Rule(
        "repeated",
        Act.REPEAT,
        lambda r, m: m.supervised and r.repeat and (m.outcome is None or _blocked(r, m)),
    ),
    Rule(
        "changed its mind",
        Act.WITHDRAW,
        lambda r, m: m.supervised and m.outcome is None and r.requested is not None,
    ),
    Rule("not done", Act.STAY, lambda r, m: m.outcome is None),
    Rule("asked already", Act.STAY, lambda r, m: _blocked(r, m) and m.outcome == r.requested),
    Rule("needs consent", Act.REQUEST, _blocked),
    Rule("done", Act.LEAVE, lambda r, m: True),
)


def decide(record: Supervision, moment: Moment) -> Act:
    """Return what is done with the state: the act of the first rule that applies."""
    rules = BEFORE if moment.outcome is PENDING else AFTER
    return next(rule.act for rule in rules if rule.applies(record, moment))
