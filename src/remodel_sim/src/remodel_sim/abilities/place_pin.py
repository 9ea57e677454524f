"""PlacePin: two arms lay the live wire, its pins at two connectors and itself along the path.

A wire that is let go with slack springs straight and takes its ends with it. So the arms draw it
taut, by the force at their wrists, before they let go.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from remodel_sim.abilities.ability import ability
from remodel_sim.abilities.execution.robot_context import Station, Steps
from remodel_sim.abilities.primitives.concurrently import together
from remodel_sim.abilities.primitives.grasping import (
    FLOOR_CLEARANCE_M,
    check_grip,
    pick_end,
    release,
)
from remodel_sim.abilities.primitives.motions import (
    APPROACH_SPEED,
    CARRY_SPEED,
    CARRY_Z,
    HAND_OPEN_M,
    disengage,
    move_to,
    park,
    rise,
    wait,
)
from remodel_sim.abilities.primitives.observing import OverheadSighting, look_from_above, mark_end
from remodel_sim.abilities.primitives.pushing import BLIND_S, axial, tool_before
from remodel_sim.core.belief.belief_state import Grip
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Array, Pose, wrap_angle
from remodel_sim.core.goals.pin_goal import PlacePinGoal, pin_row
from remodel_sim.core.robot.arm import ToolPose
from remodel_sim.core.robot.motion import MAX_TURN_RATE, PEAK_OVER_MEAN
from remodel_sim.core.vision.drawing import ORANGE, Drawing
from remodel_sim.core.vision.wire_ends import trace_from
from remodel_sim.core.workpiece.panel import End
from remodel_sim.physics.robot_description import PAD_BELOW_TOOL_M
from remodel_states.core.codes import Code

# A pin may lie so far from its place, and the wire so far from a pose of the path [m]: nothing
# holds the wire, so that it takes up to 10 mm of its coil's bow again when it is let go.
PIN_TOLERANCE_M = 0.015
PATH_TOLERANCE_M = 0.025
# The feeder's fork waits here while the wire is laid, beyond the plate [m].
FORK_AWAY_M = (0.50, 0.62)
SLOWEST = 1e-3  # [m/s]
# A wire is taut at this pull [N]; each arm draws so fast [m/s], and so far at most [m].
TAUT_N = 2.0
DRAW_SPEED = 0.010
DRAW_M = 0.012
STILL_S = 0.15


@dataclass(frozen=True)
class PinPlaced:
    """A wire laid between two connectors.

    Attributes:
        message: for a person.
    """

    message: str


@dataclass(frozen=True)
class Hand:
    """One arm's part: which end it lays, and where that pin goes, x out of the wire."""

    station: Station
    end: End
    pin: Pose


def _goal(message: Any) -> PlacePinGoal:  # noqa: ANN401 - messages have no types
    return PlacePinGoal(
        message.robot_1_name,
        message.robot_2_name,
        message.path_space,
        message.connector_space,
        message.centered,
        message.rotate,
        message.show_in_TF,
    )


@ability("PlacePin", _goal)
def place_pin(one: Station, two: Station, goal: PlacePinGoal) -> Steps[PinPlaced]:
    """Pick both ends, carry them together, lay them down together, and look."""
    row = pin_row(goal, one.wire)
    if goal.show_in_tf:
        one.show_frames({f"placepin/{name}": pose for name, pose in row.items()})
    hands = _share_out((one, two), row)
    yield from together(*(disengage(hand.station) for hand in hands))
    if one.book.grip is None and two.book.grip is None:
        one.report("looking for both pins", 0.05)
        yield from together(park(one), park(two))
        yield from look_from_above(one)
    one.report("picking both ends", 0.1)
    yield from together(*(_pick(hand) for hand in hands))
    one.move_fork(*FORK_AWAY_M)
    one.report("carrying both ends to their connectors", 0.5)
    yield from _move_both(hands, [_above(hand) for hand in hands], CARRY_SPEED)
    for hand in hands:
        check_grip(hand.station)
    one.report("laying both pins down", 0.65)
    yield from _move_both(hands, [_lying(hand) for hand in hands], APPROACH_SPEED)
    one.report("drawing the wire taut", 0.7)
    yield from together(*(_draw(hand) for hand in hands))
    yield from together(*(_let_go(hand) for hand in hands))
    one.report("looking at what lies there", 0.8)
    yield from together(park(one), park(two))
    above = yield from look_from_above(one)
    worst = _judge(one, above, hands, row)
    return PinPlaced(
        f"pins of {one.wire.id} lie {goal.connector_space * 1e3:.0f} mm apart, within "
        f"{worst * 1e3:.1f} mm of their places"
    )


def _share_out(stations: tuple[Station, Station], row: dict[str, Pose]) -> list[Hand]:
    """Return which robot lays which end where: as they hold them, else by the shortest ways.

    The wire is not turned round: the end that lies nearer to a pin goes there.
    """
    options = []
    for first, pins in itertools.product((End.A, End.B), (("pin_1", "pin_2"), ("pin_2", "pin_1"))):
        ends = (first, first.other)
        hands = [
            Hand(station, end, row[pin])
            for station, end, pin in zip(stations, ends, pins, strict=True)
        ]
        if all(h.station.book.grip is None or h.station.book.grip.end is h.end for h in hands):
            options.append((sum(_way(hand) for hand in hands), hands))
    return min(options, key=lambda option: option[0])[1]


