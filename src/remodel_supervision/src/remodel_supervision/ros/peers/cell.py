"""The cell, as the use case supervisor asks it: panel, feeder, pictures, and the score."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from typing import TypeVar

import rospy
from genpy import Message
from remodel_msgs.msg import ErrorCode, Panel
from remodel_msgs.srv import FeedWire, GetGroundTruth, LoadPanel, TakePicture
from sensor_msgs.msg import Image

from remodel_production.errors import LostError
from remodel_supervision.errors import RefusedError
from remodel_tasks.core.task_charts.planned_tasks import Demands

# [s] wall time between two checks whether a service is there.
_CHECK_S = 0.1

_SERVICES = {
    "load_panel": LoadPanel,
    "feed_wire": FeedWire,
    "ground_truth": GetGroundTruth,
    "take_picture": TakePicture,
}
# Those that a cell need not have: only a simulated one knows the truth.
_OPTIONAL = frozenset({"ground_truth"})


T = TypeVar("T")


def _directly(call: Callable[[], T]) -> T:
    return call()


class Cell:
    """The cell's services, below the namespace `cell`."""

    def __init__(self, background: Callable[[Callable[[], T]], T] = _directly) -> None:
        """Call the services through `background`, which may do other things meanwhile."""
        self._background = background
        self._has_truth = False

    def wait(self, limit_s: float) -> None:
        """Wait for all services, up to a limit of wall time [s].

        Raises:
            LostError: if one is not there in time.
        """
        self._background(lambda: _wait(limit_s))

    def address(self) -> str:
        """Return where the cell answers; a cell that was restarted answers somewhere else.

        Raises:
            LostError: if it does not answer.
        """
        address = _address("load_panel")
        if not address:
            raise LostError("the cell does not answer")
        return address

    def load(self, panel: Panel, serial: str, owner: int, *, demands: Demands, keep: bool) -> None:
        """Build the panel of a product.

        Args:
            panel: to build.
            serial: serial number of the product.
            owner: token of the supervisor that asks.
            demands: of the order's goals.
            keep: leave the cell as it is if it has this very panel already.

        Raises:
            RefusedError: with every problem found if the cell cannot.
        """
        panel.serial = serial
        what = f"load panel {panel.name}"
        self._ask(
            "load_panel",
            what,
            panel=panel,
            keep=keep,
            owner=owner,
            robots=demands.robots,
            abilities=[ability for ability, _ in demands.forces_n],
            force_limits=[force_n for _, force_n in demands.forces_n],
        )

    def feed(self, wire: str, owner: int) -> None:
        """Present a piece of a wire.

        Raises:
            RefusedError: if the feeder cannot.
        """
        self._ask("feed_wire", f"feed wire {wire}", wire_id=wire, owner=owner)

    def take_over(self, owner: int) -> bool:
        """Refuse earlier owners from now on; return whether nothing moves that they asked for.

        A cell answers when its feeder rests, or that it is busy, or with an error of its own, such
        as no answer in time; of any other refusal nothing moves.

        Raises:
            LostError: if it does not answer.
        """
        answer = self._call("feed_wire", "take over the cell", wire_id="", owner=owner)
        return answer.error_code not in (ErrorCode.BUSY, ErrorCode.INTERNAL)

    def placed(self, wire: str) -> bool | None:
        """Return whether a wire is placed, by ground truth; None if there is none of it.

        A cell without the service has none; one that had it is lost while it does not answer.
        """
        what = "ask for the ground truth"
        if not self._has_truth:
            self._has_truth = self._background(lambda: _is_registered("ground_truth", what))
        if not self._has_truth:
            return None
        truths = self._call("ground_truth", what).wires
        return next((truth.placed for truth in truths if truth.wire_id == wire), None)

    def picture(self, camera: str) -> Image:
        """Return a fresh picture; RefusedError if there is no such camera."""
        return self._ask("take_picture", f"take a picture from {camera}", camera=camera).image

    def _ask(self, name: str, what: str, **request: object) -> Message:
        response = self._call(name, what, **request)
        if not response.success:
            code = getattr(response, "error_code", 0)
            raise RefusedError(code, f"cannot {what}: {response.message}")
        return response

    def _call(self, name: str, what: str, **request: object) -> Message:
        return self._background(lambda: _called(name, what, request))


def _wait(limit_s: float) -> None:
    # rospy.wait_for_service counts ROS time, which does not pass until the cell runs.
    end = time.monotonic() + limit_s
    for name in (name for name in _SERVICES if name not in _OPTIONAL):
        while not _address(name):
            if time.monotonic() > end or rospy.is_shutdown():
                raise LostError(
                    f"service {rospy.resolve_name(f'cell/{name}')} is not there after "
                    f"{limit_s:.0f} s: start the cell (roslaunch remodel_sim cell.launch), "
                    "or your own, which offers it"
                )
            time.sleep(_CHECK_S)


def _registered(name: str) -> str:
    """Return the address of a service as the master remembers it; empty if it knows none."""
    code, _, uri = rospy.get_master().lookupService(rospy.resolve_name(f"cell/{name}"))
    return uri.partition("://")[2] if code == 1 else ""


def _is_registered(name: str, what: str) -> bool:
    try:
        return bool(_registered(name))
    except OSError as error:
        raise LostError(f"cannot {what}: the ROS master does not answer: {error}") from error


def _address(name: str) -> str:
    """Return where a service answers; empty if it does not: the master remembers dead nodes."""
    try:
        address = _registered(name)
        host, _, port = address.rpartition(":")
        with socket.create_connection((host, int(port)), timeout=1.0):
            return address
    except (OSError, ValueError):
        return ""


def _called(name: str, what: str, request: dict[str, object]) -> Message:
    try:
        return rospy.ServiceProxy(f"cell/{name}", _SERVICES[name])(**request)
    except (rospy.ServiceException, rospy.ROSException, OSError) as error:
        raise LostError(f"cannot {what}: {error}") from error


def running_cell() -> str:
    """Return the name or file of the simulated cell that runs; empty if another one runs."""
    return str(rospy.get_param("cell/cell", ""))
