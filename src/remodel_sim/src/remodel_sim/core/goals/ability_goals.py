"""The goals of the abilities, valid from birth.

`check` tells whether the cell can take them as it is now.

Whatever raises here is found before anything moves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from remodel_sim.core.belief.belief_state import Book, EndState
from remodel_sim.core.belief.openings import mouth_of, nearest_terminal
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Pose, wrap_angle
from remodel_sim.core.robot.arm import Arm, ToolPose
from remodel_sim.core.workpiece.layout import GRASP_DISTANCE_M, STANDOFF_M, WORLD_FROM_PANEL
from remodel_sim.core.workpiece.panel import End, Panel, unit_x
from remodel_sim.core.workpiece.routes import clips_along
from remodel_states.core.codes import Code

# What the grip holds safely by friction [N].
MAX_FORCE_N = 25.0
# A connector's ribs give a better hold.
MAX_MATING_FORCE_N = 40.0
GRASP_RANGE_M = (0.030, 0.080)
# A tool pose may tilt so much and still counts as level [rad].
LEVEL_RAD = math.radians(2.0)
# A socket further than this from the panel's own place is no pose of that terminal [m].
SOCKET_TOLERANCE_M = 0.05
# A mouth that lies or points so far from where its component was last seen is not what was seen:
# a look errs by less than 1 mm and 1 deg, and a push finds out by itself that it is 6 mm beside.
MOUTH_TOLERANCE_M = 0.010
MOUTH_TOLERANCE_RAD = math.radians(10.0)


def require(condition: bool, message: str) -> None:
    """Raise INVALID_GOAL with a message unless the condition holds."""
    if not condition:
        raise AbilityError(Code.INVALID_GOAL, message)


def require_number(name: str, value: float, low: float, high: float, unit: str) -> None:
    """Raise INVALID_GOAL unless a field is a finite number within limits."""
    allowed = f"allowed: {low:g} to {high:g} {unit}"
    require(math.isfinite(value), f"{name} is {value}; {allowed}")
    require(low <= value <= high, f"{name} is {value:g} {unit}; {allowed}")


def require_pose(name: str, pose: Pose) -> None:
    """Raise INVALID_GOAL unless a pose is finite, and level with a unit quaternion."""
    require(bool(np.isfinite(pose.position).all()), f"{name}: position is not finite")
    require(bool(np.isfinite(pose.quaternion).all()), f"{name}: orientation is not finite")
    norm = float(np.linalg.norm(pose.quaternion))
    require(abs(norm - 1) < 1e-3, f"{name}: the quaternion's length is {norm:.3f}; it must be 1")
    tilt = math.asin(float(np.clip(unit_x(pose)[2], -1, 1)))
    require(
        abs(tilt) < LEVEL_RAD,
        f"{name}: its x axis is tilted by {math.degrees(tilt):.1f} deg; it must be level",
    )


def require_robot(name: str) -> None:
    """Raise INVALID_GOAL when no robot is named; whether the cell has it, the cell knows."""
    require(bool(name.strip()), "robot_name is empty; it must name the robot that does it")


def check_live(cable_id: str, panel: Panel, book: Book) -> None:
    """Raise unless a wire is the one that was fed last."""
    panel.wire(cable_id)
    if book.feed is None:
        raise AbilityError(Code.WIRE_NOT_FED, f"wire {cable_id!r} has not been fed; feed it first")
    if book.feed.wire_id != cable_id:
        raise AbilityError(
            Code.WIRE_NOT_FED,
            f"wire {cable_id!r} is not the one fed last, which is {book.feed.wire_id!r}; feed it "
            "first",
        )


def check_held(book: Book, end: End | None = None) -> None:
    """Raise unless the hand holds the live wire, at that end if one is named."""
    if book.grip is None:
        raise AbilityError(Code.NOTHING_HELD, "the gripper is empty; pick the wire first")
    if end is not None and book.grip.end is not end:
        raise AbilityError(
            Code.OTHER_CABLE_HELD,
            f"the gripper holds end {book.grip.end.value}, not end {end.value}; place it first",
        )


def check_hand(book: Book, end: End) -> None:
    """Raise unless the hand is empty or holds that end, and no other robot holds it."""
    for robot, grip in book.hands.items():
        if robot != book.robot and grip.end is end:
            raise AbilityError(
                Code.OTHER_CABLE_HELD,
                f"{robot} holds end {end.value}; have it placed first",
            )
    if book.grip is not None:
        check_held(book, end)


def check_hands_empty(book: Book) -> None:
    """Raise OTHER_CABLE_HELD when any robot holds a wire."""
    for robot, grip in book.hands.items():
        held = book.feed.wire_id if book.feed is not None else ""
        raise AbilityError(
            Code.OTHER_CABLE_HELD, f"{robot} holds end {grip.end.value} of {held!r}; place it first"
        )


def check_not_in_cell(wire_id: str, book: Book) -> None:
    """Raise WIRE_LEFT_BEHIND when a piece of a wire is in the cell."""
    if wire_id not in book.fed:
        return
    where = "left on the panel"
    if book.feed is not None and book.feed.wire_id == wire_id:
        presented = f"presented in channel {book.feed.channel_id!r}"
        where = "moved or connected" if book.is_touched else presented
    raise AbilityError(
        Code.WIRE_LEFT_BEHIND,
        f"a piece of wire {wire_id!r} is in the cell already, {where}; discard it first",
    )


def parse_end(text: str) -> End:
    """Return the end named "a" or "b"."""
    require(text in ("a", "b"), f"cable_end is {text!r}; allowed: 'a', 'b'")
    return End(text)


class Goal(Protocol):
    """What every goal can be asked."""

    def check(self, panel: Panel, book: Book) -> None:
        """Raise AbilityError when the cell cannot take the goal as it is now."""


@dataclass(frozen=True)
class LocateGoal:
    """Find a component and, unless the id is empty, one of its terminals.

    `view` 0 is the usual viewpoint, more are others.
    """

    component_id: str
    terminal_id: str
    view: int = 0

    def check(self, panel: Panel, book: Book) -> None:
        """Raise when a name is unknown."""
        component = panel.component(self.component_id)
        if self.terminal_id:
            component.terminal(self.terminal_id)


@dataclass(frozen=True)
class CheckGoal:
    """See whether an end of a wire sits in a terminal; any wire of the panel, fed or not."""

    cable_id: str
    end: End
    component_id: str
    terminal_id: str

    def check(self, panel: Panel, book: Book) -> None:
        """Raise when a name is unknown."""
        panel.wire(self.cable_id)
        check_clamp(self.component_id, self.terminal_id, panel)


@dataclass(frozen=True)
class DetectGoal:
    """Find a wire and its loose ends; `view` 0 is the usual viewpoint, more are others."""

    cable_id: str
    view: int = 0

    def check(self, panel: Panel, book: Book) -> None:
        """Raise when the wire is unknown or not fed."""
        check_live(self.cable_id, panel, book)


@dataclass(frozen=True)
class PickGoal:
    """Grasp a loose end; a distance of 0 means the cell's default."""

    robot_name: str
    cable_id: str
    end: End
    grasp_distance: float

    def __post_init__(self) -> None:
        """Refuse unknown robots and impossible distances."""
        require_robot(self.robot_name)
        if self.grasp_distance != 0.0:
            require_number("grasp_distance", self.grasp_distance, *GRASP_RANGE_M, "m")

    def check(self, panel: Panel, book: Book) -> None:
        """Raise when the end cannot be picked."""
        check_live(self.cable_id, panel, book)
        check_hand(book, self.end)
        if book.grip is not None:
            raise AbilityError(
                Code.OTHER_CABLE_HELD,
                f"the gripper holds end {book.grip.end.value} of {self.cable_id!r} already; "
                "place it first",
            )
        if book.feed is not None and book.ends[self.end].value != "loose":
            raise AbilityError(
                Code.INVALID_GOAL,
                f"end {self.end.value} of {self.cable_id!r} is {book.ends[self.end].value} in a "
                "terminal; extract it first",
            )


