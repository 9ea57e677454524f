"""Connect to action servers within a bound of wall time."""

from __future__ import annotations

import time

import actionlib
import rospy

from remodel_planner.errors import CellError

# [s] wall time for a server's node to come up.
START_LIMIT_S = 60.0


def connect(name: str, action: type, node: str) -> actionlib.SimpleActionClient:
    """Return a client that is connected.

    Args:
        name: of the action.
        action: its `...Action` class.
        node: that serves it, for the error text.

    Raises:
        CellError: if the server is not there in time.
    """
    client = actionlib.SimpleActionClient(name, action)
    limit = time.monotonic() + START_LIMIT_S
    while time.monotonic() < limit and not rospy.is_shutdown():
        if client.wait_for_server(rospy.Duration(0.5)):
            return client
    raise CellError(
        f"action {rospy.resolve_name(name)} is not there after {START_LIMIT_S:.0f} s: start {node}"
    )
