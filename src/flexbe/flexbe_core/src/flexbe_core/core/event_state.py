"""The base of all states that users write."""

from __future__ import annotations

from flexbe_core.core.operatable_state import OperatableState
from flexbe_core.engine.leaf import Leaf
from flexbe_core.ros.session import run_session


class EventState(OperatableState):
    """The base of all states that users write."""

    @property
    def _entering(self) -> bool:
        """Whether the next execution calls on_enter; stock FlexBE's attribute."""
        node = run_session(self).node(self.path)
        return not (isinstance(node, Leaf) and node.entered)

    @_entering.setter
    def _entering(self, value: bool) -> None:
        node = run_session(self).node(self.path)
        if isinstance(node, Leaf):
            node.entered = not value
