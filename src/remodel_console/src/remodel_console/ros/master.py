"""Whether the ROS master is running; the node registers itself with a new one.

A node registers once, so a restarted master does not know it. What this node publishes and
subscribes to is registered again then, by the master's and the node's own public interface.
"""

from __future__ import annotations

import threading
import xmlrpc.client
from collections.abc import Callable

import rosgraph
import rospy

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
