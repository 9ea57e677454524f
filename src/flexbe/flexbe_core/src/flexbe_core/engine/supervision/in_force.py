"""Everything that an operator has in force over a running behavior, in one value."""

from __future__ import annotations

from dataclasses import dataclass, replace

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
