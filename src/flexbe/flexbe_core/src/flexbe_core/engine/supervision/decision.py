"""What a state may do now: the precedence of all supervision, as two tables.

A state is asked about twice per execution. BEFORE it is executed (its outcome is PENDING): is it
executed at all? AFTER, with the outcome it returned: may it leave? The first rule of the table that
applies decides. A rule may read the supervision, the moment, and nothing else.

Leaves and containers carry out the act (leaf.py, supervised_leaf.py), where a new act needs a
branch. tools/draw_engine.py draws both tables into docs/engine.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from flexbe_core.engine.supervision.in_force import PREEMPTED, Supervision


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
