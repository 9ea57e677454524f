"""A state machine that an operator can lock."""

from __future__ import annotations

from flexbe_core.core.ros_state_machine import RosStateMachine
from flexbe_core.core.state import State
from flexbe_core.ros.session import run_session


class LockableStateMachine(RosStateMachine):
    """A state machine that an operator can lock."""

    def get_deep_state(self) -> State | None:
        """Return the active state, however deep; None if the container is not active."""
        leaf = run_session(self).active_leaf()
        return leaf if leaf is not None and leaf.path.startswith(f"{self.path}/") else None

    def is_locked(self) -> bool:
        """Return whether the container is kept from being left."""
        return run_session(self).is_locked(self.path)

    def is_locked_inside(self) -> bool:
        """Return whether the container, or what is active in it, is kept from being left."""
        return self.get_locked_state() is not None

    def get_locked_state(self) -> State | None:
        """Return the active state, or else the innermost container around it, that is locked."""
        state = self.get_deep_state()
        while state is not None and not run_session(self).is_locked(state.path):
            state = None if state is self else state.parent
        return state