@dataclass(frozen=True)
class PlaceGoal:
    """Lay the held end down, of whatever wire when `cable_id` is empty.

    `target` has the tool centre at release, x along the wire towards the tip.
    """

    robot_name: str
    cable_id: str
    target: Pose

    def __post_init__(self) -> None:
        """Refuse unknown robots and poses that are not level."""
        require_robot(self.robot_name)
        require_pose("target_pose", self.target)

    def check(self, panel: Panel, book: Book) -> None:
        """Raise when nothing is held or the place is out of reach."""
        if self.cable_id:
            check_live(self.cable_id, panel, book)
        check_held(book)
        check_tool_path((self.target,), book)


@dataclass(frozen=True)
class RouteGoal:
    """Carry the held end along poses of the tool centre, x along the wire towards the tip.

    Or lay the wire into the clips that the path passes.
    """

    robot_name: str
    cable_id: str
    path: tuple[Pose, ...]

    def __post_init__(self) -> None:
        """Refuse unknown robots, an empty path and poses that are not level."""
        require_robot(self.robot_name)
        require(bool(self.path), "path is empty; it must have one pose or more")
        for i, pose in enumerate(self.path):
            require_pose(f"path[{i}]", pose)

    def check(self, panel: Panel, book: Book) -> None:
        """Raise when nothing is held or a pose is out of reach."""
        check_live(self.cable_id, panel, book)
        check_held(book)
        check_tool_path(self.path, book)
        clips = clips_along(self.path, panel)
        if clips and book.grip is not None and book.ends[book.grip.end.other] is EndState.LOOSE:
            other = book.grip.end.other.value
            raise AbilityError(
                Code.INVALID_GOAL,
                f"the path passes clips {', '.join(clip.id for clip in clips)}, and end {other} of "
                f"{self.cable_id!r} is loose; insert and fix it first",
            )


