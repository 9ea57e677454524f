"""Whether the ROS master is there; a new one learns of this node again.

A node registers once, so a master that is started anew does not know it. What this node publishes
and subscribes to is registered again then, by the master's and the node's own public interface.
"""

from __future__ import annotations

import threading
import xmlrpc.client
from collections.abc import Callable

import rosgraph
import rospy

_LOOK_EVERY_S = 0.5
_CALLER = "/remodel_console"


class MasterWatch:
    """Looks whether the master is there; tells changes on a thread of its own."""

    def __init__(self, tell: Callable[[bool], None]) -> None:
        """Prepare; `tell` gets whether the master is there."""
        self._tell = tell
        self._run_id = ""

    def wait(self, until: threading.Event) -> bool:
        """Return True once a master is there, False once the event is set."""
        while not until.is_set():
            run_id = _run_id()
            if run_id:
                self._run_id = run_id
                return True
            until.wait(_LOOK_EVERY_S)
        return False

    def watch(self, until: threading.Event) -> None:
        """Tell that it is there, and watch until the event is set."""
        self._tell(True)
        was_there = True
        while not until.wait(_LOOK_EVERY_S):
            run_id = _run_id()
            if run_id and run_id != self._run_id:
                self._run_id = run_id
                _register_again()
            if (run_id is not None) != was_there:
                was_there = run_id is not None
                self._tell(was_there)


def _run_id() -> str | None:
    """Return what tells one master from the next; None if there is none."""
    try:
        return str(rosgraph.Master(_CALLER).getParam("/run_id"))
    except rosgraph.MasterError:
        return ""  # it has just come; roscore gives it an id
    except (OSError, xmlrpc.client.Error):
        return None


def _register_again() -> None:
    """Tell a new master what this node publishes, subscribes to and serves."""
    master = rosgraph.Master(rospy.get_name())
    uri = rospy.get_node_uri()
    node = xmlrpc.client.ServerProxy(uri)
    manager = rospy.topics.get_topic_manager()
    for topic, kind in manager.get_publications():
        master.registerPublisher(topic, kind, uri)
    for topic, kind in manager.get_subscriptions():
        publishers = master.registerSubscriber(topic, kind, uri)
        node.publisherUpdate(rospy.get_name(), topic, publishers)
