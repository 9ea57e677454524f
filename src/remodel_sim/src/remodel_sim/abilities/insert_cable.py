"""InsertCable: push one end of a wire into a terminal until it seats."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remodel_sim.abilities.grasping import check_grip, pick_end
from remodel_sim.abilities.motions import APPROACH_SPEED, disengage, move_to, wait
from remodel_sim.abilities.place_cable import carry_over
from remodel_sim.abilities.station import Station, Steps
from remodel_sim.core.arm import ToolPose
from remodel_sim.core.book import Grip
from remodel_sim.core.codes import Code
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Array, Pose
from remodel_sim.core.goals import InsertGoal
from remodel_sim.core.layout import STANDOFF_M
from remodel_sim.core.mouths import mouth_of
from remodel_sim.core.panel import Terminal, unit_x

# The tip goes to the mouth faster than into the bore [m/s]: what stops it there must not hurt it.
APPROACH_MOUTH_SPEED = 0.04
PUSH_SPEED = 0.02
# The push relaxes by so much once it has been stopped.
RELAX_M = 0.0004
# The push goes on so far beyond where the bottom should be.
OVERTRAVEL_M = 0.008
SLOW_BEFORE_M = 0.001
# Resistance so far before or beyond the bottom counts as the bottom. A turn of the hand draws the
# wire back in the grip by up to 3 mm, so that it meets the bottom late, by the arm's measure; early
# it does only in front of an obstacle.
SHORT_OF_BOTTOM_M = 0.003
BEYOND_BOTTOM_M = 0.006
# Resistance before this depth is the face's or the funnel's.
FACE_M = 0.003
# The arm's own start-up shakes the wrist for so long; nothing is touched yet.
BLIND_S = 0.12
STILL_S = 0.15


@dataclass(frozen=True)
class CableInserted:
    """An end at the bottom of a bore.

    Attributes:
        message: for a person.
        depth: from the mouth to the tip, by the arm [m].
        peak_force: largest axial force at the wrist [N].
    """

    message: str
    depth: float
    peak_force: float


@dataclass(frozen=True)
class Push:
    """How a push went.

    Attributes:
        tip: where it brought the tip, by the arm, (3,) [m], world frame.
        depth: of the tip beyond the mouth [m].
        peak_force: [N].
        stopped: whether the force limit stopped it.
    """

    tip: Array
    depth: float
    peak_force: float
    stopped: bool


def insert_cable(station: Station, goal: InsertGoal) -> Steps[CableInserted]:
    """Pick the end if the hand is empty, push it into the mouth, judge by travel and force."""
    yield from disengage(station)
    if station.book.grip is None:
        yield from pick_end(station, goal.end, 0.0, goal.socket, (0.0, 0.45))
    station.report(f"carrying end {goal.end.value} to {goal.component_id}/{goal.terminal_id}", 0.5)
    yield from _bring_before(station, goal.socket)
    check_grip(station)
    station.report("pushing", 0.75)
    station.book.engaged = goal.socket
    terminal = station.panel.component(goal.component_id).terminal(goal.terminal_id)
    push = yield from _push(station, goal.socket, terminal.depth, goal.force_limit)
    check_grip(station)
    key = (goal.component_id, goal.terminal_id)
    _judge_bore(push, mouth_of(key, station.panel, station.book.seen), terminal, goal)
    _judge_depth(push, terminal.depth, goal)
    station.book.seat(goal.end, key)
    message = (
        f"end {goal.end.value} of {goal.cable_id} seated in "
        f"{goal.component_id}/{goal.terminal_id}, "
        f"{push.depth * 1e3:.1f} mm deep, {push.peak_force:.1f} N"
    )
    return CableInserted(message, push.depth, push.peak_force)


def tool_before(socket: Pose, grip: Grip, ahead: float) -> ToolPose:
    """Return the tool pose that holds the tip on the bore's axis, `ahead` [m] beyond the mouth."""
    at = socket.position + unit_x(socket) * (ahead - grip.distance)
    x, y, z = (float(v) for v in at)
    return ToolPose(x, y, z - grip.height, socket.yaw - grip.flip)