@dataclass(frozen=True)
class InsertGoal:
    """Push an end into a terminal whose mouth is at `socket`, x into the bore."""

    robot_name: str
    cable_id: str
    end: End
    component_id: str
    terminal_id: str
    socket: Pose
    force_limit: float

    def __post_init__(self) -> None:
        """Refuse unknown robots, tilted poses, and forces that the grip does not hold."""
        require_robot(self.robot_name)
        require_pose("socket_pose", self.socket)
        require_number("force_limit", self.force_limit, 1.0, MAX_FORCE_N, "N")

    def check(self, panel: Panel, book: Book) -> None:
        """Raise when the end cannot go there."""
        check_live(self.cable_id, panel, book)
        check_clamp(self.component_id, self.terminal_id, panel)
        connector = panel.wire(self.cable_id).connector_at(self.end)
        if connector is not None:
            raise AbilityError(
                Code.INVALID_GOAL,
                f"end {self.end.value} of {self.cable_id!r} is connector {connector.id!r}; place "
                "it with PlaceConnector",
            )
        check_free(self, self.end, panel, book)


@dataclass(frozen=True)
class ConnectGoal:
    """Push a connector into the header whose face is at `socket`, x into it."""

    robot_name: str
    connector_id: str
    cable_id: str
    component_id: str
    terminal_id: str
    socket: Pose
    force_limit: float

    def __post_init__(self) -> None:
        """Refuse unknown robots, tilted poses, and forces that the grip does not hold."""
        require_robot(self.robot_name)
        require_pose("socket_pose", self.socket)
        require_number("force_limit", self.force_limit, 1.0, MAX_MATING_FORCE_N, "N")

    def check(self, panel: Panel, book: Book) -> None:
        """Raise when the connector does not fit, or cannot go there."""
        check_live(self.cable_id, panel, book)
        connector = panel.wire(self.cable_id).connector(self.connector_id)
        header = panel.component(self.component_id).terminal(self.terminal_id)
        if not connector.fits(header):
            raise AbilityError(
                Code.INVALID_GOAL,
                f"connector {connector.id!r} has {connector.ways} ways, "
                f"{connector.pitch * 1e3:.2f} mm apart; '{self.component_id}/{self.terminal_id}' "
                f"takes {header.ways}, {header.pitch * 1e3:.2f} mm apart",
            )
        check_free(self, connector.end, panel, book)


@dataclass(frozen=True)
class FixGoal:
    """Close a terminal on the end in the hand; a pull test of 0 N means none."""

    robot_name: str
    cable_id: str
    component_id: str
    terminal_id: str
    pull_test_force: float

    def __post_init__(self) -> None:
        """Refuse unknown robots and forces that the grip does not hold."""
        require_robot(self.robot_name)
        require_number("pull_test_force", self.pull_test_force, 0.0, MAX_FORCE_N, "N")

    def check(self, panel: Panel, book: Book) -> None:
        """Raise when nothing is held."""
        check_live(self.cable_id, panel, book)
        check_clamp(self.component_id, self.terminal_id, panel)
        check_held(book)


@dataclass(frozen=True)
class ExtractGoal:
    """Pull a wire's end out of the terminal whose mouth is at `socket`, x into the bore."""

    robot_name: str
    cable_id: str
    component_id: str
    terminal_id: str
    socket: Pose

    def __post_init__(self) -> None:
        """Refuse unknown robots and poses that are not level."""
        require_robot(self.robot_name)
        require_pose("socket_pose", self.socket)

    def check(self, panel: Panel, book: Book) -> None:
        """Raise when the wire or the socket is not there."""
        check_live(self.cable_id, panel, book)
        check_socket(self.component_id, self.terminal_id, self.socket, panel, book)


