"""A cell whose robots are behind their drivers' topics: the port's adapter for real robots."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from types import MappingProxyType
from typing import Any

import numpy as np
import rospy
from geometry_msgs.msg import Point
from remodel_msgs import srv

from remodel_skills.device import Device, PlacedEnds
from remodel_skills.edge.cell_memory import CellMemory
from remodel_skills.edge.robot_file import CameraTopics, CellTopics, read_robot
from remodel_skills.ros.driven_robot import (
    SILENCE_S,
    DrivenArm,
    DrivenCamera,
    DrivenGripper,
    Inbox,
    wrist_view,
)
from remodel_skills.ros.node import OpenedPlant
from remodel_states.core.codes import Code
from remodel_work.camera import View
from remodel_work.cell.held_panel import find_panel_problems, held_panel
from remodel_work.cell.presentation import Presentation
from remodel_work.errors import AbilityError, CellError, PanelError
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Panel, WireEnd
from remodel_work.placed_wires import ParkedWire
from remodel_work.robot.arm import ToolPose
from remodel_work.ros.panel_message import panel_message

# What each ability needs of a cell besides arm, hand and wrist.
NEEDS = {
    "overhead": (
        *("CheckConnection", "DetectCable", "DiscardCable", "FixCable", "LayWire"),
        *("LocateGearboxComponent", "RouteWire"),
    ),
    "fixture": ("ExtractCable", "FixCable"),
    "magazine": ("DiscardCable", "LayWire", "PickCable", "PlacePin"),
}
# Drivers that are being started are heard of within this time [s of the wall].
START_S = 20.0
# A fixture, or a person who is asked, is done within this time [s of the wall].
SERVICE_S = 60.0
# An arm that stands nearer to its home than this may go there by its first motion [m].
AT_HOME_M = 0.02
# Robots and wires come to rest after an ability in this time [s].
REST_S = 0.15


class DrivenCell:
    """A cell behind topics and services; its plant, and its clock.

    Attributes:
        design: of the cell.
        tick_s: time between two commands to an arm [s].
        panel, loaded: as the port has them.
        parked: the wires that have their place; their shapes are not known.
    """

    def __init__(self, topics: CellTopics, panel: Panel) -> None:
        """Subscribe to all drivers, and wait until each has been heard of.

        Raises:
            CellError: when one has not, in words that say which, or an arm is not at its home.
            PanelError: when the panel breaks the rules of the cell.
        """
        self._topics, self.design, self.tick_s = topics, topics.design, topics.tick_s
        self._inbox = Inbox()
        self._arms = {
            robot.name: DrivenArm(self._inbox, robot, topics.robots[robot.name], topics.tick_s)
            for robot in self.design.robots
        }
        self._grippers = {
            robot.name: DrivenGripper(self._arms[robot.name], robot, topics.robots[robot.name])
            for robot in self.design.robots
        }
        self._check(panel)
        self._await_drivers()
        self._check_homes()
        self._hold(panel, {})

    @property
    def lacks(self) -> dict[str, str]:
        """Why the cell cannot do an ability, by the ability's name."""
        named = {
            "overhead": self._topics.overhead,
            "fixture": self._topics.operate_clamp,
            "magazine": self._topics.present_wire,
        }
        return {
            ability: f"{self._topics.file} names no {part}"
            for part, abilities in NEEDS.items()
            for ability in abilities
            if named[part] is None
        }

    def _await_drivers(self) -> None:
        def heard() -> bool:
            return not any(arm.missing for arm in self._arms.values())

        with self._inbox.arrived:
            if self._inbox.arrived.wait_for(heard, START_S):
                return
        silent = [
            f"  - {name}: {topic}" for name, arm in self._arms.items() for topic in arm.missing
        ]
        lines = "\n".join(silent)
        raise CellError(
            f"{self._topics.file}: nothing came within {START_S:g} s on\n{lines}\nstart the "
            "drivers, or correct the names in the file"
        )

    def _check_homes(self) -> None:
        for robot in self.design.robots:
            tool = self._arms[robot.name].tool
            away = float(np.linalg.norm(tool.position - robot.home.position))
            if away > AT_HOME_M:
                raise CellError(
                    f"{robot.name} stands at {tool}, {away * 1e3:.0f} mm from its home in cell "
                    f"{self.design.name}, {robot.home}; bring it there by its own controls, then "
                    "start again"
                )

    @property
    def now(self) -> rospy.Time:
        """The time of the newest message of an arm."""
        return rospy.Time.from_sec(self.now_s)

    @property
    def now_s(self) -> float:
        """The same [s]."""
        return max(arm.stamp_s for arm in self._arms.values())

    def idle(self) -> None:
        """Real time needs no help."""

    def device_of(self, robot: str) -> Device:
        """Return a robot of the design."""
        design = next(design for design in self.design.robots if design.name == robot)
        arm = self._arms[robot]
        return Device(
            arm=arm,
            gripper=self._grippers[robot],
            wrist_camera=self._camera(
                self._topics.robots[robot].camera, lambda: wrist_view(arm, design), "wrist"
            ),
            overhead_camera=self._camera(
                self._topics.overhead, lambda: self.design.overhead, "overhead"
            ),
            fixture=self,
            magazine=self,
            tick_s=self.tick_s,
        )

    def _camera(
        self, topics: CameraTopics | None, see_from: Callable[[], View], name: str
    ) -> DrivenCamera:
        return DrivenCamera(self._inbox, topics, see_from, name)

    def tick(self) -> None:
        """Wait for the next tick of every arm, and answer wrenches meanwhile.

        Raises AbilityError SERVER_LOST when an arm says nothing more.
        """
        # Half a millisecond early is the tick as well: stamps are rounded.
        due_s = {name: arm.stamp_s + self.tick_s - 5e-4 for name, arm in self._arms.items()}
        silent_at = time.monotonic() + SILENCE_S
        while True:
            for arm in self._arms.values():
                arm.control()
            late = [name for name, arm in self._arms.items() if arm.stamp_s < due_s[name]]
            if not late:
                return
            with self._inbox.arrived:
                self._inbox.arrived.wait(0.1)
            if time.monotonic() > silent_at:
                raise AbilityError(
                    Code.INTERNAL,
                    f"{late[0]} has published no joint states for {SILENCE_S:g} s; it stands where "
                    "it was sent last: see whether its driver runs",
                )

    def rest(self) -> None:
        """Let robots and wires come to rest."""
        for _ in range(round(REST_S / self.tick_s)):
            self.tick()

    def find_problems(self, panel: Panel) -> tuple[str, ...]:
        """Return why the cell cannot hold a panel, one sentence each; none: it can."""
        return find_panel_problems(self.design, panel)

    def load(self, panel: Panel, placed: Mapping[str, ParkedWire] = MappingProxyType({})) -> None:
        """Hold a panel, with the wires that lie on it; raises PanelError, and nothing changes.

        A fixture that is told keeps the wires of this very panel if there are any.
        """
        self._check(panel)
        if self._topics.load_panel is not None:
            answer = self._ask(
                self._topics.load_panel,
                srv.LoadPanel,
                srv.LoadPanelRequest(panel=panel_message(panel), keep=bool(placed)),
            )
            if not answer.success:
                raise PanelError(panel.name, (str(answer.message),))
        self._hold(panel, placed)

    def _check(self, panel: Panel) -> None:
        problems = self.find_problems(panel)
        if problems:
            raise PanelError(panel.name, problems)

    def _hold(self, panel: Panel, placed: Mapping[str, ParkedWire]) -> None:
        self.loaded, self.panel = panel, held_panel(self.design, panel)
        self.parked = dict(placed)
        self._last: str | None = None

    def feed(self, wire_id: str, channel_id: str, tools: Mapping[str, ToolPose]) -> Presentation:
        """Present a wire of which no piece is in the cell; raises AbilityError INTERNAL."""
        answer = self._present(wire_id, channel_id, placed=False)
        self.park()
        self._last = wire_id
        self._open_hands()
        tips = {end: _pose(tip) for end, tip in zip(WireEnd, answer.tips, strict=True)}
        return Presentation(tips, answer.direction)

    def _present(self, wire_id: str, channel_id: str, *, placed: bool) -> Any:  # noqa: ANN401
        name = self._needed(self._topics.present_wire, "magazine.present_wire")
        request = srv.PresentWireRequest(wire_id=wire_id, channel_id=channel_id, placed=placed)
        return self._done(name, srv.PresentWire, request)

    def _open_hands(self) -> None:
        for robot in self.design.robots:
            self._grippers[robot.name].open_to(robot.arm.fingers.opening / 2)

    def is_at_hand(self, wire_id: str) -> bool:
        """Return whether a wire is the one that was presented last."""
        return wire_id == self._last

    def take_up(self, wire_id: str, tools: Mapping[str, ToolPose]) -> PlacedEnds:
        """Make a placed wire one that can be handled again; raises AbilityError INTERNAL."""
        answer = self._present(wire_id, "", placed=True)
        self.park()
        self.parked.pop(wire_id, None)
        self._last = wire_id
        self._open_hands()
        expected = {end: _pose(tip).position for end, tip in zip(WireEnd, answer.tips, strict=True)}
        fixed = {end for end, held in zip(WireEnd, answer.fixed, strict=True) if held}
        return PlacedEnds(expected, frozenset(fixed))

    def shapes(self) -> dict[str, ParkedWire]:
        """Return the wires that lie in the cell, by name; of no shape that is known."""
        last = {} if self._last is None else {self._last: _placed()}
        return {**self.parked, **last}

    def park(self) -> None:
        """Note that the wire that was handled last has its place."""
        if self._last is not None:
            self.parked[self._last] = _placed()
            self._last = None

    def drop(self, over_bin: Array) -> None:
        """Let a bin take what an open hand drops."""
        self._operate(srv.OperateMagazineRequest.DROP, at=over_bin)
        self._last = None

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
        name = self._needed(self._topics.operate_magazine, "magazine.operate")
        point = Point() if at is None else Point(*at.tolist())
        request = srv.OperateMagazineRequest(command=command, end=end, at=point)
        self._done(name, srv.OperateMagazine, request)

    def close_clamp(self, component_id: str, terminal_id: str) -> bool:
        """Close a clamp; returns whether it stopped on something before the end of its travel."""
        return bool(self._clamp(component_id, terminal_id, close=True).met)

    def open_clamp(self, component_id: str, terminal_id: str) -> None:
        """Open a clamp."""
        self._clamp(component_id, terminal_id, close=False)

    def _clamp(self, component_id: str, terminal_id: str, *, close: bool) -> Any:  # noqa: ANN401
        name = self._needed(self._topics.operate_clamp, "fixture.operate_clamp")
        request = srv.OperateClampRequest(component_id, terminal_id, close)
        return self._done(name, srv.OperateClamp, request)

    def _needed(self, name: str | None, entry: str) -> str:
        if name is None:
            raise AbilityError(
                Code.INTERNAL, f"{self._topics.file} names no {entry}; this ability needs it"
            )
        return name

    def _done(self, name: str, kind: Any, request: Any) -> Any:  # noqa: ANN401
        answer = self._ask(name, kind, request)
        if not answer.success:
            raise AbilityError(Code.INTERNAL, f"{name}: {answer.message}")
        return answer

    def _ask(self, name: str, kind: Any, request: Any) -> Any:  # noqa: ANN401
        try:
            rospy.wait_for_service(name, SERVICE_S)
            return rospy.ServiceProxy(name, kind)(request)
        except rospy.ROSException as error:
            raise AbilityError(
                Code.INTERNAL, f"service {name} does not answer ({error}); see whether it runs"
            ) from error

    def close(self) -> None:
        """Leave the arms where they are."""


def _pose(message: Any) -> Pose:  # noqa: ANN401
    p, q = message.position, message.orientation
    return Pose(np.array([p.x, p.y, p.z]), np.array([q.x, q.y, q.z, q.w]))


def _placed() -> ParkedWire:
    """Return a wire in its place, of which no shape is known."""
    return ParkedWire(np.zeros((0, 3)), frozenset(WireEnd))


def open_driven_cell(panel: Panel, _memory: CellMemory | None, _closing: ExitStack) -> OpenedPlant:
    """Return the cell whose drivers the file `~robot` names; raises CellError."""
    cell = DrivenCell(read_robot(str(rospy.get_param("~robot"))), panel)
    return OpenedPlant(cell, cell, lacks=cell.lacks)
