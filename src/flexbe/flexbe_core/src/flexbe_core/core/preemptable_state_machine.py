"""A state machine that an operator can stop."""

from __future__ import annotations

from collections.abc import Mapping

import rospy

from flexbe_core.core.lockable_state_machine import LockableStateMachine
from flexbe_core.core.preemptable_state import PreemptableState
from flexbe_core.core.state import State
from flexbe_core.core.state_machine import StateMachine
from flexbe_core.engine.supervision import PREEMPTED, Preempt
from flexbe_core.engine.user_data import UserData
from flexbe_core.ros.command_hub import HUB, STOPS
from flexbe_core.ros.session import own_session


class PreemptableStateMachine(LockableStateMachine):
    """A state machine that an operator can stop.

    Every state in it has the transition preempted -> preempted.
    """

    _preempted_name = PREEMPTED

    def __init__(self, *args: object, **kwargs: object) -> None:
        """Declare outcomes and userdata keys, see State; operators can stop it from now on."""
        super().__init__(*args, **kwargs)
        if rospy.core.is_initialized():
            HUB.subscribe(STOPS)
        self.__preempts = HUB.preempts

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
        self.__listen()
        return own_session(self).execute(userdata, is_preempted=PreemptableState.preempt)

    def spin(self, userdata: UserData | None = None) -> str:
        """Run to the end and return the outcome; operators can stop it."""
        self.__listen()
        try:
            return super().spin(userdata)
        finally:
            own_session(self).ignore()
            self.__preempts = HUB.preempts

    def __listen(self) -> None:
        """Take a preempt that arrives from now on, or has arrived since the last run."""
        session = own_session(self)
        if not session.is_listening:
            session.listen_for_stops()
            if HUB.preempts != self.__preempts:
                session.post(Preempt())