def _way(hand: Hand) -> float:
    """Return how far an arm goes to its end's place, and that end to its pin's [m]."""
    book, pin = hand.station.book, hand.pin.position[:2]
    if book.grip is not None:
        return float(np.linalg.norm(hand.station.commanded.position[:2] - pin))
    lies = book.expected[hand.end]
    reach = np.linalg.norm(hand.station.home.position[:2] - lies)
    return float(reach + 2 * np.linalg.norm(lies - pin))


def _pick(hand: Hand) -> Steps[None]:
    if hand.station.book.grip is None:
        yield from pick_end(hand.station, hand.end, 0.0, hand.pin, (0.1, 0.45))


def _grip(hand: Hand) -> Grip:
    grip = hand.station.book.grip
    if grip is None:
        raise AbilityError(Code.NOTHING_HELD, f"{hand.station.name} holds nothing; try again")
    return grip


def _above(hand: Hand) -> ToolPose:
    return tool_before(hand.pin, _grip(hand), 0.0).at(z=CARRY_Z)


def _lying(hand: Hand) -> ToolPose:
    tool = tool_before(hand.pin, _grip(hand), 0.0)
    return tool.at(z=max(tool.z, PAD_BELOW_TOOL_M + FLOOR_CLEARANCE_M))


def _move_both(hands: list[Hand], targets: list[ToolPose], speed: float) -> Steps[None]:
    """Move both tools in straight lines that begin and end at the same time.

    So the distance between them is never more than at the start or at the end, and the wire is
    never pulled taut on the way.
    """
    ways, turns = [], []
    for hand, target in zip(hands, targets, strict=True):
        now = hand.station.commanded
        ways.append(float(np.linalg.norm(target.position - now.position)))
        turns.append(abs(wrap_angle(target.yaw - now.yaw)))
    duration = max(max(ways) / speed, max(turns) / MAX_TURN_RATE) * PEAK_OVER_MEAN
    yield from together(
        *(
            move_to(hand.station, target, max(SLOWEST, PEAK_OVER_MEAN * way / duration))
            for hand, target, way in zip(hands, targets, ways, strict=True)
            if way > 0
        )
    )


def _draw(hand: Hand) -> Steps[None]:
    """Draw an end out along the row until the wire pulls back."""
    station, out = hand.station, hand.pin.rotation[:, 0]
    yield from wait(station, STILL_S)
    rest, start = station.force, station.commanded
    for tick in range(1, math.ceil(DRAW_M / DRAW_SPEED / station.tick_s) + 1):
        if tick * station.tick_s > BLIND_S and axial(station.force - rest, out) > TAUT_N:
            break
        x, y, _ = (float(v) for v in start.position + tick * DRAW_SPEED * station.tick_s * out)
        station.drive(ToolPose(x, y, start.z, start.yaw))
        yield
    check_grip(station)


def _let_go(hand: Hand) -> Steps[None]:
    book = hand.station.book
    book.expected[hand.end] = hand.pin.position[:2].copy()
    book.tips.pop(hand.end, None)
    yield from release(hand.station, HAND_OPEN_M)
    yield from rise(hand.station)


def _judge(
    station: Station, above: OverheadSighting, hands: list[Hand], row: dict[str, Pose]
) -> float:
    """Return how far the worse pin is from its place [m]; raise when it or the wire is too far."""
    drawing = Drawing(above.picture.rgb, above.picture.view)
    away: dict[End, float] = {}
    for hand in hands:
        if hand.end in above.ends:
            tip = above.ends[hand.end].tip.tip
            away[hand.end] = float(np.linalg.norm(tip[:2] - hand.pin.position[:2]))
            mark_end(drawing, above.ends[hand.end], f"{away[hand.end] * 1e3:.1f} mm")
    for pose in row.values():
        drawing.circle(above.picture.view.project(pose.position)[0], 6, ORANGE)
    drawing.title(f"PlacePin: {len(away)} of 2 pins seen")
    station.show("overhead", above.picture, drawing.image)
    for hand in hands:
        if away.get(hand.end, math.inf) > PIN_TOLERANCE_M:
            found = f"{away[hand.end] * 1e3:.0f} mm away" if hand.end in away else "not seen"
            raise AbilityError(
                Code.NOT_SEATED,
                f"pin {hand.end.value} of {station.wire.id!r} is {found}, allowed: "
                f"{PIN_TOLERANCE_M * 1e3:.0f} mm from its place; place it again",
            )
    _judge_path(station, above, [pose for name, pose in row.items() if name.startswith("path")])
    return max(away.values())


def _judge_path(station: Station, above: OverheadSighting, path: list[Pose]) -> None:
    wire = station.wire
    lines = [
        above.picture.view.on_plane(
            trace_from(sighting, above.picture, above.likelihood, wire), wire.radius
        )
        for sighting in above.ends.values()
    ]
    line: Array = np.concatenate(lines)[:, :2]
    for i, pose in enumerate(path, 1):
        away = float(np.linalg.norm(line - pose.position[:2], axis=1).min())
        if away > PATH_TOLERANCE_M:
            raise AbilityError(
                Code.OUT_OF_DUCT,
                f"{wire.id!r} passes {away * 1e3:.0f} mm beside pose {i} of the path, allowed: "
                f"{PATH_TOLERANCE_M * 1e3:.0f} mm; place it again",
            )
