"""A state machine, as users define it."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping
from typing import ClassVar

from flexbe_core.core.state import State
from flexbe_core.engine.definitions import Kind
from flexbe_core.engine.supervision import PREEMPTED
from flexbe_core.engine.user_data import StateMachineError, UserData
from flexbe_core.ros.session import own_session, run_session


class _Opened(threading.local):
    """The containers opened by `with` on this thread, the innermost last."""

    def __init__(self) -> None:
        self.containers: list[StateMachine] = []


_opened = _Opened()


def opened_container(label: str) -> StateMachine:
    """Return the container that is open, to add a state with this label.

    Raises:
        StateMachineError: if there is none.
    """
    if not _opened.containers:
        raise StateMachineError(
            f"cannot add {label!r}: no container is open; add states inside `with container:`"
        )
    return _opened.containers[-1]


class StateMachine(State):
    """States, and which follows which."""

    __kind__: ClassVar[Kind] = Kind.MACHINE
    __holds_errors__: ClassVar[bool] = False

    def __init__(self, *args: object, **kwargs: object) -> None:
        super().__init__(*args, **kwargs)
        self._labels: dict[str, State] = {}
        self._transitions: dict[str, dict[str, str]] = {}
        self._autonomy: dict[str, dict[str, int]] = {}
        self._remappings: dict[str, dict[str, str]] = {}
        self._own_userdata = UserData()

    def __enter__(self) -> None:
        """Open the container, so that `add` adds to it."""
        _opened.containers.append(self)

    def __exit__(self, *exception: object) -> None:
        _opened.containers.pop()

    def __contains__(self, label: str) -> bool:
        return label in self._labels

    def __getitem__(self, label: str) -> State:
        return self._labels[label]

    def __iter__(self) -> Iterator[str]:
        return iter(self._labels)

    @staticmethod
    def get_opened_container() -> StateMachine | None:
        """Return the container that is open, None if there is none."""
        return _opened.containers[-1] if _opened.containers else None

    @staticmethod
    def add(
        label: str,
        state: State,
        transitions: Mapping[str, str] | None = None,
        remapping: Mapping[str, str] | None = None,
    ) -> None:
        """Add a state to the open container.

        Args:
            label: its name there.
            state: the state or container.
            transitions: outcome -> label, or outcome of the open container.
            remapping: userdata key of the state -> key of the open container.

        Raises:
            StateMachineError: if no container is open or the label cannot be used.
            StateError: if the state is in a container already.
        """
        container = opened_container(label)
        container._add(label, state, dict(transitions or {}), {}, remapping=dict(remapping or {}))

    @property
    def _states(self) -> list[State]:
        return list(self._labels.values())

    @property
    def _current_state(self) -> State | None:
        label = run_session(self).active_label(self.path)
        return None if label is None else self._labels[label]

    @property
    def _userdata(self) -> UserData | None:
        """Runtime userdata; None if the container has not been reached."""
        node = run_session(self).container(self.path)
        return None if node is None else node.userdata

    @property
    def userdata(self) -> UserData:
        """The container's default userdata."""
        return self._own_userdata

    @property
    def initial_state(self) -> State:
        """The state that was added first."""
        return self._labels[self.initial_state_label]

    @property
    def initial_state_label(self) -> str:
        """The label of the state that was added first.

        Raises:
            StateMachineError: if there are no states.
        """
        for label in self._labels:
            return label
        raise StateMachineError(f"container {self.path or 'root'!r} has no states")

    @property
    def current_state(self) -> State:
        """The active child.

        Raises:
            StateMachineError: if the container is not active.
        """
        return self._labels[self.current_state_label]

    @property
    def current_state_label(self) -> str:
        """The label of the active child.

        Raises:
            StateMachineError: if the container is not active.
        """
        label = run_session(self).active_label(self.path)
        if label is None:
            raise StateMachineError(f"container {self.path or 'root'!r} is not active")
        return label

    @property
    def sleep_duration(self) -> float:
        """How long [s] until something is due; negative if it is late."""
        return own_session(self).remaining_s()

    def sleep(self) -> None:
        """Wait until something is due."""
        own_session(self).sleep()

    def execute(self, userdata: UserData | None = None) -> str | None:
        """Execute once, by hand: one state, or in a concurrency container all that are due."""
        return own_session(self).execute(userdata)

    def spin(self, userdata: UserData | None = None) -> str:
        """Run to the end and return the outcome."""
        return own_session(self).spin(userdata)

    def assert_consistent_transitions(self) -> None:
        """Check that each transition leads somewhere.

        Raises:
            StateMachineError: with all those that do not.
        """
        targets = {*self._labels, *self._outcomes, PREEMPTED}
        if all(
            targets.issuperset(transitions.values()) for transitions in self._transitions.values()
        ):
            return
        lost = [
            f"{label!r}: {outcome!r} -> {target!r}"
            for label, transitions in self._transitions.items()
            for outcome, target in transitions.items()
            if target not in targets
        ]
        known = ", ".join(map(repr, sorted(targets - {PREEMPTED})))
        raise StateMachineError(
            f"container {self.path or 'root'!r} has transitions that lead nowhere: "
            f"{'; '.join(lost)}; states and outcomes are {known}"
        )

    def _add(
        self,
        label: str,
        state: State,
        transitions: dict[str, str],
        autonomy: dict[str, int],
        remapping: dict[str, str],
    ) -> None:
        if label in self._labels:
            raise StateMachineError(f"container {self.name!r} has a state {label!r} already")
        if label in self._outcomes:
            raise StateMachineError(f"{label!r} is an outcome of container {self.name!r}")
        self._labels[label] = state
        self._transitions[label] = transitions
        self._autonomy[label] = autonomy
        self._remappings[label] = remapping
        state.set_parent(self)
        state.set_name(label)
