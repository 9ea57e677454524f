"""A state machine in a run: one child is active, and its outcome chooses the next.

A cycle of states that return at once would occupy a whole core forever. Once the driver finds that
the engine has run too long without waiting (engine.slow), a child that is entered again is executed
at its rate, as in stock FlexBE. The machine runs freely again when one of its states returns None.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexbe_core.engine.container import Container
from flexbe_core.engine.definitions.rate import period_s
from flexbe_core.engine.errors import StateError
from flexbe_core.engine.node import NOW, Node

if TYPE_CHECKING:
    from flexbe_core.engine.definitions.definition import Definition
    from flexbe_core.engine.engine import Engine
    from flexbe_core.engine.leaf import Leaf
    from flexbe_core.engine.userdata.user_data import UserData


class Machine(Container):
    """The runtime node of a state machine.

    Attributes:
        current: the active child; None while the machine itself is not active.
    """

    __slots__ = ("_entries", "current")

    def __init__(
        self, engine: Engine, definition: Definition, parent: Container | None, label: str
    ) -> None:
        """Stand for the state machine `definition`."""
        super().__init__(engine, definition, parent, label)
        self.current: Node | None = None
        # While slowed down: label -> [s] ROS time of its last entry; else None.
        self._entries: dict[str, float] | None = None

    @property
    def active(self) -> bool:
        """Return whether a child is active."""
        return self.current is not None

    def begin(self, userdata: UserData | None = None) -> None:
        """Begin with the initial state."""
        super().begin(userdata)
        self.current = self.child(self.definition.initial_state_label)
        self.current.due = NOW

    def resume(self, label: str) -> Node:
        """Continue with this child in place of the initial state."""
        self.current = super().resume(label)
        self.current.due = NOW
        return self.current

    def tick(self, now: float) -> str | None:
        """Execute the active child once; a transition is taken in the same tick."""
        node = self.current
        if node is None:
            self.begin()
            node = self.child(self.definition.initial_state_label)
        try:
            outcome = node.tick(now)
            if outcome is None:
                if self.last_exception is not None:
                    self.last_exception = None
                if self._entries and not self.engine.moved:
                    self._entries = None
                return None
            target = node.targets.get(outcome)
            if target is None:
                raise StateError(_unconnected(node, outcome))
        except Exception as error:  # noqa: BLE001 - a user's state may raise anything
            self.on_error(node, error, now)
            return None
        following = self.children.get(target)
        if following is None:
            if target not in self.definition._labels:
                self.current = None
                return target
            following = self.child(target)
        self.current = following
        engine = self.engine
        engine.moved = True
        following.due = NOW
        if engine.slow or self._entries is not None:
            self._slow_down(following, now)
        return None

    def exit(self) -> None:
        """End the visit of the active child."""
        node, self.current = self.current, None
        if node is not None:
            node.exit()

    def skip(self) -> None:
        """Pause the active child."""
        if self.current is not None:
            self.current.skip()

    def wake(self) -> None:
        """Make the active child due now, or else the machine itself."""
        self.due = NOW
        if self.current is not None:
            self.current.wake()

    def next_due(self) -> float:
        """Return when the active child wants to be executed, or the machine to begin."""
        return self.due if self.current is None else self.current.next_due()

    def leaf(self) -> Leaf | None:
        """Return the active state."""
        return None if self.current is None else self.current.leaf()

    def _slow_down(self, following: Node, now: float) -> None:
        if self._entries is None:
            self._entries = {}
        last = self._entries.get(following.label)
        if last is not None:
            following.due = last + period_s(following.definition._rate)
            self.engine.moved = following.due <= now
        self._entries[following.label] = max(now, following.due)


def _unconnected(node: Node, outcome: str) -> str:
    connected = ", ".join(repr(name) for name in node.targets) or "none"
    return f"ended with {outcome!r}; outcomes with a transition: {connected}"
