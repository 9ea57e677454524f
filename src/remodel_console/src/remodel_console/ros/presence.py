"""What runs: the master, its nodes, and which of them answer."""

from __future__ import annotations

import http.client
import signal
import sys
import threading
import xmlrpc.client
from collections.abc import Callable, Iterator
from enum import Enum
from functools import lru_cache

import rosgraph
import rospy

from flexbe_core.ros.master import join_interruptibly
from remodel_console.console import Console
from remodel_console.core.run_view import Phase
from remodel_console.core.world import CellKind, Part
from remodel_console.live import Journal
from remodel_console.ros import topics
from remodel_console.ros.calls import ask_synthesis_server
from remodel_console.ros.command_server import CommandServer, InputServer, Runtime
from remodel_console.ros.engine_link import EngineLink
from remodel_console.ros.use_case_link import RecordLink, UseCaseLink
from remodel_console.ros.watched_links import (
    RESET,
    CameraLink,
    SceneLink,
    SceneRecorder,
    TopicValues,
    ValuesLink,
    reset_cell,
)

_POLL_S = 0.5
_CALLER = "/remodel_console"


class MasterWatch:
    """Checks whether the master is running; reports changes on a thread of its own."""

    def __init__(self, report: Callable[[bool], None]) -> None:
        """Prepare; `report` gets whether the master is running."""
        self._report = report
        self._run_id = ""

    def wait(self, until: threading.Event) -> bool:
        """Return True once a master is there, False once the event is set."""
        while not until.is_set():
            run_id = _run_id()
            if run_id:
                self._run_id = run_id
                return True
            until.wait(_POLL_S)
        return False

    def watch(self, until: threading.Event) -> None:
        """Report that it is running, and watch until the event is set."""
        self._report(True)
        was_there = True
        while not until.wait(_POLL_S):
            run_id = _run_id()
            if run_id and run_id != self._run_id:
                self._run_id = run_id
                _register_again()
            if (run_id is not None) != was_there:
                was_there = run_id is not None
                self._report(was_there)


def _run_id() -> str | None:
    """Return the id of a master's run; None without a master."""
    try:
        return str(rosgraph.Master(_CALLER).getParam("/run_id"))
    except rosgraph.MasterError:
        return ""  # it has just come; roscore gives it an id
    except (OSError, xmlrpc.client.Error):
        return None


def _register_again() -> None:
    """Register what this node publishes, subscribes to and serves with a new master."""
    master = rosgraph.Master(rospy.get_name())
    uri = rospy.get_node_uri()
    node = xmlrpc.client.ServerProxy(uri)
    manager = rospy.topics.get_topic_manager()
    for topic, kind in manager.get_publications():
        master.registerPublisher(topic, kind, uri)
    for topic, kind in manager.get_subscriptions():
        publishers = master.registerSubscriber(topic, kind, uri)
        node.publisherUpdate(rospy.get_name(), topic, publishers)


# [s] Wall time in which a node answers; one that is stopped never does.
_LIMIT_S = 1.0
_ERRORS = (OSError, http.client.HTTPException, xmlrpc.client.Error, rosgraph.MasterError)


class NodeAnswer(Enum):
    """What a node answers: none comes from a process that is stopped, and it is gone if killed."""

    YES = 1
    NONE = 2
    GONE = 3


class Nodes:
    """The nodes that are registered at the master, as of the last call of `look`."""

    def __init__(self) -> None:
        self._publishers: dict[str, list[str]] = {}
        self._services: frozenset[str] = frozenset()
        self._answers: dict[str, NodeAnswer] = {}

    def look(self) -> None:
        """Ask the master which there are; none if it is not running."""
        self._answers = {}
        try:
            publishers, _, services = rosgraph.Master(_CALLER).getSystemState()
        except _ERRORS:
            publishers, services = [], []
        self._publishers = dict(publishers)
        self._services = frozenset(name for name, _ in services)

    def has_service(self, name: str) -> bool:
        """Return whether a service is registered."""
        return name in self._services

    def topics(self, prefix: str, suffix: str) -> list[str]:
        """Return the published topics that begin and end so."""
        names = self._publishers
        return [name for name in names if name.startswith(prefix) and name.endswith(suffix)]

    def publishing(self, topic: str) -> list[str]:
        """Return the nodes that publish a topic and answer."""
        return [node for node, answer in self._asked(topic) if answer is NodeAnswer.YES]

    def is_silent(self, topic: str) -> bool:
        """Return whether nodes that publish a topic live, and none of them answers."""
        answers = {answer for _, answer in self._asked(topic)}
        return NodeAnswer.NONE in answers and NodeAnswer.YES not in answers

    def parameter(self, node: str, name: str) -> object:
        """Return a private parameter of a node; None without it."""
        try:
            return rosgraph.Master(_CALLER).getParam(f"{node}/{name}")
        except _ERRORS:
            return None

    def _asked(self, topic: str) -> Iterator[tuple[str, NodeAnswer]]:
        for node in self._publishers.get(topic, ()):
            if node not in self._answers:
                self._answers[node] = _ask(node)
            yield node, self._answers[node]


