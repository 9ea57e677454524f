"""The base of all states that users write."""

from __future__ import annotations

from flexbe_core.core.operatable_state import OperatableState


class EventState(OperatableState):
    """The base of all states that users write."""
