"""A container whose states run at the same time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from flexbe_core.core.operatable_state_machine import OperatableStateMachine
from flexbe_core.core.state import State
from flexbe_core.engine.containers import Concurrency
from flexbe_core.engine.definitions import Condition, Kind
from flexbe_core.ros.session import run_session


class ConcurrencyContainer(OperatableStateMachine):
    """A container whose states run at the same time, each at its rate.

    The first condition whose outcomes have all come ends it. Only its first state is supervised.
    """

    __kind__: ClassVar[Kind] = Kind.CONCURRENCY

    def __init__(
        self, conditions: Sequence[Condition] = (), *args: object, **kwargs: object
    ) -> None:
        """Declare the conditions; for the rest see State.

        Args:
            conditions: outcome, and the (label, outcome) pairs that bring it about.
            args: ignored.
            kwargs: outcomes and userdata keys.
        """
        super().__init__(*args, **kwargs)
        self._conditions = conditions

    @property
    def _returned_outcomes(self) -> dict[str, str]:
        """Outcomes of the states that have ended in this visit, by their labels."""
        node = run_session(self).container(self.path)
        return node.results if isinstance(node, Concurrency) else {}

    def _supervised_children(self) -> list[State]:
        return self._states[:1]
