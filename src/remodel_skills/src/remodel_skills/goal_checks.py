"""What goals must be: checks of their fields, and against the panel and the belief.

Each raises before anything moves.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from typing import Any, TypeAlias

import numpy as np

from remodel_skills.belief_state import BeliefState, Grip
from remodel_skills.parameters import TerminalParameters, ToolParameters
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import PANEL, WORLD, Pose, wrap_angle
from remodel_work.layout import GRASP_DISTANCE_M, STANDOFF_M
from remodel_work.panel import Panel, WireEnd, unit_x
from remodel_work.robot.arm import Kinematics, ToolPose
from remodel_work.routes import TerminalKey, nearest_terminal, opening_of


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
    """Raise INVALID_GOAL unless a pose is finite, with a unit quaternion."""
    require(bool(np.isfinite(pose.position).all()), f"{name}: position is not finite")
    require(bool(np.isfinite(pose.quaternion).all()), f"{name}: orientation is not finite")
    norm = float(np.linalg.norm(pose.quaternion))
    require(abs(norm - 1) < 1e-3, f"{name}: the quaternion's length is {norm:.3f}; it must be 1")


def require_level(name: str, pose: Pose, most_rad: float) -> None:
    """Raise INVALID_GOAL when a pose is tilted by so much."""
    tilt = math.asin(float(np.clip(unit_x(pose)[2], -1, 1)))
    require(
        abs(tilt) < most_rad,
        f"{name}: its x axis is tilted by {math.degrees(tilt):.1f} deg; it must be level",
    )


def require_robot(name: str) -> None:
    """Raise INVALID_GOAL when no robot is named; whether the cell has it, the cell knows."""
    require(bool(name.strip()), "robot_name is empty; it must name the robot that does it")


def parse_end(text: str) -> WireEnd:
    """Return the end named "a" or "b"."""
    require(text in ("a", "b"), f"cable_end is {text!r}; allowed: 'a', 'b'")
    return WireEnd(text)


def check_live(cable_id: str, panel: Panel, belief: BeliefState) -> None:
    """Raise unless a wire is the one that was fed last."""
    panel.wire(cable_id)
    if belief.feed is None:
        raise AbilityError(Code.WIRE_NOT_FED, f"wire {cable_id!r} has not been fed; feed it first")
    if belief.feed.wire_id != cable_id:
        raise AbilityError(
            Code.WIRE_NOT_FED,
            f"wire {cable_id!r} is not the one fed last, which is {belief.feed.wire_id!r}; feed it "
            "first",
        )


def check_held(belief: BeliefState, end: WireEnd | None = None) -> Grip:
    """Return what the hand holds; raises unless that is the live wire, at an end if it is named."""
    if belief.grip is None:
        raise AbilityError(Code.NOTHING_HELD, "the gripper is empty; pick the wire first")
    if end is not None and belief.grip.end is not end:
        raise AbilityError(
            Code.OTHER_CABLE_HELD,
            f"the gripper holds end {belief.grip.end.value}, not end {end.value}; place it first",
        )
    return belief.grip


def check_hand(belief: BeliefState, end: WireEnd) -> None:
    """Raise unless the hand is empty or holds that end, and no other robot holds it."""
    for robot, grip in belief.hands.items():
        if robot != belief.robot and grip.end is end:
            raise AbilityError(
                Code.OTHER_CABLE_HELD,
                f"{robot} holds end {end.value}; have it placed first",
            )
    if belief.grip is not None:
        check_held(belief, end)


def check_hands_empty(belief: BeliefState) -> None:
    """Raise OTHER_CABLE_HELD when any robot holds a wire."""
    for robot, grip in belief.hands.items():
        held = belief.feed.wire_id if belief.feed is not None else ""
        raise AbilityError(
            Code.OTHER_CABLE_HELD, f"{robot} holds end {grip.end.value} of {held!r}; place it first"
        )


def check_not_in_cell(wire_id: str, belief: BeliefState) -> None:
    """Raise WIRE_LEFT_BEHIND when a piece of a wire is in the cell."""
    if wire_id not in belief.fed:
        return
    where = "left on the panel"
    if belief.feed is not None and belief.feed.wire_id == wire_id:
        presented = "presented in the magazine"
        if not belief.by_magazine:
            presented = f"presented in channel {belief.feed.channel_id!r}"
        where = "moved or connected" if belief.is_touched else presented
    raise AbilityError(
        Code.WIRE_LEFT_BEHIND,
        f"a piece of wire {wire_id!r} is in the cell already, {where}; discard it first",
    )


def check_clamp(component_id: str, terminal_id: str, panel: Panel) -> None:
    """Raise unless a terminal is a clamp for one wire's end."""
    if panel.component(component_id).terminal(terminal_id).is_header:
        raise AbilityError(
            Code.INVALID_GOAL,
            f"'{component_id}/{terminal_id}' is a header, which takes a connector and latches by "
            "itself; use PlaceConnector",
        )


