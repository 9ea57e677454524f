"""A cell behind topics and services: the port's adapter for real robots.

Its clamps and what presents wires are behind services; its robots (driven_robot.py) behind topics.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Collection, Mapping, Set
from contextlib import ExitStack
from types import MappingProxyType
from typing import Any

import numpy as np
import rosgraph
import rospy
from geometry_msgs.msg import Point
from geometry_msgs.msg import Pose as PoseMsg
from remodel_msgs import srv

from remodel_skills.device import Device, PlacedEnds
from remodel_skills.edge.cell_memory import CellMemory
from remodel_skills.edge.robot_file import CellTopics, read_robot
from remodel_skills.ros.driven_robot import (
    NUMB_S,
    SILENCE_S,
    DrivenArm,
    DrivenCamera,
    DrivenGripper,
    Inbox,
    wrist_view,
)
from remodel_skills.ros.node import OpenedPlant
from remodel_states.core.codes import Code
from remodel_work.camera import Picture
from remodel_work.cell.cell_design import CellDesign, RobotDesign, find_panel_problems, held_panel
from remodel_work.cell.presenting import Presentation
from remodel_work.errors import AbilityError, CellError, PanelError
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


# Drivers that are being started are heard of within this time [s of the wall].
START_S = 20.0
# Between two looks for drivers [s].
POLL_S = 0.2
# An arm that stands nearer to its home than this may go there by its first motion [m].
AT_HOME_M = 0.02


class DrivenClock:
    """The time of a cell behind topics: that of the newest joint states."""

    def __init__(self, arms: Collection[DrivenArm]) -> None:
        """Take the time from arms."""
        self._arms = arms

    @property
    def now_s(self) -> float:
        """The time [s]."""
        return max(arm.sensors.stamp_s for arm in self._arms)

    @property
    def now(self) -> rospy.Time:
        """The time as messages have it."""
        return rospy.Time.from_sec(self.now_s)

    def idle(self) -> None:
        """Real time needs no help."""


class DrivenCell:
    """The plant of a cell behind topics and services.

    Attributes:
        clock: its time.
        design: of the cell.
        tick_s: time between two commands to an arm [s].
        panel, loaded: as the port has them.
    """

    def __init__(self, topics: CellTopics, panel: Panel) -> None:
        """Subscribe to all drivers, and wait until each is there.

        Raises:
            CellError: when one is not, in words that say which, or an arm is not at its home.
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
        _require_fit(self.design, panel)
        await_drivers(topics, self._arms, self._inbox)
        for robot in self.design.robots:
            require_home(robot, self._arms[robot.name].tool)
        self.clock = DrivenClock(self._arms.values())
        self._fixture = DrivenFixture(topics)
        self._magazine = DrivenMagazine(topics, self._open_hands)
        self._hold(panel, {})

    def device_of(self, robot: str) -> Device:
        """Return a robot of the design."""
        design = next(design for design in self.design.robots if design.name == robot)
        arm = self._arms[robot]
        return Device(
            arm=arm,
            gripper=self._grippers[robot],
            wrist_camera=DrivenCamera(
                self._inbox,
                self._topics.robots[robot].camera,
                lambda: wrist_view(arm, design),
            ),
            overhead_cameras=tuple(
                DrivenCamera(self._inbox, topics, lambda view=view: view)
                for topics, view in zip(self._topics.overheads, self.design.overheads, strict=True)
            ),
            fixture=self._fixture,
            magazine=self._magazine,
            tick_s=self.tick_s,
            lead_s=self._topics.robots[robot].lead_s,
        )

    def photograph(self, camera: str) -> Picture:
        """Take a picture for people: by the overhead camera for the scene, which has none."""
        for robot in self.design.robots:
            if camera == robot.camera.name:
                return self.device_of(robot.name).wrist_camera.take()
        return self.device_of(self.design.robots[0].name).overhead_cameras[0].take()

    def tick(self) -> None:
        """Wait for the next tick of every arm, and answer wrenches meanwhile.

        Raises AbilityError MOTION_FAULT when an arm says nothing more, or pushes and feels nothing.
        """
        # Half a millisecond early is the tick as well: stamps are rounded.
        due_s = {name: arm.sensors.stamp_s + self.tick_s - 5e-4 for name, arm in self._arms.items()}
        silent_at = time.monotonic() + SILENCE_S
        while True:
            for name, arm in self._arms.items():
                arm.control()
                if arm.is_numb:
                    raise AbilityError(
                        Code.MOTION_FAULT,
                        f"{name} pushes, and {self._topics.robots[name].wrench[0]} has published "
                        f"no force for {NUMB_S:g} s; it stands where it was sent last: see whether "
                        "the sensor's driver runs",
                    )
            late = [name for name, due in due_s.items() if self._arms[name].sensors.stamp_s < due]
            if not late:
                return
            with self._inbox.arrived:
                self._inbox.arrived.wait(0.1)
            if time.monotonic() > silent_at:
                raise AbilityError(
                    Code.MOTION_FAULT,
                    f"{late[0]} has published no joint states for {SILENCE_S:g} s; it stands where "
                    "it was sent last: see whether its driver runs",
                )

    def rest(self, seconds: float) -> None:
        """Let robots and wires come to rest for a time [s]."""
        for _ in range(round(seconds / self.tick_s)):
            self.tick()

    def find_problems(self, panel: Panel) -> tuple[str, ...]:
        """Return why the cell cannot hold a panel, one sentence each; none: it can."""
        return find_panel_problems(self.design, panel)

    def load(self, panel: Panel, placed: Mapping[str, ParkedWire] = MappingProxyType({})) -> None:
        """Hold a panel, with the wires that lie on it; raises PanelError, and nothing changes.

        A fixture that is asked keeps the wires of this very panel if there are any.
        """
        _require_fit(self.design, panel)
        self._fixture.load(panel, keep=bool(placed))
        self._hold(panel, placed)

    def _hold(self, panel: Panel, placed: Mapping[str, ParkedWire]) -> None:
        self.loaded, self.panel = panel, held_panel(self.design, panel)
        self._magazine.parked, self._magazine.last = dict(placed), None

    def _open_hands(self) -> None:
        for robot in self.design.robots:
            self._grippers[robot.name].open_to(robot.arm.fingers.opening / 2)

    def feed(self, wire_id: str, channel_id: str, tools: Mapping[str, ToolPose]) -> Presentation:
        """Present a wire of which no piece is in the cell; raises AbilityError INTERNAL."""
        return self._magazine.present(wire_id, channel_id)

    @property
    def parked(self) -> dict[str, ParkedWire]:
        """The wires that have their place; their shapes are not known."""
        return self._magazine.parked

    def shapes(self) -> dict[str, ParkedWire]:
        """Return the wires that lie in the cell, by name; of no shape that is known."""
        return self._magazine.shapes()

    def park(self) -> None:
        """Note that the wire that was handled last has its place."""
        self._magazine.park()

    def close(self) -> None:
        """Leave the arms where they are."""


