"""What closes clamps and what presents wires, behind services."""

from __future__ import annotations

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
from remodel_work.cell.presentation import Presentation
from remodel_work.errors import AbilityError, PanelError
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Panel, WireEnd
from remodel_work.placed_wires import ParkedWire
from remodel_work.robot.arm import ToolPose
from remodel_work.ros.panel_message import panel_message

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
        named = self._topics.operate_clamp, "fixture.operate_clamp"
        return _done(self._topics, named, srv.OperateClamp, request)


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
        named = self._topics.present_wire, "magazine.present_wire"
        answer = _done(self._topics, named, srv.PresentWire, request)
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
        named = self._topics.operate_magazine, "magazine.operate"
        _done(self._topics, named, srv.OperateMagazine, request)


def _done(topics: CellTopics, named: tuple[str | None, str], kind: Any, request: Any) -> Any:  # noqa: ANN401
    """Return the answer of a service that did what it was asked for; raises INTERNAL.

    `named` is the service's name, and the entry of the robot's file that has it.
    """
    name, entry = named
    if name is None:
        raise AbilityError(Code.INTERNAL, f"{topics.file} names no {entry}; this ability needs it")
    answer = _ask(name, kind, request)
    if not answer.success:
        raise AbilityError(Code.INTERNAL, f"{name}: {answer.message}")
    return answer


def _ask(name: str, kind: Any, request: Any) -> Any:  # noqa: ANN401
    try:
        rospy.wait_for_service(name, SERVICE_S)
        return rospy.ServiceProxy(name, kind)(request)
    except (rospy.ROSException, rospy.ServiceException) as error:
        raise AbilityError(
            Code.INTERNAL, f"service {name} does not answer ({error}); see whether it runs"
        ) from error


def _pose(message: PoseMsg) -> Pose:
    p, q = message.position, message.orientation
    return Pose(np.array([p.x, p.y, p.z]), np.array([q.x, q.y, q.z, q.w]))


def _placed() -> ParkedWire:
    """Return a wire in its place, of which no shape is known."""
    return ParkedWire(np.zeros((0, 3)), frozenset(WireEnd))
