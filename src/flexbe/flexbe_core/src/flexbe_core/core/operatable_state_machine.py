"""The state machine that behaviors are made of."""

from __future__ import annotations

from collections.abc import Mapping

from flexbe_core.core.preemptable_state_machine import PreemptableStateMachine
from flexbe_core.core.state import State
from flexbe_core.core.state_machine import opened_container
from flexbe_core.engine.definitions import Definition, Kind, definitions_below
from flexbe_core.engine.engine import MigratingState, attach_state
from flexbe_core.engine.supervision import DEFAULT_AUTONOMY, PREEMPTED, UNSUPERVISED
from flexbe_core.engine.user_data import UserData
from flexbe_core.ros.session import own_session, run_session
from flexbe_core.state_logger import StateLogger, log_all_events


class OperatableStateMachine(PreemptableStateMachine):
    """A state machine whose transitions may need an operator's consent.

    Attributes:
        autonomy_level: transitions that need this level or more ask the operator; 255 for an
            unsupervised behavior. Of the class: the default. Of a root: its own.
        id: checksum of the behavior's source, for a root.
    """

    __holds_errors__ = True

    autonomy_level: int = DEFAULT_AUTONOMY
    id: int | None = None

    @staticmethod
    def add(  # type: ignore[override]
        label: str,
        state: State,
        transitions: Mapping[str, str],
        autonomy: Mapping[str, int] | None = None,
        remapping: Mapping[str, str] | None = None,
    ) -> None:
        """Add a state to the open container.

        Args:
            label: its name there.
            state: the state or container.
            transitions: outcome -> label, or outcome of the open container.
            autonomy: outcome -> level that the transition needs; what is missing needs none, and
                without the whole map all need Off.
            remapping: userdata key of the state -> key of the open container.

        Raises:
            StateMachineError: if no container is open or the label cannot be used.
            StateError: if the state is in a container already.
        """
        container = opened_container(label)
        container._add(
            label,
            state,
            {**transitions, PREEMPTED: PREEMPTED},
            dict.fromkeys(transitions, 0) if autonomy is None else dict(autonomy),
            remapping=dict(remapping or {}),
        )

    @property
    def _last_exception(self) -> Exception | None:
        """What a child raised in the last execution."""
        node = run_session(self).container(self.path)
        return None if node is None else node.last_exception

    @property
    def _inner_sync_request(self) -> bool:
        """Whether a sync of the mirrors is pending; setting it requests one."""
        return run_session(self).engine.sync_pending

    @_inner_sync_request.setter
    def _inner_sync_request(self, value: bool) -> None:
        run_session(self).engine.sync_pending = value

    def is_transition_allowed(self, label: str, outcome: str | None) -> bool:
        """Return whether an outcome of a child may be taken without asking."""
        if outcome is None:
            return True
        root: Definition = self
        while root.parent is not None:
            root = root.parent
        return self._autonomy[label].get(outcome, -1) < root.autonomy_level

    def get_required_autonomy(self, outcome: str) -> int:
        """Return the level that an outcome of the active child needs."""
        return self._autonomy[self.current_state_label][outcome]

    def confirm(self, name: str, id: int, migrating: MigratingState | None = None) -> None:
        """Begin as the root of a behavior: accept commands of operators, and start all states.

        Args:
            name: the behavior's name.
            id: checksum of the behavior's source.
            migrating: state at which to begin; if it is of another version, its on_start has been
                called.
        """
        self._name = name
        self.id = id
        own_session(self).forget()
        own_session(self).listen()
        self._begin_log()
        if self.autonomy_level != UNSUPERVISED:
            self._enable_ros_control()
        try:
            for state in self._all_states():
                if migrating is None or migrating.is_new or state is not migrating.state:
                    state.on_start()
        except (Exception, SystemExit):
            self.destroy()
            raise
        if migrating is not None:
            attach_state(own_session(self).engine, migrating)

    def destroy(self) -> None:
        """End as the root of a behavior: stop all states, and accept no more commands.

        Raises:
            Exception, SystemExit: the first that an on_stop raised, after all have been called.
        """
        own_session(self).ignore()
        errors: list[Exception | SystemExit] = []
        for state in self._all_states():
            try:
                state.on_stop()
            except (Exception, SystemExit) as error:  # noqa: BLE001 - the others must stop too
                errors.append(error)
        self._disable_ros_control()
        StateLogger.shutdown()
        if errors:
            raise errors[0]

    def on_exit(self, userdata: UserData | None = None) -> None:
        """End the visits of everything that is active in the container."""
        node = run_session(self).container(self.path)
        if node is not None:
            node.exit()

    def _begin_log(self) -> None:
        """Log what all states do, if the node's parameters enable it."""
        StateLogger.initialize(self._name, self.autonomy_level)
        own_session(self).engine.recording = StateLogger.enabled
        if StateLogger.enabled:
            for state in self._all_states():
                log_all_events(state)

    def _all_states(self) -> list[State]:
        return [state for state in definitions_below(self) if type(state).__kind__ is Kind.STATE]