def _ask(node: str) -> NodeAnswer:
    try:
        uri = rosgraph.Master(_CALLER).lookupNode(node)
        _proxy(uri).getPid(_CALLER)
    except TimeoutError:
        _proxy.cache_clear()  # what is left of a call that took too long answers no other
        return NodeAnswer.NONE
    except _ERRORS:
        _proxy.cache_clear()
        return NodeAnswer.GONE
    return NodeAnswer.YES


@lru_cache(maxsize=64)
def _proxy(uri: str) -> xmlrpc.client.ServerProxy:
    return xmlrpc.client.ServerProxy(uri, transport=_Transport())


class _Transport(xmlrpc.client.Transport):
    """Waits no longer than the limit."""

    def make_connection(self, host: object) -> http.client.HTTPConnection:
        connection = super().make_connection(host)  # type: ignore[arg-type]
        connection.timeout = _LIMIT_S
        return connection


_LOOK_S = 0.5
_ABILITIES = "remodel_abilities"  # in whose namespace ability servers are
_STATUS = "/status"  # which an action server publishes, and its clients do not
_KIND = "cell_kind"  # private parameter of a node that serves abilities, see CellKind


def join_ros(console: Console, journal: Journal, end: threading.Event) -> None:
    """Wait for a master, connect, and watch until the event is set.

    Args:
        console: receives what is observed, and the connection to the engine.
        journal: records the commands of `/flexbe/uicommand`.
        end: the console ends.
    """
    watch = MasterWatch(console.live.set_master)
    if not watch.wait(end):
        return
    try:
        join_interruptibly("console", anonymous=False)
    except rospy.ROSException as error:  # the master went away meanwhile; a node joins but once
        _end_process(end, f"could not join ROS: {error}")
        return
    rospy.on_shutdown(lambda: _end_process(end, "ROS has shut this node down"))
    link = EngineLink(console.take, console.live.take_line, console.live.set_breakpoints)
    console.steering.engine = link
    supervisor = UseCaseLink(console.live.take_use_case)
    console.supervisor = supervisor
    console.recorder = RecordLink()
    console.inputs = InputServer(console.live.set_inputs)
    CameraLink(console.pictures, lambda: console.live.world.run.phase is Phase.RUNNING, end)
    SceneLink(console.scene, end)
    ValuesLink(console.values)
    console.plots.source = TopicValues(console.plots, lambda: console.settings.now.plots, end)
    SceneRecorder(
        console.scene,
        console.scenes,
        lambda: console.live.world.current_use_case,
        console.values.found,
        end,
    )
    console.reset_cell = reset_cell
    console.sessions.connect(ask_synthesis_server)
    CommandServer(console.session, Runtime(console.steering), lambda: console.settings.now, journal)
    looking = threading.Thread(target=_check, args=(console, link, supervisor, end), daemon=True)
    looking.start()
    watch.watch(end)
    rospy.signal_shutdown("the console ends")


def _check(
    console: Console, link: EngineLink, supervisor: UseCaseLink, end: threading.Event
) -> None:
    """Check which nodes run, and whether they answer."""
    nodes = Nodes()
    published = {
        Part.ENGINE: rospy.resolve_name(topics.HEARTBEAT),
        Part.SUPERVISOR: rospy.resolve_name(topics.USE_CASE),
    }
    abilities, reset = rospy.resolve_name(_ABILITIES) + "/", rospy.resolve_name(RESET)
    while not end.wait(_LOOK_S):
        nodes.look()
        statuses = nodes.topics(abilities, _STATUS)
        servers = [nodes.publishing(topic) for topic in statuses]
        silent = {part for part, topic in published.items() if nodes.is_silent(topic)}
        if any(nodes.is_silent(topic) for topic in statuses):
            silent.add(Part.CELL)
        console.live.set_presence(
            mirror=link.is_followed,
            servers=sum(bool(served) for served in servers),
            cell_kind=_kind(nodes, {node for served in servers for node in served}),
            can_reset=nodes.has_service(reset),
            supervisor=supervisor.is_there,
            silent=frozenset(silent),
        )


def _kind(nodes: Nodes, served_by: set[str]) -> CellKind | None:
    """Return what the nodes of ability servers move: real if any of them may."""
    said = {nodes.parameter(node, _KIND) for node in served_by}
    kinds = {next((kind for kind in CellKind if kind.value == one), CellKind.REAL) for one in said}
    return next((kind for kind in CellKind if kind in kinds), None)


def _end_process(end: threading.Event, why: str) -> None:
    """End the pages too, as when `rosnode kill` shuts this node down."""
    if not end.is_set():
        sys.stderr.write(f"console: {why}\n")
        signal.raise_signal(signal.SIGINT)
