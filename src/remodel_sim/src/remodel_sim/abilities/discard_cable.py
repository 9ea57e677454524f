"""DiscardCable: release a wire's connected ends, and drop the wire into the scrap bin."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from remodel_sim.abilities.ability import ability
from remodel_sim.abilities.execution.robot_context import Station, Steps
from remodel_sim.abilities.extract_cable import extract_cable, where_it_lay
from remodel_sim.abilities.locate_gearbox_component import locate_gearbox_component
from remodel_sim.abilities.primitives.carrying import carry
from remodel_sim.abilities.primitives.grasping import (
    RELEASE_OPENING_M,
    check_grip,
    holds,
    pick_end,
    release,
)
from remodel_sim.abilities.primitives.laying import lay_down
from remodel_sim.abilities.primitives.motions import (
    CARRY_SPEED,
    HAND_OPEN_M,
    nearest_hand_yaw,
    rise,
    wait,
)
from remodel_sim.abilities.primitives.observing import loose_ends
from remodel_sim.core.belief.openings import TerminalKey, mouth_of, nearest_terminal
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Pose
from remodel_sim.core.goals import DiscardGoal, ExtractGoal, LocateGoal
from remodel_sim.core.robot.arm import ToolPose
from remodel_sim.core.workpiece.panel import End
from remodel_states.core.codes import Code

# A wire that is drawn out of clips or out of a duct pulls more than a free one; one that pulls more
# than the grip holds safely hangs on something [N].
MAX_PULL_N = 25.0
# The fingers are open after this [s].
OPENING_S = 0.2


@dataclass(frozen=True)
class CableDiscarded:
    """No piece of the wire is left.

    Attributes:
        message: for a person.
    """

    message: str


def _goal(message: Any) -> DiscardGoal:  # noqa: ANN401 - messages have no types
    return DiscardGoal(message.robot_name, message.cable_id)


@ability("DiscardCable", _goal)
def discard_cable(station: Station, goal: DiscardGoal) -> Steps[CableDiscarded]:
    """Take the live wire, or one that was parked, off the panel, whatever holds it there."""
    book = station.book
    wire_id = goal.cable_id or station.wire.id
    if wire_id not in book.fed:
        return CableDiscarded(f"no piece of {wire_id} is in the cell")
    above_bin = station.scrap_bin
    if book.grip is not None and not holds(station):
        book.grip = None
        if not goal.cable_id:
            raise AbilityError(Code.NOTHING_HELD, f"{wire_id!r} slipped out of the fingers")
    station.make_live(wire_id)
    yield from _release_ends(station)
    if book.grip is None:
        yield from _pick_an_end(station, above_bin)
    yield from _drop(station, above_bin)
    return CableDiscarded(f"{wire_id} dropped into the scrap bin")


def _release_ends(station: Station) -> Steps[None]:
    """Extract each end of the live wire that is in a terminal."""
    book, wire_id = station.book, station.wire.id
    if book.engaged is not None:
        yield from _extract(
            station, nearest_terminal(book.engaged.position, station.panel, book.seen)
        )
    connected = [key for key, (wire, _) in book.occupied.items() if wire == wire_id]
    if connected and book.grip is not None:
        grip = book.grip
        target = where_it_lay(station, grip, book.picked_at[grip.end])
        yield from lay_down(station, target, (0.1, 0.2))
    for key in connected:
        yield from _extract(station, key)


def _extract(station: Station, terminal: TerminalKey) -> Steps[None]:
    """Extract the end in a terminal; raises EXTRACTION_STUCK, the hand empty and the end there."""
    book = station.book
    component_id, terminal_id = terminal
    if book.engaged is None and component_id not in book.seen:
        yield from locate_gearbox_component(station, LocateGoal(component_id, terminal_id))
    socket = book.engaged or mouth_of(terminal, station.panel, book.seen)
    goal = ExtractGoal(station.name, station.wire.id, component_id, terminal_id, socket)
    try:
        yield from extract_cable(station, goal)
    except AbilityError as error:
        grip = book.grip
        if error.code is not Code.EXTRACTION_STUCK or grip is None:
            raise
        book.seat(grip.end, terminal)
        yield from release(station, RELEASE_OPENING_M)
        yield from rise(station)
        text = f"{error}; it was released there, the hand is empty"
        raise AbilityError(error.code, text, **error.found) from error


def _pick_an_end(station: Station, above_bin: ToolPose) -> Steps[None]:
    """Pick a loose end, the one nearer to the bin first: then the wire trails along its channel."""

    def away(end: End) -> float:
        return float(np.linalg.norm(station.book.expected[end] - above_bin.position[:2]))

    failures: list[AbilityError] = []
    for end in sorted(loose_ends(station), key=away):
        socket = _toward(above_bin, station, end)
        try:
            yield from pick_end(station, end, 0.0, socket, (0.5, 0.7))
        except AbilityError as error:
            failures.append(error)
        else:
            return
    raise failures[-1]


def _toward(above_bin: ToolPose, station: Station, end: End) -> Pose:
    """Return the tip's pose over the bin, pointing as it does in its channel."""
    feed = station.book.feed
    assert feed is not None, "the wire is live"
    out = feed.direction if end is End.B else -feed.direction
    return Pose.level(above_bin.x, above_bin.y, above_bin.z, out * math.pi / 2)


def _drop(station: Station, above_bin: ToolPose) -> Steps[None]:
    """Carry the wire in the hand over the bin, and open."""
    station.report("carrying the wire to the scrap bin", 0.7)
    free, now = station.force, station.commanded
    station.lower_fork()
    yield from rise(station, above_bin.z)
    yaw = nearest_hand_yaw(station.arm, above_bin.x, above_bin.y, now.yaw, now.yaw)
    over = ToolPose(above_bin.x, above_bin.y, station.commanded.z, yaw)
    yield from carry(station, over, CARRY_SPEED, free, MAX_PULL_N)
    check_grip(station)
    station.report("dropping the wire", 0.95)
    station.drive_fingers(HAND_OPEN_M)
    yield from wait(station, OPENING_S)
    station.discard()
