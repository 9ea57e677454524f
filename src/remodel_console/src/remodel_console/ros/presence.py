"""Join ROS as soon as it is running, and check which nodes of the cell are."""

from __future__ import annotations

import signal
import sys
import threading

import rospy

from flexbe_core.ros.master import join_interruptibly
from remodel_console.console import Console
from remodel_console.core.run.run_view import Phase
from remodel_console.core.world import CellKind, Part
from remodel_console.desk import Journal
from remodel_console.ros import topics
from remodel_console.ros.cell.camera_link import CameraLink
from remodel_console.ros.cell.reset import RESET, reset_cell
from remodel_console.ros.cell.scene_link import SceneLink
from remodel_console.ros.cell.scene_recorder import SceneRecorder
from remodel_console.ros.cell.values_link import ValuesLink
from remodel_console.ros.command_server import CommandServer
from remodel_console.ros.engine_link import EngineLink
from remodel_console.ros.input_server import InputServer
from remodel_console.ros.master import MasterWatch
from remodel_console.ros.nodes import Nodes
from remodel_console.ros.record_link import RecordLink
from remodel_console.ros.runtime import Runtime
from remodel_console.ros.synthesis_link import ask_synthesis_server
from remodel_console.ros.topic_values import TopicValues
from remodel_console.ros.use_case_link import UseCaseLink

_POLL_S = 0.5
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
    while not end.wait(_POLL_S):
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