def _bring_before(station: Station, socket: Pose) -> Steps[None]:
    target = tool_before(socket, _grip(station), -STANDOFF_M)
    yield from carry_over(station, target)
    yield from move_to(station, target, APPROACH_SPEED)
    yield from wait(station, STILL_S)


def _grip(station: Station) -> Grip:
    if station.book.grip is None:
        raise AbilityError(Code.NOTHING_HELD, "the gripper is empty; pick the wire first")
    return station.book.grip


def _push(station: Station, socket: Pose, depth: float, limit: float) -> Steps[Push]:
    into, grip = unit_x(socket), _grip(station)
    station.free_force = station.force
    peak, ahead, ticks = 0.0, -STANDOFF_M, 0
    stopped = False
    while ahead < depth + OVERTRAVEL_M and not stopped:
        ticks += 1
        speed = PUSH_SPEED if ahead > -SLOW_BEFORE_M else APPROACH_MOUTH_SPEED
        ahead += speed * station.tick_s
        station.drive(tool_before(socket, grip, ahead))
        yield
        force = axial(station.force - station.free_force, into)
        if ticks * station.tick_s > BLIND_S:
            peak = max(peak, force)
            stopped = force >= limit
        station.report("pushing", 0.75 + 0.2 * np.clip(ahead / depth, 0, 1))
    at = station.tool
    station.drive(tool_before(socket, grip, ahead - RELAX_M))
    yield from wait(station, 0.1)
    tip = at.position + into * grip.distance + np.array([0.0, 0.0, grip.height])
    return Push(tip, float((tip - socket.position) @ into), peak, stopped)


def axial(force: Array, into: Array) -> float:
    """Return how hard the hand pushes along a direction, (3,) [N] and unit vector (3,)."""
    return float(force @ into)


def _judge_bore(push: Push, mouth: Pose, terminal: Terminal, goal: InsertGoal) -> None:
    """Raise when the arm brought the tip beside the mouth, where that was last seen."""
    aside = float(np.linalg.norm(mouth.inverse().apply(push.tip)[1:]))
    reach = terminal.bore / 2 + terminal.chamfer
    if aside > reach:
        raise AbilityError(
            Code.INSERTION_MISALIGNED,
            f"the tip is {aside * 1e3:.1f} mm beside the axis of "
            f"'{goal.component_id}/{goal.terminal_id}', whose mouth takes {reach * 1e3:.1f} mm, at "
            f"{push.peak_force:.1f} N; extract, locate again, insert again",
            depth=push.depth,
            peak_force=push.peak_force,
        )


def _judge_depth(push: Push, bottom: float, goal: InsertGoal) -> None:
    where = f"'{goal.component_id}/{goal.terminal_id}'"
    depth, readings = push.depth * 1e3, {"depth": push.depth, "peak_force": push.peak_force}
    if not push.stopped or push.depth > bottom + BEYOND_BOTTOM_M:
        raise AbilityError(
            Code.INSERTION_NO_CONTACT,
            f"pushed to {depth:.1f} mm without meeting the bottom of {where} at "
            f"{bottom * 1e3:.1f} mm; "
            "extract, locate again, insert again",
            **readings,
        )
    if push.depth >= bottom - SHORT_OF_BOTTOM_M:
        return
    if push.depth < FACE_M:
        raise AbilityError(
            Code.INSERTION_MISALIGNED,
            f"{push.peak_force:.1f} N at {depth:.1f} mm: the tip sits on the face of {where}; "
            "extract, locate again, insert again",
            **readings,
        )
    raise AbilityError(
        Code.INSERTION_JAMMED,
        f"{push.peak_force:.1f} N at {depth:.1f} of {bottom * 1e3:.1f} mm in {where}; extract, "
        "locate again, insert "
        "again; a second time at the same depth: look for an obstacle",
        **readings,
    )