def check_socket(
    key: TerminalKey,
    socket: Pose,
    panel: Panel,
    belief: BeliefState,
    tolerances: TerminalParameters,
) -> None:
    """Raise when an opening is not near its terminal on the panel, or out of reach."""
    nominal = panel.world_from_panel @ panel.panel_from_socket(*key)
    away = float(np.linalg.norm(socket.position - nominal.position))
    if away > tolerances.socket_tolerance_m:
        raise AbilityError(
            Code.INVALID_GOAL,
            f"socket_pose is {away * 1e3:.0f} mm from terminal '{'/'.join(key)}' on "
            "the panel, "
            f"allowed: {tolerances.socket_tolerance_m * 1e3:.0f} mm; locate the terminal first",
        )
    tool = socket.position - unit_x(socket) * (GRASP_DISTANCE_M + STANDOFF_M)
    x, y, z = (float(v) for v in tool)
    check_reach(belief.arm, ToolPose(x, y, z, socket.yaw))


def check_opening(
    key: TerminalKey,
    socket: Pose,
    panel: Panel,
    belief: BeliefState,
    tolerances: TerminalParameters,
) -> None:
    """Raise when an opening is another terminal's, or is not where it was last observed."""
    where = f"'{'/'.join(key)}'"
    known = opening_of(key, panel, belief.seen)
    source = "was last seen" if key[0] in belief.seen else "is on the panel"
    away = float(np.linalg.norm(socket.position - known.position))
    nearest = nearest_terminal(socket.position, panel, belief.seen)
    if nearest != key:
        raise AbilityError(
            Code.INVALID_GOAL,
            f"socket_pose is at the opening of '{'/'.join(nearest)}', {away * 1e3:.0f} mm from "
            f"where {where} {source}; locate {where} and insert there",
        )
    turned = abs(wrap_angle(socket.yaw - known.yaw))
    most_m, most_rad = tolerances.opening_tolerance_m, tolerances.opening_tolerance_rad
    if away > most_m or turned > most_rad:
        raise AbilityError(
            Code.COMPONENT_DISPLACED,
            f"socket_pose is {away * 1e3:.0f} mm and {math.degrees(turned):.0f} deg from where "
            f"{where} {source}, allowed: {most_m * 1e3:.0f} mm and "
            f"{math.degrees(most_rad):.0f} deg; locate it and insert where it is seen",
        )


def check_tool_path(path: tuple[Pose, ...], belief: BeliefState) -> None:
    """Raise UNREACHABLE when the held wire's tool poses are out of the arm's reach."""
    flip = belief.grip.flip if belief.grip is not None else 0.0
    for pose in path:
        x, y, z = (float(v) for v in pose.position)
        belief.arm.joints_for(ToolPose(x, y, z, pose.yaw - flip))


def check_reach(arm: Kinematics, tool: ToolPose) -> None:
    """Raise UNREACHABLE when neither the pose nor that with the hand turned by pi is reached."""
    try:
        arm.joints_for(tool)
    except AbilityError:
        arm.joints_for(ToolPose(tool.x, tool.y, tool.z, tool.yaw + math.pi))


# A ROS message: the core imports none, and generated messages have no types.
Message: TypeAlias = Any


def pose_from(name: str, message: Message, board: Pose) -> Pose:
    """Return the pose of a field of type geometry_msgs/PoseStamped in the world frame.

    It may be given in the world's frame (which an empty name means) or in that of the panel, which
    is at `board`.

    Raises:
        AbilityError: if it is given in another one.
    """
    frame = message.header.frame_id.lstrip("/")
    if frame not in ("", WORLD, PANEL):
        raise AbilityError(
            Code.INVALID_GOAL,
            f"{name} is given in frame {frame!r}; allowed: {WORLD!r}, {PANEL!r}",
        )
    p, q = message.pose.position, message.pose.orientation
    pose = Pose(np.array([p.x, p.y, p.z]), np.array([q.x, q.y, q.z, q.w]))
    return board @ pose if frame == PANEL else pose


def find_demand_problems(
    robots: Collection[str],
    forces_n: Mapping[str, float],
    there: Collection[str],
    tool: ToolParameters,
) -> Iterator[str]:
    """Yield why goals of an order would be refused, one sentence each.

    Args:
        robots: that its goals name.
        forces_n: the greatest force limit [N] of its goals, by the ability.
        there: names of the cell's robots.
        tool: what their grips hold.
    """
    for robot in robots:
        if robot not in there:
            yield f"the order's goals name robot {robot!r}; the cell has {', '.join(there)}"
    limits_n = {
        "InsertCable": tool.grip_holds_n,
        "PlaceConnector": tool.grip_holds_connector_n,
    }
    for ability, force_n in forces_n.items():
        most_n = limits_n.get(ability, float("inf"))
        if force_n > most_n:
            yield (
                f"the use case has {ability} push with up to {force_n:g} N; this cell's grip "
                f"holds at most {most_n:g} N"
            )