def await_drivers(topics: CellTopics, arms: Mapping[str, DrivenArm], inbox: Inbox) -> None:
    """Wait until all drivers are there; raises CellError that lists those that are not."""
    end = time.monotonic() + START_S
    while True:
        missing = [
            f"{name}: {topic}" for name, arm in arms.items() for topic in arm.sensors.missing
        ]
        missing += missing_interfaces(topics, *ros_graph())
        if not missing:
            return
        if time.monotonic() > end or rospy.is_shutdown():
            lines = "\n".join(f"  - {each}" for each in missing)
            raise CellError(
                f"{topics.file}: missing after {START_S:g} s\n{lines}\nstart the drivers, or "
                "correct the names in the file"
            )
        with inbox.arrived:
            inbox.arrived.wait(POLL_S)


def ros_graph() -> tuple[set[str], set[str], set[str]]:
    """Return the topics that are published, those that are subscribed to, and the services."""
    published, subscribed, services = rosgraph.Master(rospy.get_name()).getSystemState()
    return {t for t, _ in published}, {t for t, _ in subscribed}, {name for name, _ in services}


def missing_interfaces(
    topics: CellTopics, published: Set[str], subscribed: Set[str], services: Set[str]
) -> list[str]:
    """Return what a cell needs and no node offers: each camera, command and service."""
    robots = topics.robots.values()
    cameras = [*topics.overheads, *(robot.camera for robot in robots)]
    images = [topic for camera in cameras for topic in (camera.image, camera.depth) if topic]
    commands = [command for robot in robots for command in (robot.motion, robot.gripper)]
    asked = (topics.operate_clamp, topics.present_wire, topics.operate_magazine, topics.load_panel)
    return [
        *(f"{topic}: no node publishes pictures" for topic in images if topic not in published),
        *(
            f"{topic}: no node takes commands ({kind})"
            for topic, kind in commands
            if topic not in subscribed
        ),
        *(f"{name}: no such service" for name in asked if name and name not in services),
    ]


def _require_fit(design: CellDesign, panel: Panel) -> None:
    problems = find_panel_problems(design, panel)
    if problems:
        raise PanelError(panel.name, problems)


def require_home(robot: RobotDesign, tool: ToolPose) -> None:
    """Raise CellError if a robot is not at its home: its first motion would be a jump."""
    away = float(np.linalg.norm(tool.position - robot.home.position))
    if away > AT_HOME_M:
        raise CellError(
            f"{robot.name} stands at {tool}, {away * 1e3:.0f} mm from its home, {robot.home}; "
            "bring it there by its own controls, then start again"
        )


def open_driven_cell(panel: Panel, _memory: CellMemory | None, _closing: ExitStack) -> OpenedPlant:
    """Return the cell whose drivers the file `~robot` names; raises CellError."""
    topics = read_robot(str(rospy.get_param("~robot")))
    cell = DrivenCell(topics, panel)
    return OpenedPlant(cell, cell.clock, kind="simulated" if topics.is_simulated else "real")