def check_clamp(component_id: str, terminal_id: str, panel: Panel) -> None:
    """Raise unless a terminal is a clamp for one wire's end."""
    if panel.component(component_id).terminal(terminal_id).is_header:
        raise AbilityError(
            Code.INVALID_GOAL,
            f"'{component_id}/{terminal_id}' is a header, which takes a connector and latches by "
            "itself; use PlaceConnector",
        )


def check_free(goal: InsertGoal | ConnectGoal, end: End, panel: Panel, book: Book) -> None:
    """Raise unless a loose end, in the hand or to be picked, may go into a mouth as it is now."""
    key = (goal.component_id, goal.terminal_id)
    check_socket(*key, goal.socket, panel, book)
    check_mouth(*key, goal.socket, panel, book)
    check_hand(book, end)
    if book.ends[end] is not EndState.LOOSE:
        raise AbilityError(
            Code.INVALID_GOAL,
            f"end {end.value} of {goal.cable_id!r} is {book.ends[end].value} in a terminal; "
            "extract it first",
        )
    occupant = book.occupant(key)
    if occupant is not None:
        raise AbilityError(
            Code.TERMINAL_OCCUPIED,
            f"terminal '{'/'.join(key)}' holds end {occupant[1].value} of {occupant[0]!r}",
        )


def check_socket(
    component_id: str, terminal_id: str, socket: Pose, panel: Panel, book: Book
) -> None:
    """Raise when a mouth is not near the terminal it is said to be, or out of reach."""
    nominal = WORLD_FROM_PANEL @ panel.panel_from_socket(component_id, terminal_id)
    away = float(np.linalg.norm(socket.position - nominal.position))
    if away > SOCKET_TOLERANCE_M:
        raise AbilityError(
            Code.INVALID_GOAL,
            f"socket_pose is {away * 1e3:.0f} mm from terminal '{component_id}/{terminal_id}' on "
            "the panel, "
            f"allowed: {SOCKET_TOLERANCE_M * 1e3:.0f} mm; locate the terminal first",
        )
    tool = socket.position - unit_x(socket) * (GRASP_DISTANCE_M + STANDOFF_M)
    x, y, z = (float(v) for v in tool)
    check_reach(book.arm, ToolPose(x, y, z, socket.yaw))


def check_mouth(
    component_id: str, terminal_id: str, socket: Pose, panel: Panel, book: Book
) -> None:
    """Raise when a mouth is another terminal's, or is not where this one's was last seen."""
    where = f"'{component_id}/{terminal_id}'"
    known = mouth_of((component_id, terminal_id), panel, book.seen)
    source = "was last seen" if component_id in book.seen else "is on the panel"
    away = float(np.linalg.norm(socket.position - known.position))
    nearest = nearest_terminal(socket.position, panel, book.seen)
    if nearest != (component_id, terminal_id):
        raise AbilityError(
            Code.INVALID_GOAL,
            f"socket_pose is at the mouth of '{'/'.join(nearest)}', {away * 1e3:.0f} mm from where "
            f"{where} {source}; locate {where} and insert there",
        )
    turned = abs(wrap_angle(socket.yaw - known.yaw))
    if away > MOUTH_TOLERANCE_M or turned > MOUTH_TOLERANCE_RAD:
        raise AbilityError(
            Code.COMPONENT_DISPLACED,
            f"socket_pose is {away * 1e3:.0f} mm and {math.degrees(turned):.0f} deg from where "
            f"{where} {source}, allowed: {MOUTH_TOLERANCE_M * 1e3:.0f} mm and "
            f"{math.degrees(MOUTH_TOLERANCE_RAD):.0f} deg; locate it and insert where it is seen",
        )


def check_tool_path(path: tuple[Pose, ...], book: Book) -> None:
    """Raise UNREACHABLE when the held wire's tool poses are out of the arm's reach."""
    flip = book.grip.flip if book.grip is not None else 0.0
    for pose in path:
        x, y, z = (float(v) for v in pose.position)
        book.arm.joints_for(ToolPose(x, y, z, pose.yaw - flip))


def check_reach(arm: Arm, tool: ToolPose) -> None:
    """Raise UNREACHABLE when neither the pose nor that with the hand turned by pi is reached."""
    try:
        arm.joints_for(tool)
    except AbilityError:
        arm.joints_for(ToolPose(tool.x, tool.y, tool.z, tool.yaw + math.pi))
