"""What all containers of a run have in common: children, userdata, and errors below them.

An error that a child raises is either held, so that the child stays active for the operator and is
tried again, or it ends the run (engine.holds_errors). Containers of the classes that hold no
errors pass it on to the container around them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexbe_core.engine.definitions.rate import DEFAULT_PERIOD_S
from flexbe_core.engine.errors import BehaviorFailure
from flexbe_core.engine.events import Raised
from flexbe_core.engine.node import Node
from flexbe_core.engine.userdata.user_data import UserData

if TYPE_CHECKING:
    from flexbe_core.engine.definitions.definition import Definition
    from flexbe_core.engine.engine import Engine


class Container(Node):
    """The runtime node of a container.

    Attributes:
        children: label -> node, of those reached so far.
        userdata: runtime userdata of this visit.
        last_exception: what a child raised in the last tick, if it was held.
    """

    __slots__ = ("_blank", "_checked", "children", "last_exception", "userdata")

    def __init__(
        self, engine: Engine, definition: Definition, parent: Container | None, label: str
    ) -> None:
        """Stand for the container `definition`."""
        super().__init__(engine, definition, parent, label)
        self.children: dict[str, Node] = {}
        self.userdata = UserData()
        self.last_exception: Exception | None = None
        self._checked = False
        # The view of all children without keys: a view is empty between ticks, so they share one.
        self._blank = UserData(None, (), ())

    def begin(self, userdata: UserData | None = None) -> None:
        """Begin a visit.

        Args:
            userdata: runtime userdata; None for a view on the parent's, or fresh data at the root.

        Raises:
            StateMachineError: if a transition leads nowhere, or there are no states.
        """
        definition = self.definition
        if not self._checked:
            definition.assert_consistent_transitions()
            self._checked = True
        if userdata is None and self.parent is not None:
            userdata = UserData(
                self.parent.userdata,
                definition._input_keys,
                definition._output_keys,
                self.parent.definition._remappings.get(self.label),
            )
        self.userdata = UserData() if userdata is None else userdata
        self.userdata(add_from=definition._own_userdata)

    def view_for(self, label: str) -> UserData:
        """Return a view on the container's userdata for a child."""
        child = self.definition._labels[label]
        if not child._input_keys and not child._output_keys:
            return self._blank
        return UserData(
            self.userdata,
            child._input_keys,
            child._output_keys,
            self.definition._remappings.get(label),
        )

    def child(self, label: str) -> Node:
        """Return the node of a child, made on first use."""
        node = self.children.get(label)
        if node is None:
            definition = self.definition._labels[label]
            node_class = self.engine.node_classes[type(definition).__kind__]
            node = self.children[label] = node_class(self.engine, definition, self, label)
        return node

    def resume(self, label: str) -> Node:
        """Continue with the child that was active in another version, in a visit that has begun."""
        return self.child(label)

    def hold(self, now: float) -> None:
        """Try to begin again after one period."""
        self.due = now + DEFAULT_PERIOD_S

    def on_error(self, node: Node, error: Exception, now: float) -> None:
        """Hold an error of a child, or let it end the run.

        Raises:
            BehaviorFailure: if errors are not held.
            Exception: the error itself, if this class of container passes it on.
        """
        if isinstance(error, BehaviorFailure):
            raise error
        if not self.engine.holds_errors():
            raise BehaviorFailure(node.path, error) from error
        if not type(self.definition).__holds_errors__:
            raise error
        self.last_exception = error
        self.engine.events.append(Raised(node.path, error, held=True))
        node.hold(now)
