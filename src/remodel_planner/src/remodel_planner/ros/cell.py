"""The cell, as the use case supervisor asks it: panel, feeder, pictures, and the score."""

from __future__ import annotations

import time

import rospy
from genpy import Message
from remodel_msgs.msg import Panel
from remodel_msgs.srv import FeedWire, GetGroundTruth, LoadPanel, TakePicture
from sensor_msgs.msg import Image

from remodel_planner.errors import CellError

# [s] wall time for the cell's node to come up with its physics.
START_LIMIT_S = 60.0


class Cell:
    """The cell's services, below the namespace `cell`."""

    def __init__(self) -> None:
        """Wait for the cell.

        Raises:
            CellError: if it is not there in time.
        """
        self._load_panel = _service("cell/load_panel", LoadPanel)
        self._feed_wire = _service("cell/feed_wire", FeedWire)
        self._ground_truth = _service("cell/ground_truth", GetGroundTruth)
        self._take_picture = _service("cell/take_picture", TakePicture)

    def load(self, panel: Panel) -> None:
        """Build the panel; CellError with every problem found if the cell can't."""
        _ask(self._load_panel, f"load panel {panel.name}", panel=panel)

    def feed(self, wire: str, channel: str) -> None:
        """Present a wire in a channel; CellError if the feeder can't."""
        _ask(self._feed_wire, f"feed wire {wire}", wire_id=wire, channel_id=channel)

    def placed(self, wire: str) -> bool:
        """Return whether both ends of a wire are fixed where they belong, by ground truth."""
        return any(truth.wire_id == wire and truth.placed for truth in self._ground_truth().wires)

    def picture(self, camera: str) -> Image:
        """Return a fresh picture; CellError if there is no such camera."""
        return _ask(self._take_picture, f"take a picture from {camera}", camera=camera).image


def _service(name: str, kind: type) -> rospy.ServiceProxy:
    # rospy.wait_for_service counts ROS time, which stands still until the cell runs.
    limit = time.monotonic() + START_LIMIT_S
    while time.monotonic() < limit and not rospy.is_shutdown():
        try:
            rospy.wait_for_service(name, timeout=0.5)
            return rospy.ServiceProxy(name, kind)
        except rospy.ROSException:
            continue
    raise CellError(
        f"service {rospy.resolve_name(name)} is not there after {START_LIMIT_S:.0f} s: start the "
        "cell (roslaunch remodel_sim cell.launch)"
    )


def _ask(service: rospy.ServiceProxy, what: str, **request: object) -> Message:
    try:
        response = service(**request)
    except rospy.ServiceException as error:
        raise CellError(f"cannot {what}: {error}") from error
    if not response.success:
        raise CellError(f"cannot {what}: {response.message}")
    return response
