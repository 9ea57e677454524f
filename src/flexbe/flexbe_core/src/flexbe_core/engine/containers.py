"""What all containers of a run have in common: children, userdata, and errors below them.

An error that a child raises is either held, so that the child stays active for the operator and is
tried again, or it ends the run (engine.holds_errors). Containers of the classes that hold no
errors pass it on to the container around them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from flexbe_core.engine.definitions import DEFAULT_PERIOD_S, period_s
from flexbe_core.engine.leaf import NEVER, NOW, Node
from flexbe_core.engine.supervision import PREEMPTED, Act, Moment, Raised, decide
from flexbe_core.engine.user_data import BehaviorFailure, StateError, StateMachineError, UserData

if TYPE_CHECKING:
    from flexbe_core.engine.definitions import Condition, Definition
    from flexbe_core.engine.engine import Engine
    from flexbe_core.engine.leaf import Leaf


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


# A state machine in a run: one child is active, and its outcome chooses the next.
#
# A cycle of states that return at once would occupy a whole core forever. Once the driver finds
# that the engine has run too long without waiting (engine.slow), a child that is entered again is
# executed at its rate, as in stock FlexBE. The machine runs freely again when one of its states
# returns None.


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


# A concurrency container in a run: all children are active, and their outcomes together end it.
#
# Each child keeps its own rate. After the children that are due have been executed once, in order
# of definition, the conditions are checked in order. The first satisfied condition ends the
# container, and the children that are still active are exited. A preempted child ends it at once.
#
# Only the first child is supervised and shown to mirrors, since their protocol knows one active
# path.


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


# A priority container in a run: while it is active, concurrent siblings wait


class Priority(Machine):
    """The runtime node of a priority container: a state machine that claims priority."""

    __slots__ = ("_before", "_claimed")

    def __init__(
        self, engine: Engine, definition: Definition, parent: Container | None, label: str
    ) -> None:
        """Stand for the priority container `definition`."""
        super().__init__(engine, definition, parent, label)
        self._claimed = False
        self._before: str | None = None

    def begin(self, userdata: UserData | None = None) -> None:
        """Begin, and claim priority unless a container inside holds it already."""
        super().begin(userdata)
        priority = self.engine.priority
        if priority is None or not is_inside(priority, self.path):
            self._claimed, self._before = True, priority
            self.engine.priority = self.path

    def tick(self, now: float) -> str | None:
        """Execute the active child, and give priority back with the outcome."""
        outcome = super().tick(now)
        if outcome is not None:
            self._give_back()
        return outcome

    def exit(self) -> None:
        """End the visit, and give priority back."""
        super().exit()
        self._give_back()

    def _give_back(self) -> None:
        if self._claimed:
            self._claimed = False
            self.engine.priority = self._before


def is_inside(path: str, container: str) -> bool:
    """Return whether `path` is `container` or below it."""
    return path == container or path.startswith(container + "/")
