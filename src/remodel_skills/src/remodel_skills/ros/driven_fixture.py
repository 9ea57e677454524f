"""What closes clamps and what presents wires, behind services."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import rospy
from geometry_msgs.msg import Point
from geometry_msgs.msg import Pose as PoseMsg
from remodel_msgs import srv

from remodel_skills.device import PlacedEnds
from remodel_skills.edge.robot_file import CellTopics
from remodel_states.core.codes import Code
from remodel_work.cell.presenting import Presentation
from remodel_work.errors import AbilityError, PanelError
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Panel, WireEnd
from remodel_work.robot.arm import ToolPose
from remodel_work.ros.panel_message import panel_message
from remodel_work.routes import ParkedWire

# A fixture, or a person who is asked, is done within this time [s of the wall].
SERVICE_S = 60.0


class DrivenFixture:
    """Clamps behind a service, and what holds the board."""

    def __init__(self, topics: CellTopics) -> None:
        """Name the services."""
        self._topics = topics

    def load(self, panel: Panel, *, keep: bool) -> None:
        """Report which panel is held, if anything wants to know; raises PanelError.

        `keep`: leave everything as it is if it is held already.
        """
        if self._topics.load_panel is None:
            return
        request = srv.LoadPanelRequest(panel=panel_message(panel), keep=keep)
        answer = _ask(self._topics.load_panel, srv.LoadPanel, request)
        if not answer.success:
            raise PanelError(panel.name, (str(answer.message),))

    def close_clamp(self, component_id: str, terminal_id: str) -> bool:
        """Close a clamp; returns whether it stopped on something before the end of its travel."""
        return bool(self._operate(component_id, terminal_id, close=True).met)

    def open_clamp(self, component_id: str, terminal_id: str) -> None:
        """Open a clamp."""
        self._operate(component_id, terminal_id, close=False)

    def _operate(self, component_id: str, terminal_id: str, *, close: bool) -> Any:  # noqa: ANN401
        request = srv.OperateClampRequest(component_id, terminal_id, close)
        return _done(self._topics.operate_clamp, srv.OperateClamp, request)


class DrivenMagazine:
    """What presents wires, behind services.

    Attributes:
        parked: the wires that have their place, by name; their shapes are not known.
        last: the wire that was presented last; None: it has its place, or is gone.
    """

    def __init__(self, topics: CellTopics, open_hands: Callable[[], None]) -> None:
        """Name the services; `open_hands` opens the fingers of all robots."""
        self._topics, self._open_hands = topics, open_hands
        self.parked: dict[str, ParkedWire] = {}
        self.last: str | None = None

    def present(self, wire_id: str, channel_id: str) -> Presentation:
        """Present a wire of which no piece is in the cell; raises AbilityError INTERNAL."""
        answer = self._present(wire_id, channel_id, placed=False)
        tips = {end: _pose(tip) for end, tip in zip(WireEnd, answer.tips, strict=True)}
        return Presentation(tips, answer.direction)

    def take_up(self, wire_id: str, tools: Mapping[str, ToolPose]) -> PlacedEnds:
        """Make a placed wire one that can be handled again; raises AbilityError INTERNAL."""
        answer = self._present(wire_id, "", placed=True)
        expected = {end: _pose(tip).position for end, tip in zip(WireEnd, answer.tips, strict=True)}
        fixed = {end for end, held in zip(WireEnd, answer.fixed, strict=True) if held}
        return PlacedEnds(expected, frozenset(fixed))

    def _present(self, wire_id: str, channel_id: str, *, placed: bool) -> Any:  # noqa: ANN401
        request = srv.PresentWireRequest(wire_id=wire_id, channel_id=channel_id, placed=placed)
        answer = _done(self._topics.present_wire, srv.PresentWire, request)
        self.park()
        self.parked.pop(wire_id, None)
        self.last = wire_id
        self._open_hands()
        return answer

    def is_at_hand(self, wire_id: str) -> bool:
        """Return whether a wire is the one that was presented last."""
        return wire_id == self.last

    def shapes(self) -> dict[str, ParkedWire]:
        """Return the wires that lie in the cell, by name; of no shape that is known."""
        last = {} if self.last is None else {self.last: _placed()}
        return {**self.parked, **last}

    def park(self) -> None:
        """Note that the wire that was handled last has its place."""
        self.parked, self.last = self.shapes(), None

    def drop(self, over_bin: Array) -> None:
        """Let a bin take what an open hand drops."""
        self._operate(srv.OperateMagazineRequest.DROP, at=over_bin)
        self.last = None

    def open_magazine(self, end: WireEnd) -> None:
        """Open the clips that hold an end."""
        self._operate(srv.OperateMagazineRequest.OPEN, end=end.value)

    def move_fork(self, x: float, y: float) -> None:
        """Bring the feeder's fork up around a wire, along the middle of a channel."""
        self._operate(srv.OperateMagazineRequest.MOVE_FORK, at=np.array([x, y, 0.0]))

    def lower_fork(self) -> None:
        """Draw the feeder's fork in."""
        self._operate(srv.OperateMagazineRequest.LOWER_FORK)

    def _operate(self, command: int, end: str = "", at: Array | None = None) -> None:
        point = Point() if at is None else Point(*at.tolist())
        request = srv.OperateMagazineRequest(command=command, end=end, at=point)
        _done(self._topics.operate_magazine, srv.OperateMagazine, request)


def _done(name: str, kind: Any, request: Any) -> Any:  # noqa: ANN401 - any service
    """Return the answer of a service that did what it was asked for; raises INTERNAL."""
    answer = _ask(name, kind, request)
    if not answer.success:
        raise AbilityError(Code.INTERNAL, f"{name}: {answer.message}")
    return answer


def _ask(name: str, kind: Any, request: Any) -> Any:  # noqa: ANN401 - any service
    """Return the answer of a service; raises INTERNAL when there is none in SERVICE_S.

    rospy's calls have no time limit. One that is given up goes on in its thread: what it moves may
    still move, which the message says.
    """
    answers: queue.Queue[Any] = queue.Queue()

    def call() -> None:
        try:
            rospy.wait_for_service(name, SERVICE_S)
            answers.put(rospy.ServiceProxy(name, kind)(request))
        except Exception as error:  # noqa: BLE001 - reported in the thread that asked
            answers.put(error)

    threading.Thread(target=call, name=f"ask {name}", daemon=True).start()
    try:
        answer = answers.get(timeout=SERVICE_S)
    except queue.Empty:
        answer = f"nothing within {SERVICE_S:g} s; what it moves may still move"
    if isinstance(answer, str | Exception):
        raise AbilityError(
            Code.INTERNAL, f"service {name} does not answer ({answer}); see whether it runs"
        )
    return answer


def _pose(message: PoseMsg) -> Pose:
    p, q = message.position, message.orientation
    return Pose(np.array([p.x, p.y, p.z]), np.array([q.x, q.y, q.z, q.w]))


def _placed() -> ParkedWire:
    """Return a wire in its place, of which no shape is known."""
    return ParkedWire(np.zeros((0, 3)), frozenset(WireEnd))
