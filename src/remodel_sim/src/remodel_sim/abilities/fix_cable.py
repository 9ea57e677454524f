"""FixCable: close the terminal on the inserted end, prove it by a pull, and let go."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remodel_sim.abilities.grasping import RELEASE_OPENING_M, check_grip, release
from remodel_sim.abilities.insert_cable import axial
from remodel_sim.abilities.motions import APPROACH_SPEED, TRAVEL_Z, move_to, wait
from remodel_sim.abilities.station import Station, Steps
from remodel_sim.core.arm import ToolPose
from remodel_sim.core.book import EndState
from remodel_sim.core.codes import Code
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.goals import FixGoal
from remodel_sim.core.panel import unit_x

PULL_SPEED = 0.015  # [m/s]
# A straight, firmly held end takes up the pull within this travel: slack, pads and contacts give so
# much.
PULL_TRAVEL_M = 0.006
# The slip is counted from here on [share of the pull].
TAKEN_UP = 0.4
MAX_SLIP_M = 0.0015


@dataclass(frozen=True)
class CableFixed:
    """An end held by its terminal.

    Attributes:
        message: for a person.
        slip: movement of the end during the pull [m].
    """

    message: str
    slip: float


def fix_cable(station: Station, goal: FixGoal) -> Steps[CableFixed]:
    """Close the clamp, pull, open the fingers, and lift the hand off."""
    book = station.book
    key = (goal.component_id, goal.terminal_id)
    where = f"'{goal.component_id}/{goal.terminal_id}'"
    station.report(f"closing {where}", 0.1)
    end = book.grip.end if book.grip is not None else None
    closed = station.close_clamp(*key)
    yield from wait(station, 0.1)
    if end is None or not closed:
        raise AbilityError(
            Code.NOT_SEATED,
            f"the screw of {where} met nothing: the end is not deep enough; extract, locate "
            "again, insert again",
        )
    station.report(f"pulling with {goal.pull_test_force:.0f} N", 0.3)
    slip = 0.0
    if goal.pull_test_force > 0:
        slip = yield from _pull(station, goal)
    check_grip(station)
    if book.occupied.get(key) != (goal.cable_id, end):
        book.seat(end, key)
    book.ends[end] = EndState.FIXED
    station.report("letting go", 0.8)
    yield from release(station, RELEASE_OPENING_M)
    yield from move_to(station, station.commanded.at(z=TRAVEL_Z), APPROACH_SPEED * 2)
    other = book.ends[end.other]
    if other is EndState.LOOSE and end.other in book.expected:
        book.tips.pop(end.other, None)
    message = (
        f"end {end.value} of {goal.cable_id} fixed in {where}, slip {slip * 1e3:.2f} mm at "
        f"{goal.pull_test_force:.0f} N"
    )
    return CableFixed(message, slip)


def _pull(station: Station, goal: FixGoal) -> Steps[float]:
    """Pull the held end back, out of the bore, until the force is reached; return the slip [m]."""
    socket = station.book.engaged
    if socket is None:
        nominal = station.panel.panel_from_socket(goal.component_id, goal.terminal_id)
        socket = nominal
    out = -unit_x(socket)
    start = station.commanded
    travel, taken_up, force = 0.0, None, 0.0
    while force < goal.pull_test_force and travel < PULL_TRAVEL_M:
        travel += PULL_SPEED * station.tick_s
        station.drive(_shifted(start, out, travel))
        yield
        # The push left the end under load; the pull counts from the free hand.
        force = axial(station.force - station.free_force, out)
        if taken_up is None and force >= TAKEN_UP * goal.pull_test_force:
            taken_up = travel
    slip = travel - (taken_up if taken_up is not None else 0.0)
    if force < goal.pull_test_force or slip > MAX_SLIP_M:
        raise AbilityError(
            Code.PULLED_OUT,
            f"the end moved {slip * 1e3:.1f} mm in '{goal.component_id}/{goal.terminal_id}' at "
            f"{force:.1f} of "
            f"{goal.pull_test_force:.1f} N; extract, locate again, insert again",
            slip=slip,
        )
    station.drive(start)
    yield from wait(station, 0.15)
    return slip


def _shifted(tool: ToolPose, direction: np.ndarray, distance: float) -> ToolPose:
    return ToolPose(
        tool.x + distance * float(direction[0]),
        tool.y + distance * float(direction[1]),
        tool.z,
        tool.yaw,
    )
