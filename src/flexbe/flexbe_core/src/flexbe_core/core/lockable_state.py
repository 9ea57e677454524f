"""A state that an operator can lock."""

from __future__ import annotations

from flexbe_core.core.manually_transitionable_state import ManuallyTransitionableState
from flexbe_core.ros.session import run_session


class LockableState(ManuallyTransitionableState):
    """A state that an operator can lock."""

    def is_locked(self) -> bool:
        """Return whether the state is kept from being left."""
        return run_session(self).is_locked(self.path)
