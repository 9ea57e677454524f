"""Looks at labels and at wire ends, as steps of an ability."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from remodel_sim.abilities.motions import (
    APPROACH_SPEED,
    CARRY_SPEED,
    TRAVEL_Z,
    clear_hand,
    move_to,
    nearest_hand_yaw,
    park,
    swing_to,
    wait,
)
from remodel_sim.abilities.station import Station, Steps
from remodel_sim.core.arm import TOOL_M, ToolPose
from remodel_sim.core.book import EndState, TipSighting
from remodel_sim.core.camera import Picture, View
from remodel_sim.core.codes import Code
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Array, Pose, wrap_angle
from remodel_sim.core.layout import GRASP_DISTANCE_M
from remodel_sim.core.panel import End
from remodel_sim.core.vision.drawing import BLUE, ORANGE, Drawing
from remodel_sim.core.vision.tracing import at_distance
from remodel_sim.core.vision.wire_ends import EndSighting, find_ends, trace_from
from remodel_sim.physics.robot_description import CAMERA_MOUNT

# The tool's height for a look from the hand: the lens is 84 mm above the tool centre.
LOOK_Z = 0.12
# The arm rings down before a picture is taken [s].
STILL_S = 0.10
# Places of the wrist camera beside a hidden end, x and y [m]: the lens is some 0.2 m high, where a
# wire 50 mm high moves by a third of that in the picture. Wires leave their terminals along x, so
# it is tried along y first.
ASIDE_M = ((0.0, 0.07), (0.0, -0.07), (0.07, 0.0), (-0.07, 0.0))
# The same beside a label, which lies nearer to the lens and stays in the picture so far.
LABEL_ASIDE_M = ((0.0, 0.045), (0.0, -0.045), (0.045, 0.0), (-0.045, 0.0))
# Turns of a hand that holds a wire, for a look at a component that it need not go to [rad].
EITHER_WAY = np.radians([0.0, 45.0, -45.0, 90.0, -90.0])
# A label that is hidden from one place of the lens is looked for from others, so far apart [m].
VIEWS_APART_M = 0.05
MAX_VIEWS = 4
# A wire is traced so far behind its tip to find the grasp [m].
TRACE_M = 0.075
BORDER_PX = 30.0


@dataclass(frozen=True, eq=False)
class OverheadSighting:
    """The live wire from above.

    Attributes:
        ends: the loose ends that are seen.
        picture: what the camera saw.
        likelihood: of the wire's colour, (height, width), 0 to 1.
    """

    ends: dict[End, EndSighting]
    picture: Picture
    likelihood: npt.NDArray[np.float32]


def loose_ends(station: Station) -> list[End]:
    """Return the ends of the live wire that lie about."""
    book = station.book
    held = {grip.end for grip in book.hands.values()}
    return [e for e, state in book.ends.items() if state is EndState.LOOSE and e not in held]


def look_from_above(station: Station) -> Steps[OverheadSighting]:
    """Look at the plate from above, the empty hand out of the way, and note the loose ends seen."""
    if station.book.grip is None:
        yield from park(station)
    picture = station.look_overhead()
    yield
    book = station.book
    expected = {end: book.expected[end] for end in loose_ends(station)}
    ends, likelihood = find_ends(picture, station.wire, expected)
    for end, sighting in ends.items():
        book.tips[end] = sighting.tip
    yield
    return OverheadSighting(ends, picture, likelihood)


@dataclass(frozen=True, eq=False)
class GraspSighting:
    """Where to grasp an end, by the wrist camera.

    Attributes:
        point: on the wire's axis, (3,) [m], world frame.
        tip_yaw: direction of the wire towards the tip, at that point [rad].
        tip: the end's apex.
    """

    point: Array
    tip_yaw: float
    tip: TipSighting


def look_at_end(station: Station, end: End, distance: float) -> Steps[GraspSighting]:
    """Find where to grasp a loose end: from above if it is not known, then from close by.

    Args:
        station: the cell.
        end: a loose end of the live wire.
        distance: from the tip to the grasp, along the wire [m].

    Raises:
        AbilityError: TIP_NOT_FOUND and the other codes of find_ends.
    """
    remembered = end in station.book.tips
    if not remembered:
        yield from _find_from_above(station, end)
    try:
        return (yield from _look_close(station, end, distance))
    except AbilityError as error:
        if not remembered or error.code is not Code.TIP_NOT_FOUND:
            raise
    yield from _find_from_above(station, end)
    return (yield from _look_close(station, end, distance))


def _find_from_above(station: Station, end: End) -> Steps[None]:
    above = yield from look_from_above(station)
    wire_id = station.wire.id
    drawing = Drawing(above.picture.rgb, above.picture.view)
    for seen, sighting in above.ends.items():
        mark_end(drawing, sighting, f"{wire_id} end {seen.value}")
    drawing.title(f"Looking for end {end.value} of {wire_id}")
    station.show("overhead", above.picture, drawing.image)
    if end not in above.ends and not (yield from look_from_aside(station, end)):
        raise AbilityError(
            Code.TIP_NOT_FOUND,
            f"end {end.value} of {wire_id!r} is not seen within 150 mm of where it was left; "
            "look again or feed it again",
        )


def look_from_aside(station: Station, end: End) -> Steps[bool]:
    """Look with the wrist camera for a loose end that other wires hide from above, and note it.

    A wire in the air hides different places from each side.

    Returns:
        Whether the end is seen now.
    """
    expected = station.book.expected[end]
    for tool in _views_around(station, expected, math.pi / 2)[1:]:
        if (yield from _look_for(station, tool, end, expected, GRASP_DISTANCE_M)) is not None:
            return True
    return False


def _look_close(station: Station, end: End, distance: float) -> Steps[GraspSighting]:
    """Look at an end from straight above it, or from aside where another wire hides it."""
    coarse = station.book.tips[end]
    out = np.array([math.cos(coarse.out_yaw), math.sin(coarse.out_yaw)])
    middle = coarse.tip[:2] - out * distance / 2
    for tool in _views_around(station, middle, coarse.out_yaw):
        seen = yield from _look_for(station, tool, end, coarse.tip[:2], distance)
        if seen is not None:
            return seen
    del station.book.tips[end]
    raise AbilityError(
        Code.TIP_NOT_FOUND,
        f"end {end.value} of {station.wire.id!r} is not seen from the hand; look again",
    )


def _views_around(
    station: Station, point: Array, yaw: float, beside: Sequence[tuple[float, float]] = ASIDE_M
) -> list[ToolPose]:
    """Return tool poses that bring the wrist camera over a point (2,) [m], and beside it."""
    tools = [camera_above(station, point + aside, yaw) for aside in ((0.0, 0.0), *beside)]
    return [tools[0], *(tool for tool in tools[1:] if station.arm.reaches(tool))]


def _look_for(
    station: Station, tool: ToolPose, end: End, expected: Array, distance: float
) -> Steps[GraspSighting | None]:
    """Look from a tool pose of the empty hand; return where to grasp an end if it is seen."""
    wire = station.wire
    picture = yield from go_and_see(station, tool)
    try:
        ends, likelihood = find_ends(picture, wire, {end: expected})
    except AbilityError:
        station.book.tips.pop(end, None)
        raise
    drawing = Drawing(picture.rgb, picture.view)
    if end not in ends:
        drawing.title(f"End {end.value} of {wire.id} not seen")
        station.show("wrist", picture, drawing.image)
        return None
    sighting = ends[end]
    z = float(sighting.tip.tip[2])
    pixels = trace_from(sighting, picture, likelihood, wire)
    line = picture.view.on_plane(pixels, z)
    point, tangent = at_distance(line[:, :2], distance)
    drawing.path(pixels[: _count_within(line, TRACE_M)])
    mark_end(drawing, sighting, f"{wire.id} end {end.value}")
    grasp = np.array([*point, z])
    drawing.circle(picture.view.project(grasp)[0], 9, ORANGE)
    drawing.note("grasp", picture.view.project(grasp)[0], ORANGE)
    drawing.title(f"End {end.value} of {wire.id} from the hand")
    station.show("wrist", picture, drawing.image)
    station.book.tips[end] = sighting.tip
    return GraspSighting(grasp, math.atan2(-tangent[1], -tangent[0]), sighting.tip)


def _count_within(line: Array, length: float) -> int:
    along = np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))
    return int(np.searchsorted(along, length)) + 2


def mark_end(drawing: Drawing, sighting: EndSighting, text: str) -> None:
    """Draw an arrow along the ferrule, and a note."""
    ferrule = sighting.ferrule
    reach = ferrule.out * max(ferrule.length, 18.0)
    drawing.arrow(ferrule.centre - reach * 0.8, ferrule.centre + reach * 1.2, BLUE)
    drawing.note(text, ferrule.centre + reach, BLUE)


def camera_above(station: Station, point: Array, yaw: float) -> ToolPose:
    """Return the tool pose that brings the wrist camera over a point (2,) [m].

    Args:
        station: of the robot that looks; one with room beside other robots is rather taken.
        point: to be seen in the middle of the picture, world frame.
        yaw: direction of the hand's x axis that is wished for [rad]; turned by pi, or square to
            it, if need be.
    """
    arm, near_yaw = station.arm, station.commanded.yaw
    reached = []
    for turn in (0.0, math.pi / 2):
        near = nearest_hand_yaw(arm, float(point[0]), float(point[1]), yaw + turn, near_yaw)
        for candidate in (near, near + math.pi):
            x, y = point - _camera_offset(candidate)
            tool = ToolPose(float(x), float(y), LOOK_Z, candidate)
            if arm.reaches(tool):
                reached.append(tool)
    if reached:
        return min(reached, key=lambda tool: not station.has_room(tool))
    x, y = point - _camera_offset(yaw)
    return ToolPose(float(x), float(y), LOOK_Z, yaw)


def _camera_offset(yaw: float) -> Array:
    """Return the lens's place from the tool axis for a hand yaw, (2,) [m].

    The hand's y axis points to its right.
    """
    x, y, _ = CAMERA_MOUNT
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([x * c + y * s, x * s - y * c])


def label_views(station: Station, label: Array, socket_yaw: float | None) -> list[ToolPose]:
    """Return tool poses from which the wrist camera should see a label, the nearest first.

    Several, since a wire in the air may hide the label from one of them. The empty hand goes
    straight over it, or beside it. With a wire in the hand the tool moves as little as it can and
    turns only the way it will turn to the socket: the wire may be fixed at its other end, and one
    that is bent away from where it goes twists out of the fingers.

    Args:
        station: the cell.
        label: its corners, (4, 3) [m], world frame.
        socket_yaw: direction of the bore that a held end goes into [rad], world frame; None if that
            is not known.

    Raises:
        AbilityError: UNREACHABLE when no posture sees it.
    """
    grip, now = station.book.grip, station.commanded
    if grip is None:
        return _views_around(station, label.mean(axis=0)[:2], 0.0, LABEL_ASIDE_M)
    turns = EITHER_WAY
    if socket_yaw is not None:
        turns = np.linspace(0.0, wrap_angle(socket_yaw - grip.flip - now.yaw), 5)
    views: list[ToolPose] = []
    for tool in _held_looks(station, label, turns):
        if all(_lenses_apart(tool, view) >= VIEWS_APART_M for view in views):
            views.append(tool)
        if len(views) == MAX_VIEWS:
            break
    if not views:
        raise AbilityError(
            Code.UNREACHABLE,
            f"from {now} no motion of up to 160 mm brings the label into the wrist camera's view; "
            "route the wire nearer to the component first",
        )
    return views


def go_and_see(station: Station, tool: ToolPose) -> Steps[Picture]:
    """Bring the hand to a tool pose high up, and take a picture with the wrist camera."""
    if station.book.grip is None:
        yield from clear_hand(station)
        yield from swing_to(station, tool)
    else:
        yield from move_to(station, station.commanded.at(z=tool.z), APPROACH_SPEED)
        yield from move_to(station, tool, CARRY_SPEED)
    yield from wait(station, STILL_S)
    picture = station.look_wrist()
    yield
    return picture


def _held_looks(station: Station, label: Array, turns: Array) -> list[ToolPose]:
    """Return the tool poses near the hand's that bring a label into view, the nearest first."""
    now, view = station.commanded, station.wrist_view
    looks: list[tuple[float, ToolPose]] = []
    for turn in turns:
        for dx in np.arange(-0.06, 0.061, 0.02):
            for dy in np.arange(-0.16, 0.161, 0.02):
                yaw = station.arm.canonical_yaw(now.x + dx, now.y + dy, now.yaw + turn)
                tool = ToolPose(now.x + dx, now.y + dy, TRAVEL_Z, now.yaw + turn)
                if yaw is None or abs(yaw - tool.yaw) > 1e-6 or not station.arm.reaches(tool):
                    continue
                if _view_from(tool, view).sees(label, BORDER_PX):
                    looks.append((math.hypot(dx, dy) + 0.08 * abs(turn), tool))
    return [tool for _, tool in sorted(looks, key=lambda look: look[0])]


def _lenses_apart(first: ToolPose, second: ToolPose) -> float:
    places = [np.array([tool.x, tool.y]) + _camera_offset(tool.yaw) for tool in (first, second)]
    return float(np.linalg.norm(places[0] - places[1]))


def _view_from(tool: ToolPose, view: View) -> View:
    """Return the wrist camera's view as it will be from another tool pose."""
    offset = _camera_offset(tool.yaw)
    c, s = math.cos(tool.yaw / 2), math.sin(tool.yaw / 2)
    # A hand that points down: half a turn about x, then its yaw.
    down = np.array([c, s, 0.0, 0.0])
    position = np.array([tool.x + offset[0], tool.y + offset[1], tool.z + TOOL_M - CAMERA_MOUNT[2]])
    return View(view.lens, Pose(position, down))
