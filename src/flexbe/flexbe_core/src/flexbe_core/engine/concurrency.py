"""A concurrency container in a run: all children are active, and their outcomes together end it.

Each child keeps its own rate. After the children that are due have been executed once, in order of
definition, the conditions are checked in order. The first satisfied condition ends the container,
and the children that are still active are exited. A preempted child ends it at once.

Only the first child is supervised and shown to mirrors, since their protocol knows one active path.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from flexbe_core.engine.container import Container
from flexbe_core.engine.errors import StateMachineError
from flexbe_core.engine.node import NEVER, NOW, Node
from flexbe_core.engine.supervision.decision import Act, Moment, decide
from flexbe_core.engine.supervision.in_force import PREEMPTED

if TYPE_CHECKING:
    from flexbe_core.engine.definitions.definition import Condition, Definition
    from flexbe_core.engine.engine import Engine
    from flexbe_core.engine.leaf import Leaf
    from flexbe_core.engine.userdata.user_data import UserData


class Concurrency(Container):
    """The runtime node of a concurrency container.

    Attributes:
        results: label -> outcome, of the children that have ended.
    """

    __slots__ = ("_active", "results")

    def __init__(
        self, engine: Engine, definition: Definition, parent: Container | None, label: str
    ) -> None:
        """Stand for the concurrency container `definition`."""
        super().__init__(engine, definition, parent, label)
        self.results: dict[str, str] = {}
        self._active = False

    @property
    def active(self) -> bool:
        """Return whether its children are active."""
        return self._active

    def begin(self, userdata: UserData | None = None) -> None:
        """Begin with all children."""
        super().begin(userdata)
        if not self.definition._labels:
            raise StateMachineError("a concurrency container needs at least one state; it has none")
        self.results = {}
        for label in self.definition._labels:
            node = self.child(label)
            node.due = NOW
        self._active = True

    def tick(self, now: float) -> str | None:
        """Execute the children that are due, and check whether that ends the container."""
        if not self._active:
            self.begin()
        self.last_exception = None
        ended = len(self.results)
        for node in self._running():
            if self._is_shadowed(node):
                node.skip()
            elif node.next_due() <= now:
                self._tick_child(node, now)
                if self.results.get(node.label) == PREEMPTED:
                    self.exit()
                    return PREEMPTED
        return self._outcome() if len(self.results) > ended else None

    def exit(self) -> None:
        """End the visits of the children that still run."""
        running = self._running()
        self._active = False
        for node in running:
            node.exit()

    def skip(self) -> None:
        """Pause the children that are still active."""
        for node in self._running():
            node.skip()

    def wake(self) -> None:
        """Make the children that still run due now, or else the container itself."""
        self.due = NOW
        for node in self._running():
            node.wake()

    def next_due(self) -> float:
        """Return when the first of the children wants to be executed, or the container to begin."""
        if not self._active:
            return self.due
        waiting = (node.next_due() for node in self._running() if not self._is_shadowed(node))
        return min(waiting, default=NEVER)

    def leaf(self) -> Leaf | None:
        """Return the active state of the first child that still runs."""
        first = self.first_running()
        return None if first is None else first.leaf()

    def first_running(self) -> Node | None:
        """Return the first child that still runs; None if all have ended."""
        return next(iter(self._running()), None)

    def child(self, label: str) -> Node:
        """Return the node of a child; mirrors show only the first, and conditions use outcomes."""
        node = super().child(label)
        node.shown = self.shown and label == next(iter(self.definition._labels))
        outcomes = dict.fromkeys([*node.definition._outcomes, PREEMPTED], "")
        node.targets = {**outcomes, **node.targets}
        return node

    def _running(self) -> list[Node]:
        if not self._active:
            return []
        return [node for label, node in self.children.items() if label not in self.results]

    def _is_shadowed(self, node: Node) -> bool:
        if self.engine.priority is None:
            return False
        moment = Moment(node.path, supervised=False, shadowed=self.engine.shadows(node.path))
        return decide(self.engine.supervision, moment) is Act.SKIP

    def _tick_child(self, node: Node, now: float) -> None:
        try:
            outcome = node.tick(now)
        except Exception as error:  # noqa: BLE001 - a user's state may raise anything
            self.on_error(node, error, now)
        else:
            if outcome is not None:
                self.results[node.label] = outcome

    def _outcome(self) -> str | None:
        conditions: Sequence[Condition] = self.definition._conditions
        for outcome, pairs in conditions:
            if all(self.results.get(label) == result for label, result in pairs):
                self.exit()
                self.engine.sync_pending |= self.definition._is_controlled
                return outcome
        if not self._running():
            results = ", ".join(f"{label}: {result}" for label, result in self.results.items())
            raise StateMachineError(
                f"all states of {self.path or 'the root'} have ended ({results}), "
                "and no condition is satisfied"
            )
        return None
