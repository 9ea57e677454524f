"""PlaceCable: lay the held end down and let go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from remodel_sim.abilities.ability import ability
from remodel_sim.abilities.grasping import RELEASE_OPENING_M, check_grip, release
from remodel_sim.abilities.motions import (
    APPROACH_SPEED,
    CARRY_SPEED,
    CARRY_Z,
    FREE_SPEED,
    HAND_OPEN_M,
    TRAVEL_Z,
    held_tool,
    move_to,
    rise,
)
from remodel_sim.abilities.pulling_out import pull_out
from remodel_sim.abilities.station import Station, Steps
from remodel_sim.core.arm import ToolPose
from remodel_sim.core.book import EndState, Grip
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.feeding import FORK_BEHIND_GRASP_M
from remodel_sim.core.goal_pose import pose_from
from remodel_sim.core.goals import PlaceGoal
from remodel_sim.core.layout import WORLD_FROM_PANEL
from remodel_sim.core.mouths import nearest_terminal
from remodel_states.core.codes import Code

# Within this distance the wire is carried low, between the rows; further it is lifted over them
# [m].
LOW_CARRY_M = 0.04
# The fork takes a wire that is so near to the middle of its channel [m].
FORK_TOLERANCE_M = 0.010
# An end that is only pushed in comes out more easily; at a closed clamp the grip would slip.
MAX_PULL_N = 10.0


@dataclass(frozen=True)
class CablePlaced:
    """A wire laid down.

    Attributes:
        message: for a person.
    """

    message: str


def _goal(message: Any) -> PlaceGoal:  # noqa: ANN401 - messages have no types
    return PlaceGoal(
        message.robot_name, message.cable_id, pose_from("target_pose", message.target_pose)
    )


@ability("PlaceCable", _goal)
def place_cable(station: Station, goal: PlaceGoal) -> Steps[CablePlaced]:
    """Carry the held end to the target, let go there, and lift the empty hand.

    An end that sits in a terminal is drawn out; one that is fixed there is let go where it is.
    """
    yield from _draw_out(station)
    target = held_tool(station, goal.target)
    yield from lay_down(station, target, (0.0, 1.0))
    x, y = target.x, target.y
    return CablePlaced(f"{station.wire.id} laid down at x {x * 1e3:.0f}, y {y * 1e3:.0f} mm")


def _draw_out(station: Station) -> Steps[None]:
    """Draw the held end out of the mouth that it is in; raises EXTRACTION_STUCK, the hand empty."""
    book = station.book
    grip, socket = book.grip, book.engaged
    if grip is None or socket is None:
        return
    station.report("drawing the end out of its mouth", 0.0)
    try:
        yield from pull_out(station, socket, MAX_PULL_N)
        book.loosen(grip.end)
    except AbilityError as error:
        if error.code is not Code.EXTRACTION_STUCK:
            raise
        where = nearest_terminal(socket.position, station.panel, book.seen)
        book.seat(grip.end, where)
        book.ends[grip.end] = EndState.FIXED
        yield from release(station, RELEASE_OPENING_M)
        yield from rise(station)
        raise AbilityError(
            error.code,
            f"end {grip.end.value} is fixed in '{'/'.join(where)}': {error}; it was let go there, "
            "the hand is empty; extract it first",
        ) from error


def lay_down(
    station: Station, target: ToolPose, shares: tuple[float, float], *, fork: bool = True
) -> Steps[None]:
    """Carry the held end to a tool pose, let go, and lift the empty hand.

    `fork`: whether the feeder's fork may come up around it.
    """
    first, last = shares
    station.report("carrying the end to where it is laid down", first)
    yield from carry_over(station, target)
    check_grip(station)
    station.report("laying the end down", first + 0.6 * (last - first))
    yield from move_to(station, target, APPROACH_SPEED)
    grip = station.book.grip
    if grip is not None:
        tip = tip_of(target, grip)
        station.book.expected[grip.end] = tip
        station.book.tips.pop(grip.end, None)
        if fork:
            _bring_fork(station, target, grip)
    yield from release(station, HAND_OPEN_M)
    yield from rise(station)


def _bring_fork(station: Station, tool: ToolPose, grip: Grip) -> None:
    """Hold an end in the middle of its channel.

    A wire that is fixed at the other end would spring to a side.
    """
    book = station.book
    if book.feed is None or book.ends[grip.end.other] is EndState.LOOSE:
        return
    channel = station.panel.channel(book.feed.channel_id)
    middle = WORLD_FROM_PANEL.position[0] + channel.x
    if abs(tool.x - middle) < FORK_TOLERANCE_M:
        behind = np.array([tool.x, tool.y]) - tip_of(tool, grip)
        behind *= FORK_BEHIND_GRASP_M / np.linalg.norm(behind)
        station.move_fork(middle, tool.y + float(behind[1]))


def tip_of(tool: ToolPose, grip: Grip) -> np.ndarray:
    """Return where the held tip is for a tool pose, (2,) [m]."""
    yaw = tool.yaw + grip.flip
    return np.array([tool.x, tool.y]) + grip.distance * np.array([np.cos(yaw), np.sin(yaw)])


def carry_over(station: Station, target: ToolPose) -> Steps[None]:
    """Bring the held end above a tool pose, turned as there.

    Low within a channel, else over the rows.
    """
    now = station.commanded
    if abs(now.x - target.x) > LOW_CARRY_M:
        yield from move_to(station, now.at(z=TRAVEL_Z), FREE_SPEED / 2)
        yield from move_to(station, ToolPose(target.x, target.y, TRAVEL_Z, now.yaw), CARRY_SPEED)
        yield from move_to(station, station.commanded.at(z=CARRY_Z), APPROACH_SPEED)
    elif now.z > CARRY_Z:
        yield from move_to(station, ToolPose(target.x, target.y, now.z, now.yaw), CARRY_SPEED)
        yield from move_to(station, station.commanded.at(z=CARRY_Z), APPROACH_SPEED)
    yield from move_to(station, target.at(z=CARRY_Z), CARRY_SPEED)
