"""Join ROS as soon as it is running, and check which nodes of the cell are."""

from __future__ import annotations

import signal
import sys
import threading

import rosgraph
import rospy

from flexbe_core.ros.master import join_interruptibly
from remodel_console.console import Console
from remodel_console.core.run.run_view import Phase
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
from remodel_console.ros.record_link import RecordLink
from remodel_console.ros.runtime import Runtime
from remodel_console.ros.synthesis_link import ask_synthesis_server
from remodel_console.ros.use_case_link import UseCaseLink

_POLL_S = 0.5
_ABILITIES = "remodel_abilities/"  # in whose namespace ability servers are
_CAMERA = f"{topics.CELL}/overhead/image_raw"  # which a cell publishes, and fake abilities do not


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
    SceneRecorder(
        console.scene,
        console.scenes,
        lambda: console.live.world.use_case,
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
    """Check whether the mirror, the supervisor and the cell are running."""
    abilities, camera = rospy.resolve_name(_ABILITIES), rospy.resolve_name(_CAMERA)
    reset = rospy.resolve_name(RESET)
    while not end.wait(_POLL_S):
        published = _published()
        has_abilities = any(topic.startswith(abilities) for topic in published)
        console.live.set_presence(
            mirror=link.is_followed,
            abilities=has_abilities,
            cell=camera in published,
            simulated=_is_served(reset) if has_abilities or camera in published else True,
            supervisor=supervisor.is_there,
        )


def _is_served(service: str) -> bool:
    try:
        rosgraph.Master(rospy.get_name()).lookupService(service)
    except (OSError, rosgraph.MasterError):
        return False
    return True


def _published() -> frozenset[str]:
    """Return the topics with a publisher; none if the master is not running."""
    try:
        found = rosgraph.Master(rospy.get_name()).getPublishedTopics("")
    except (OSError, rosgraph.MasterError):
        return frozenset()
    return frozenset(topic for topic, _ in found)


def _end_process(end: threading.Event, why: str) -> None:
    """End the pages too, as when `rosnode kill` shuts this node down."""
    if not end.is_set():
        sys.stderr.write(f"console: {why}\n")
        signal.raise_signal(signal.SIGINT)
