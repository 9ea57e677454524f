"""The engine: runs one behavior, step by step, without a clock or a thread of its own.

A driver calls it with the time and with what arrives, and publishes the events that it returns.

    handle(command)   an operator sent a command
    wake(leaf)        what a state waits for may have arrived
    run(now)          execute what is due, until everything waits or the behavior ends
    next_due()        ROS time at which something is due again
    take_events()     what happened, to be published

A state that returns an outcome is followed by the next at once. A state that returns None is
executed again when its rate says so, when it is woken, or when a command comes.

Migration to a new version: the old run detaches its active state without exiting it, and ends. The
new run begins at that state: its containers begin with the runtime userdata of the old ones, and
the state continues, locked until an operator unlocks it. Other active states are exited, and begin
again.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from typing import TYPE_CHECKING, ClassVar

from flexbe_core.engine.containers import Concurrency, Container, Machine, Priority, is_inside
from flexbe_core.engine.definitions import Definition, Kind, first_path, first_state
from flexbe_core.engine.leaf import NOW, Leaf, Node, answer_at_breakpoint
from flexbe_core.engine.supervision import (
    PREEMPTED,
    UNSUPERVISED,
    Answered,
    Attach,
    Command,
    Entered,
    Event,
    ForceOutcome,
    Left,
    Lock,
    Pause,
    Preempt,
    Refused,
    Release,
    SetAutonomy,
    Shown,
    StateCommand,
    Supervision,
    Sync,
    Synced,
)
from flexbe_core.engine.user_data import UserData

if TYPE_CHECKING:
    from flexbe_core.engine.user_data import Value


@dataclass(frozen=True)
class MigratingState:
    """The active state of a run, to be attached to another version.

    Attributes:
        path: its path.
        state: the state itself, with its attributes.
        entered: whether its visit has begun.
        skipped: whether on_pause has been called and on_resume has not.
        userdata: runtime userdata of the containers around it, by their paths.
        paused: whether the run is paused; the new run is then paused too, if it is supervised.
        is_new: no other version has run: the run begins at this state, not locked.
    """

    path: str
    state: Definition
    entered: bool
    userdata: Mapping[str, Mapping[str, Value]]
    skipped: bool = False
    paused: bool = False
    is_new: bool = False


def migrating_state(engine: Engine) -> MigratingState | None:
    """Return the state to migrate; None if none is active, or the root itself is a state."""
    leaf = engine.root.leaf()
    if leaf is None or leaf.parent is None:
        return None
    userdata = {}
    container: Container | None = leaf.parent
    while container is not None:
        userdata[container.path] = dict(container.userdata._data)
        container = container.parent
    return MigratingState(
        path=leaf.path,
        state=leaf.definition,
        entered=leaf.entered,
        userdata=userdata,
        skipped=leaf.skipped,
        paused=engine.supervision.paused,
    )


def detach_state(engine: Engine) -> None:
    """End the run without its active state; to be called once another version has attached it."""
    leaf = engine.root.leaf()
    if leaf is not None:
        leaf.entered = False
    engine.released = True
    engine.supervision = replace(engine.supervision, preempt=True)


def attach_state(engine: Engine, migrating: MigratingState) -> None:
    """Begin a run at a state of another version, which is in its definition already."""
    node = engine.root
    for label in migrating.path.split("/")[1:]:
        if not isinstance(node, Container):
            raise TypeError(f"{node.path!r} is not a container; there is no {migrating.path!r}")
        node.begin(UserData() if node is engine.root else None)
        node.userdata._data.update(migrating.userdata.get(node.path, {}))
        node = node.resume(label)
    if not isinstance(node, Leaf):
        raise TypeError(f"{node.path!r} is not a state")
    node.resume_visit(migrating.entered, migrating.skipped)
    supervision, paused = engine.supervision, migrating.paused and node.definition._is_controlled
    locks = supervision.locks if migrating.is_new else supervision.locks | {node.path}
    engine.supervision = replace(supervision, locks=locks, paused=paused)
    engine.claim_while_paused(node.path)


# Of a longer series of entries between two calls of take_events only the last is returned: no
# operator can follow the others.
ENTRIES_TO_FOLLOW = 20


class ErrorPolicy(Enum):
    """What happens when a state raises, or returns an outcome that it does not have."""

    AUTO = "auto"
    """Hold the state if an operator supervises the behavior, otherwise end the run."""
    HOLD = "hold"
    """Keep the state active and execute it again, as stock FlexBE does."""
    FAIL = "fail"
    """End the run."""


class Engine:
    """One run of one behavior, or of any part of it.

    Attributes:
        supervision: what the operator has in force.
        priority: path of the priority container, or paused state, that runs alone; None if none.
        commands: commands to the active supervised state that are not applied yet.
        stopped: path -> state that is not supervised and waits at a breakpoint.
        node_classes: which class of nodes runs which kind of definition.
        policy: what happens when a state raises.
        events: what happened since the last take_events, but for the entries of states.
        entries: paths of the states entered since then; when it is full, older ones are forgotten.
        moved: whether a transition was taken since it was last set to False.
        executing: the state that is being executed, or was last.
        root_path: path of the root; empty but for a part of a behavior that is run by itself.
        slow: whether cycles are slowed down, see containers.py; for the driver to set.
        released: whether the active state was detached for another version.
        recording: whether to return also the events that only the run log needs (Ended, Forced).
        sync_pending: whether to sync mirrors as soon as a state is active.
        observe: called with each state that was entered or left, and whether it was left; None
            without an observer.
    """

    node_classes: ClassVar[Mapping[Kind, type[Node]]] = {
        Kind.STATE: Leaf,
        Kind.MACHINE: Machine,
        Kind.CONCURRENCY: Concurrency,
        Kind.PRIORITY: Priority,
    }

    def __init__(
        self, root: Definition, policy: ErrorPolicy = ErrorPolicy.AUTO, path: str = ""
    ) -> None:
        """Prepare to run the definition `root`, which is at `path` of the behavior."""
        self.root_path = path
        self.supervision = Supervision()
        self.priority: str | None = None
        self.commands: deque[StateCommand] = deque()
        self.stopped: dict[str, Leaf] = {}
        self.events: list[Event] = []
        self.entries: deque[str] = deque(maxlen=ENTRIES_TO_FOLLOW + 1)
        self.moved = False
        self.executing: Leaf | None = None
        self.slow = False
        self.sync_pending = False
        self.observe: Callable[[Leaf, bool], None] | None = None
        self.policy = policy
        self.released = False
        self.recording = False
        self._left: Left | None = None
        self._arrival = ""
        self._shown = ""
        self._entered = ""
        self._sync_asked = False
        self._pause_claim: tuple[str | None] | None = None
        self.root: Node = self.node_classes[type(root).__kind__](self, root, None, "")

    def handle(self, command: Command) -> None:
        """Put a command of an operator in force; the active state is executed at once."""
        if isinstance(command, Preempt):
            self.supervision = replace(self.supervision, preempt=True)
        elif isinstance(command, SetAutonomy):
            self.supervision = replace(self.supervision, autonomy_level=command.level)
            self.events.append(Answered("autonomy"))
        elif isinstance(command, Attach):
            # A request that was made before is repeated for the operator who attaches.
            self.supervision = replace(
                self.supervision, autonomy_level=command.level, requested=None
            )
            self.events.append(Answered("attach", (self.root.definition._name or "",)))
            self.sync_pending = True
            for waiting in self.stopped.values():
                waiting.requested, waiting.due = "", NOW
        elif isinstance(command, Sync):
            self._sync_asked = True
        elif isinstance(command, Release):
            active = None if self.supervision.preempt else migrating_state(self)
            if command.offer(active):
                detach_state(self)
        elif isinstance(command, StateCommand):
            self._take(command)
        leaf = self.root.leaf()
        if leaf is not None:
            leaf.due = NOW

    def _take(self, command: StateCommand) -> None:
        """Keep a command for the active state; as in stock FlexBE, only if it is supervised.

        Otherwise an operator who asked for a hold gets a warning and no feedback: operator
        interfaces take any feedback for success.
        """
        if (
            self.stopped
            and isinstance(command, ForceOutcome)
            and answer_at_breakpoint(self, command)
        ):
            return
        if self._is_supervised():
            self.commands.append(command)
        elif isinstance(command, Pause | Lock):
            self.events.append(
                Refused(
                    f"{type(command).__name__.lower()} has no effect: the behavior is not "
                    f"supervised (autonomy {self.supervision.autonomy_level}); attach to it first"
                )
            )

    def forget_supervision(self) -> None:
        """Clear what is in force, for a new run."""
        self.supervision = Supervision()
        self.priority = None
        self.commands.clear()
        self.sync_pending = self._sync_asked = False
        self._pause_claim = None
        self._shown = self._entered = ""

    def wake(self, leaf: Leaf) -> None:
        """Execute a state as soon as possible: what it waits for may have arrived."""
        leaf.due = NOW

    def begin(self, userdata: UserData | None = None) -> None:
        """Set the userdata to run with; a container uses it only when a visit begins."""
        if isinstance(self.root, Leaf) or not self.root.active:
            self.root.begin(userdata)

    def run(self, now: float, enough: Callable[[], bool] = lambda: True) -> str | None:
        """Execute until every active state waits, or `enough` returns True.

        Args:
            now: [s] ROS time.
            enough: called after each transition; by default one execution of the root is enough.

        Returns:
            the outcome of the root, or None while it continues.

        Raises:
            BehaviorFailure: if a state could not continue and errors end the run.
            Exception: what a root raised that holds no errors.
        """
        if self.supervision.preempt:  # the first row of BEFORE, for all states at once
            return self._preempt()
        tick = self._tick_supervised if self.root.definition._is_controlled else self.root.tick
        while True:
            self.moved = False
            outcome = tick(now)
            if outcome is not None:
                return outcome
            if not self.moved or enough():
                break
        if self.sync_pending or self._sync_asked:
            self._sync()
        return None

    def next_due(self) -> float:
        """Return the ROS time [s] at which there is something to execute."""
        return self.root.next_due()

    def stop(self) -> None:
        """End the visits of all active states, as after an error."""
        self.root.exit()
        if self._shown:
            self._show("")

    def take_events(self) -> list[Event]:
        """Return what happened since the last call: entries first, then the rest in order."""
        entries, events = list(self.entries), self.events
        self.entries.clear()
        self.events = []
        if len(entries) > ENTRIES_TO_FOLLOW:
            entries = entries[-1:]
        # A state whose beginning was not followed may be the one to show now: another child of a
        # concurrency container, after the first has ended.
        node = shown(self.root)
        if (
            isinstance(node, Leaf)
            and node.entered
            and node.path != (entries or [self._entered])[-1]
        ):
            entries.append(node.path)
        if entries:
            self._entered = entries[-1]
        return [Entered(path) for path in entries] + events

    def holds_errors(self) -> bool:
        """Return whether a state that raises stays active."""
        if self.policy is ErrorPolicy.AUTO:
            return self.supervision.autonomy_level != UNSUPERVISED
        return self.policy is ErrorPolicy.HOLD

    def shadows(self, path: str) -> bool:
        """Return whether this child of a concurrency container waits for a priority container."""
        priority = self.priority
        return priority is not None and not (is_inside(priority, path) or is_inside(path, priority))

    def claim_while_paused(self, path: str) -> None:
        """Let the paused state at `path` run alone, so that its siblings are paused too."""
        if self.supervision.paused and self._pause_claim is None:
            self._pause_claim = (self.priority,)
            self.priority = path
        elif not self.supervision.paused and self._pause_claim is not None:
            (self.priority,) = self._pause_claim
            self._pause_claim = None

    def _is_supervised(self) -> bool:
        leaf = self.root.leaf()
        state = leaf.definition if leaf else first_state(self.root.definition)
        return bool(state._is_controlled)

    def _preempt(self) -> str:
        if self._is_supervised() and not self.released:
            self.events.append(Answered("preempt"))
        self.supervision = replace(self.supervision, preempt=False, requested=None)
        for waiting in self.stopped.values():
            waiting.requested = None  # who preempts knows that nothing is asked any more
        self.stopped.clear()
        self.stop()
        return PREEMPTED

    def leave(self, leaf: Leaf, outcome: str) -> None:
        """Note that a supervised state was left with one of its outcomes, for mirrors."""
        event = Left(leaf.path, outcome, leaf.definition._outcomes.index(outcome))
        if self.root.definition._is_controlled:
            self._left, self._arrival = event, arrival(leaf, outcome)
        else:  # executed by hand, where a state may be supervised by itself; no mirror follows
            self.events.append(event)

    def _tick_supervised(self, now: float) -> str | None:
        """Execute the root once; mirrors follow each execution, before the next one."""
        try:
            return self.root.tick(now)
        finally:
            self._update_mirrors()

    def _update_mirrors(self) -> None:
        """Have mirrors show the state that is active after an execution."""
        path = shown_path(self.root) if self.root.active else ""
        is_followed = self._shown in ("", path)
        if self._left is not None:
            self.events.append(self._left)
            is_followed = self._arrival == path
            self._left, self._shown = None, ""  # a state that follows itself is shown again
        if path != self._shown or self._sync_asked:
            self._show(path)
        if self.sync_pending or self._sync_asked or not is_followed:
            self._sync()

    def _show(self, path: str) -> None:
        self._shown = path
        self.events.append(Shown(path))

    def _sync(self) -> None:
        path = shown_path(self.root) if self.root.active else ""
        if not path:
            return
        self.events.append(Synced(path))
        if self._sync_asked:
            self.events.append(Answered("sync"))
        self.sync_pending = self._sync_asked = False


# Which state mirrors show, and where they arrive when they follow an outcome.
#
# A mirror knows the structure of the behavior and one active state. It follows the outcomes of that
# state through the structure, as in stock FlexBE. If it arrives at a state other than the active
# one, the engine publishes a sync after the outcome: a concurrency container continues after its
# first state has ended, or is ended by another of its states.


def shown(node: Node) -> Node:
    """Return the node of the active state below `node` that mirrors show.

    Without one, return the innermost container that has been reached: it has not begun, or its
    states have all ended and it is held for the operator.
    """
    while True:
        inner = None
        if isinstance(node, Concurrency):
            inner = node.first_running()
        elif isinstance(node, Machine):
            inner = node.current
        if inner is None:
            return node
        node = inner


def shown_path(root: Node) -> str:
    """Return the path that mirrors show; before a container begins, that of its first state."""
    node = shown(root)
    return node.path if node.active else first_path(node.definition, node.path)


def arrival(node: Node, outcome: str) -> str:
    """Return where a mirror arrives that follows an outcome; empty at the end of the behavior."""
    while node.parent is not None:
        container = node.parent.definition
        target = container._transitions[node.label].get(outcome, outcome)
        if target in container._labels:
            return first_path(container._labels[target], f"{node.parent.path}/{target}")
        node, outcome = node.parent, target
    return ""
