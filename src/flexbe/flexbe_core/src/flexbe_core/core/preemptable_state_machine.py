"""A state machine that an operator can stop."""

from __future__ import annotations

from collections.abc import Mapping

from flexbe_core.core.lockable_state_machine import LockableStateMachine
from flexbe_core.core.preemptable_state import PreemptableState
from flexbe_core.core.state import State
from flexbe_core.core.state_machine import StateMachine
from flexbe_core.engine.supervision import PREEMPTED
from flexbe_core.engine.user_data import UserData
from flexbe_core.ros.session import own_session


class PreemptableStateMachine(LockableStateMachine):
    """A state machine that an operator can stop.

    Every state in it has the transition preempted -> preempted.
    """

    _preempted_name = PREEMPTED

    @staticmethod
    def add(
        label: str,
        state: State,
        transitions: Mapping[str, str] | None = None,
        remapping: Mapping[str, str] | None = None,
    ) -> None:
        """Add a state to the open container, see StateMachine.add."""
        StateMachine.add(label, state, {**(transitions or {}), PREEMPTED: PREEMPTED}, remapping)

    def execute(self, userdata: UserData | None = None) -> str | None:
        """Execute once, by hand; operators can stop it."""
        own_session(self).listen()
        return own_session(self).execute(userdata, is_preempted=PreemptableState.preempt)

    def spin(self, userdata: UserData | None = None) -> str:
        """Run to the end and return the outcome; operators can stop it."""
        own_session(self).listen()
        try:
            return super().spin(userdata)
        finally:
            own_session(self).ignore()
