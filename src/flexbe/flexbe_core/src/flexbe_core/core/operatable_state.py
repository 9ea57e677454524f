"""A state whose transitions may need an operator's consent."""

from __future__ import annotations

from flexbe_core.core.preemptable_state import PreemptableState


class OperatableState(PreemptableState):
    """A state whose transitions may need an operator's consent."""
