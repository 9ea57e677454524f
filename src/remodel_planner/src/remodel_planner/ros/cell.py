"""The cell, as the use case supervisor asks it: panel, feeder, pictures, and the score."""

from __future__ import annotations

import socket
import time

import rospy
from genpy import Message
from remodel_msgs.msg import Panel
from remodel_msgs.srv import FeedWire, GetGroundTruth, LoadPanel, TakePicture
from sensor_msgs.msg import Image

from remodel_planner.errors import CellError, LostError

# [s] wall time between two looks whether a service is there.
_LOOK_S = 0.1

_SERVICES = {
    "load_panel": LoadPanel,
    "feed_wire": FeedWire,
    "ground_truth": GetGroundTruth,
    "take_picture": TakePicture,
}


class Cell:
    """The cell's services, below the namespace `cell`."""

    def wait(self, limit_s: float) -> None:
        """Wait for all services, up to a limit of wall time [s].

        Raises:
            LostError: if one is not there in time.
        """
        # rospy.wait_for_service counts ROS time, which stands still until the cell runs.
        end = time.monotonic() + limit_s
        for name in _SERVICES:
            while not _address(name):
                if time.monotonic() > end or rospy.is_shutdown():
                    raise LostError(
                        f"service {rospy.resolve_name(f'cell/{name}')} is not there after "
                        f"{limit_s:.0f} s: start the cell (roslaunch remodel_sim cell.launch)"
                    )
                time.sleep(_LOOK_S)

    def address(self) -> str:
        """Return where the cell answers; a cell that was started anew answers somewhere else.

        Raises:
            LostError: if it does not answer.
        """
        address = _address("load_panel")
        if not address:
            raise LostError("the cell does not answer")
        return address

    def load(self, panel: Panel, *, keep: bool) -> None:
        """Build the panel; CellError with every problem found if the cell can't.

        Args:
            panel: to build.
            keep: leave the cell as it is if it has this very panel already.
        """
        _ask("load_panel", f"load panel {panel.name}", panel=panel, keep=keep)

    def feed(self, wire: str, channel: str) -> None:
        """Present a wire in a channel; CellError if the feeder can't."""
        _ask("feed_wire", f"feed wire {wire}", wire_id=wire, channel_id=channel)

    def placed(self, wire: str) -> bool:
        """Return whether both ends of a wire are fixed where they belong, by ground truth."""
        truths = _called("ground_truth", "ask for the score").wires
        return any(truth.wire_id == wire and truth.placed for truth in truths)

    def picture(self, camera: str) -> Image:
        """Return a fresh picture; CellError if there is no such camera."""
        return _ask("take_picture", f"take a picture from {camera}", camera=camera).image


def _address(name: str) -> str:
    """Return where a service answers; empty if nobody does: the master remembers dead nodes."""
    try:
        uri = rospy.get_master().lookupService(rospy.resolve_name(f"cell/{name}"))[2]
        _, _, address = uri.partition("://")
        host, _, port = address.rpartition(":")
        with socket.create_connection((host, int(port)), timeout=1.0):
            return address
    except (OSError, ValueError):
        return ""


def _ask(name: str, what: str, **request: object) -> Message:
    response = _called(name, what, **request)
    if not response.success:
        raise CellError(f"cannot {what}: {response.message}")
    return response


def _called(name: str, what: str, **request: object) -> Message:
    try:
        return rospy.ServiceProxy(f"cell/{name}", _SERVICES[name])(**request)
    except (rospy.ServiceException, rospy.ROSException, OSError) as error:
        raise LostError(f"cannot {what}: {error}") from error
