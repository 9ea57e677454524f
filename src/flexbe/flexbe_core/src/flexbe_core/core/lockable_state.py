"""A state that an operator can lock."""

from __future__ import annotations

from dataclasses import replace

from flexbe_core.core.manually_transitionable_state import ManuallyTransitionableState
from flexbe_core.ros.session import run_session


class LockableState(ManuallyTransitionableState):
    """A state that an operator can lock."""

    @property
    def _locked(self) -> bool:
        """Whether the state is kept from being left; stock FlexBE's attribute."""
        return self.is_locked()

    @_locked.setter
    def _locked(self, value: bool) -> None:
        run_session(self).set_locked(self.path, value)

    @property
    def _stored_outcome(self) -> str | None:
        """The outcome that the active state keeps until it is unlocked; stock's attribute."""
        session = run_session(self)
        return session.engine.supervision.stored if session.active_leaf() is self else None

    @_stored_outcome.setter
    def _stored_outcome(self, value: str | None) -> None:
        session = run_session(self)
        if session.active_leaf() is self:
            session.engine.supervision = replace(session.engine.supervision, stored=value)

    def is_locked(self) -> bool:
        """Return whether the state is kept from being left."""
        return run_session(self).is_locked(self.path)
