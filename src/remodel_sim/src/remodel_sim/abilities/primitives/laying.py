"""Carry a held end over the panel and lay it down, as steps of an ability."""

from __future__ import annotations

import numpy as np

from remodel_sim.abilities.execution.robot_context import Station, Steps
from remodel_sim.abilities.primitives.grasping import check_grip, release
from remodel_sim.abilities.primitives.motions import (
    APPROACH_SPEED,
    CARRY_SPEED,
    CARRY_Z,
    FREE_SPEED,
    HAND_OPEN_M,
    TRAVEL_Z,
    move_to,
    rise,
)
from remodel_sim.core.belief.belief_state import EndState, Grip
from remodel_sim.core.cell.feeding import FORK_BEHIND_GRASP_M
from remodel_sim.core.robot.arm import ToolPose
from remodel_sim.core.workpiece.layout import WORLD_FROM_PANEL

# Within this distance the wire is carried low, between the rows; further it is lifted over them
# [m].
LOW_CARRY_M = 0.04
# The fork takes a wire that is so near to the middle of its channel [m].
FORK_TOLERANCE_M = 0.010


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
