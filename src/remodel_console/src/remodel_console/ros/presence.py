"""Join ROS as soon as it is there, and see what of the cell is."""

from __future__ import annotations

import signal
import sys
import threading

import rosgraph
import rospy

from remodel_console.console import Console
from remodel_console.desk import Journal
from remodel_console.ros.command_server import CommandServer
from remodel_console.ros.engine_link import EngineLink
from remodel_console.ros.master import MasterWatch
from remodel_console.ros.runtime import Runtime
from remodel_console.ros.synthesis_link import ask_synthesis_server

_LOOK_EVERY_S = 0.5
_ABILITIES = "/remodel_abilities/"  # in whose namespace the ability servers of a cell are


def join_ros(console: Console, journal: Journal, end: threading.Event) -> None:
    """Wait for a master, connect, and watch until the event is set.

    Args:
        console: gets what is seen, and the way to the engine.
        journal: records the commands of `/flexbe/uicommand`.
        end: the console ends.
    """
    watch = MasterWatch(lambda is_there: console.live.set_presence(master=is_there))
    if not watch.wait(end):
        return
    try:
        rospy.init_node("console", disable_signals=True)
    except rospy.ROSException as error:  # the master went away meanwhile; a node joins but once
        _end_process(end, f"could not join ROS: {error}")
        return
    rospy.on_shutdown(lambda: _end_process(end, "ROS has shut this node down"))
    link = EngineLink(console.take, console.live.take_line)
    console.engine = link
    console.session.ask_server = ask_synthesis_server
    CommandServer(console.session, Runtime(), lambda: console.settings.now, journal)
    looking = threading.Thread(target=_look, args=(console, link, end), daemon=True)
    looking.start()
    watch.watch(end)
    rospy.signal_shutdown("the console ends")


def _look(console: Console, link: EngineLink, end: threading.Event) -> None:
    """Keep an eye on the mirror and on the cell."""
    while not end.wait(_LOOK_EVERY_S):
        console.live.set_presence(mirror=link.is_followed, cell=_has_cell())


def _has_cell() -> bool:
    """Tell whether somebody serves an ability."""
    try:
        published = rosgraph.Master(rospy.get_name()).getPublishedTopics("")
    except (OSError, rosgraph.MasterError):
        return False
    return any(topic.startswith(_ABILITIES) for topic, _ in published)


def _end_process(end: threading.Event, why: str) -> None:
    """End the pages too, as when `rosnode kill` shuts this node down."""
    if not end.is_set():
        sys.stderr.write(f"console: {why}\n")
        signal.raise_signal(signal.SIGINT)
