"""One run of a definition in ROS: its engine, what commands it, what it publishes.

A container or state that is not inside another has a session of its own. It is driven to its end
by `spin`, or executed once by each `execute`, for callers who run it by hand.
"""

from __future__ import annotations

import queue
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

import rospy

from flexbe_core.engine.containers import Container
from flexbe_core.engine.definitions import DEFAULT_PERIOD_S, Definition, Kind
from flexbe_core.engine.engine import Engine, ErrorPolicy
from flexbe_core.engine.leaf import Leaf, Node
from flexbe_core.engine.supervision import (
    Attach,
    Command,
    Preempt,
    SetAutonomy,
    ShowStructure,
    ShowValues,
)
from flexbe_core.logger import Logger
from flexbe_core.ros import clock, command_hub
from flexbe_core.ros.clock import Beat
from flexbe_core.ros.command_hub import HUB, STOPS
from flexbe_core.ros.driver import Driver, Inbox
from flexbe_core.ros.reporter import VISITS, Reporter, advertise

if TYPE_CHECKING:
    from flexbe_core.core.state import State
    from flexbe_core.engine.user_data import UserData


class Session:
    """The run of one definition.

    Attributes:
        engine: what runs it.
        is_listening: whether it takes commands of operators.
        priority_by_hand: path of what runs alone in what was last executed by hand; None if
            nothing does.
    """

    priority_by_hand: ClassVar[str | None] = None
    # Number and value of the last assignment to stock FlexBE's attribute of the process.
    _assigned: ClassVar[tuple[int, str | None]] = (0, None)

    def __init__(self, root: Definition, policy: ErrorPolicy = ErrorPolicy.AUTO) -> None:
        """Prepare to run `root`."""
        self._root = root
        self.engine = Engine(root, policy, root.path)
        self._beat: Beat | None = None
        self._driver: Driver | None = None
        self._inbox: Inbox = queue.SimpleQueue()
        self.is_listening = False
        self._is_connected = False
        self._assignment = 0
        self._reporter = Reporter(root)
        self._has_level = type(root).__kind__ is not Kind.STATE and hasattr(root, "autonomy_level")
        self._published_level: int | None = None

    @classmethod
    def assign_priority(cls, path: str | None) -> None:
        """Let what is at `path` run alone in what is executed by hand next; None for nothing."""
        cls.priority_by_hand = path
        cls._assigned = cls._assigned[0] + 1, path

    def post(self, command: Command) -> None:
        """Take a command; may be called from any thread."""
        self._inbox.put(command)

    def listen(self) -> None:
        """Take commands of operators from now on, and those that the hub kept for this run."""
        if not self._is_connected:
            self._is_connected = True
            connect()
        self._begin_listening()

    def listen_for_stops(self) -> None:
        """Accept preempts from now on; what is in force stays unchanged."""
        HUB.subscribe(STOPS)
        self._begin_listening()

    def _begin_listening(self) -> None:
        if not self.is_listening:
            self.is_listening = True
            HUB.listen(self)

    def ignore(self) -> None:
        """Take no more commands from operators, and clear what is in force."""
        self.is_listening = False
        HUB.ignore(self)
        self.forget()

    def forget(self) -> None:
        """Drop all commands and clear what is in force, for a new run."""
        while not self._inbox.empty():
            self._inbox.get()
        self.engine.forget_supervision()

    def spin(self, userdata: UserData | None = None) -> str:
        """Run to the end and return the outcome; see Driver.drive for what it raises."""
        self._refresh()
        # Before the first state is executed: a behavior that was paused meanwhile begins paused.
        self._take_commands()
        self._published_level = None
        self._publish_level()
        self.engine.begin(userdata)
        self._driver = Driver(
            self.engine, self._inbox, self._command, self._refresh, report=self._reporter.report
        )
        try:
            return self._driver.drive()
        finally:
            self._driver = None

    def execute(self, userdata: UserData | None = None, is_preempted: bool = False) -> str | None:
        """Execute once and return the outcome, if it ends with that.

        Under ErrorPolicy.AUTO a container holds the errors of its states at any level: its caller
        checks them.
        """
        self._refresh()
        self._take_commands()
        if is_preempted:
            self._command(Preempt())
        if self._assignment != self._assigned[0]:
            self._assignment, self.engine.priority = self._assigned
        self.engine.begin(userdata)
        policy = self.engine.policy
        if policy is ErrorPolicy.AUTO:
            self.engine.policy = ErrorPolicy.HOLD
        try:
            return self.engine.run(clock.now())
        finally:
            self.engine.policy = policy
            Session.priority_by_hand = self.engine.priority
            self._reporter.report(self.engine.take_events())

    def execution(self) -> tuple[str, float] | None:
        """Return the path of the state that is being executed, and since when (time.monotonic)."""
        driver, leaf = self._driver, self.engine.executing
        since = driver.busy_since if driver is not None else None
        return None if since is None or leaf is None else (leaf.path, since)

    def remaining_s(self) -> float:
        """Return how long [s] until something is due; 0 or less if it is."""
        if isinstance(self.engine.root, Leaf):
            return self._steady_beat().remaining_s()
        due = self.engine.next_due()
        return 0.0 if due == float("-inf") else due - clock.now()

    def sleep(self) -> None:
        """Sleep until something is due."""
        if isinstance(self.engine.root, Leaf):
            self._steady_beat().sleep()
        elif (remaining_s := self.remaining_s()) > 0:
            rospy.sleep(remaining_s if remaining_s < float("inf") else DEFAULT_PERIOD_S)

    def active_leaf(self) -> State | None:
        """Return the active state that mirrors show."""
        leaf = self.engine.root.leaf()
        return leaf.definition if leaf is not None else None

    def active_label(self, path: str) -> str | None:
        """Return the label of the active child of the container at this path, None without one."""
        leaf = self.engine.root.leaf()
        if leaf is None or not leaf.path.startswith(f"{path}/"):
            return None
        return leaf.path[len(path) + 1 :].split("/")[0]

    def container(self, path: str) -> Container | None:
        """Return the node of the container at this path; None if it has not been reached."""
        node = self.node(path)
        return node if isinstance(node, Container) else None

    def node(self, path: str) -> Node | None:
        """Return the runtime node at this path; None if it has not been reached."""
        node: Node | None = self.engine.root
        for label in path.removeprefix(self.engine.root_path).split("/")[1:]:
            node = node.children.get(label) if isinstance(node, Container) else None
        return node

    def is_locked(self, path: str) -> bool:
        """Return whether the operator has locked the state or container at this path."""
        return path in self.engine.supervision.locks

    def set_locked(self, path: str, is_locked: bool) -> None:
        """Lock or unlock the state or container at this path, as an operator would."""
        supervision = self.engine.supervision
        locks = supervision.locks | {path} if is_locked else supervision.locks - {path}
        self.engine.supervision = replace(supervision, locks=locks)

    def userdata(self) -> dict[str, dict[str, Any]]:
        """Return the runtime userdata of all containers reached so far, by their paths."""
        found: dict[str, dict[str, Any]] = {}
        reached: list[Node] = [self.engine.root]
        while reached:
            node = reached.pop(0)
            if isinstance(node, Container):
                found[node.path] = dict(node.userdata._data)
                reached += list(node.children.values())
        return found

    def publish_structure(self) -> None:
        """Publish the structure of the definition for mirrors."""
        self._reporter.structure()

    def _steady_beat(self) -> Beat:
        rate = self._root._rate
        if self._beat is None or self._beat.rate is not rate:
            self._beat = Beat(rate)
        return self._beat

    def _take_commands(self) -> None:
        """Put in force what was posted before this run, or since the last execution."""
        while not self._inbox.empty():
            arrival = self._inbox.get()
            if arrival is not None and not isinstance(arrival, Leaf):
                self._command(arrival)

    def _command(self, command: Command) -> None:
        if isinstance(command, ShowStructure):
            self.publish_structure()
        if isinstance(command, ShowValues):
            self._show_values()
        if isinstance(command, ShowStructure | Attach):
            self._root._enable_ros_control()
        if isinstance(command, SetAutonomy | Attach) and self._has_level:
            self._root.autonomy_level = command.level
        self.engine.handle(command)
        self._publish_level()

    def _refresh(self) -> None:
        """Read what users and operators may have set since the last time."""
        supervision = self.engine.supervision
        level = self._root.autonomy_level if self._has_level else supervision.autonomy_level
        points = command_hub.current() if self._root._is_controlled else supervision.breakpoints
        if (level, points) != (supervision.autonomy_level, supervision.breakpoints):
            self.engine.supervision = replace(supervision, autonomy_level=level, breakpoints=points)
            self._publish_level()
        self._observe()

    def _observe(self) -> None:
        """Have the visits of states published while a node subscribes to them."""
        is_behavior = getattr(self._root, "id", None) is not None
        self.engine.observe = VISITS.observer() if is_behavior else None

    def _show_values(self) -> None:
        """Publish the active state with its values."""
        self._observe()
        leaf = self.engine.root.leaf()
        if self.engine.observe is not None and leaf is not None and leaf.entered:
            self.engine.observe(leaf, False)

    def _publish_level(self) -> None:
        """Publish the autonomy level of a behavior if it has changed, for operators who join."""
        is_behavior = self._has_level and getattr(self._root, "id", None) is not None
        if is_behavior and self._root.autonomy_level != self._published_level:
            self._published_level = self._root.autonomy_level
            self._reporter.autonomy(self._published_level)


def connect() -> None:
    """Make all connections that runs need; calls the master, so better before the first run."""
    advertise()
    VISITS.advertise()
    Logger.initialize()
    HUB.subscribe()
    command_hub.subscribe()


def own_session(definition: State) -> Session:
    """Return the session in which this definition is the root."""
    session: Session = definition.__session__ or Session(definition)
    definition.__session__ = session
    return session


def run_session(definition: State) -> Session:
    """Return the session in which this definition runs.

    That of the outermost container around it; but if a part of a behavior is run by itself, as in
    tests, that of the part.
    """
    session: Session | None = definition.__session__
    while definition.parent is not None:
        if session is not None and session.engine.root.active:
            return session
        definition = definition.parent
        session = definition.__session__
    return own_session(definition)
