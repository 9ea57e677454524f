"""A state machine that an operator can lock."""

from __future__ import annotations

from flexbe_core.core.ros_state_machine import RosStateMachine
from flexbe_core.core.state import State
from flexbe_core.engine.definitions import Definition
from flexbe_core.engine.user_data import UserData
from flexbe_core.ros.session import run_session


class LockableStateMachine(RosStateMachine):
    """A state machine that an operator can lock."""

    @property
    def _locked(self) -> bool:
        """Whether the container is kept from being left; stock FlexBE's attribute."""
        return self.is_locked()

    @_locked.setter
    def _locked(self, value: bool) -> None:
        run_session(self).set_locked(self.path, value)

    def get_deep_state(self) -> State | None:
        """Return the active state, however deep; None if the container is not active."""
        leaf = run_session(self).active_leaf()
        return leaf if leaf is not None and leaf.path.startswith(f"{self.path}/") else None

    def lock(self, path: str) -> bool:
        """Lock the container at `path`, this one or one around it; return whether there is one."""
        return self._set_locked(path, True)

    def unlock(self, path: str) -> bool:
        """Unlock the container at `path`, see lock."""
        return self._set_locked(path, False)

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

    def transition_allowed(self, label: str, outcome: str | None) -> bool:
        """Return whether an outcome of a child leaves no locked container."""
        if outcome is None:
            return True
        target = self._transitions[label].get(outcome)
        if target is None or target in self._labels:
            return True
        if self.is_locked():
            return False
        container: Definition = self._parent
        return container is None or bool(container.transition_allowed(self._name, target))

    def replace_state(self, state: State) -> None:
        """Put a state of another version of the behavior in the place of the child of its name."""
        state._parent = self
        self._labels[state.name or ""] = state

    def replace_userdata(self, userdata: UserData) -> None:
        """Take the default userdata from another version of the container."""
        self._own_userdata = userdata

    def remove_state(self, state: State) -> None:
        """Give a child away, with its place in the container."""
        del self._labels[state.name or ""]

    def _set_locked(self, path: str, is_locked: bool) -> bool:
        if path != self.path:
            container: Definition = self._parent
            return container is not None and bool(container._set_locked(path, is_locked))
        run_session(self).set_locked(path, is_locked)
        return True
