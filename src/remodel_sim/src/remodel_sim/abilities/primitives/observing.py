"""Looks at labels and at wire ends, as steps of an ability."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from remodel_sim.abilities.execution.robot_context import Station, Steps
from remodel_sim.abilities.primitives.motions import (
    APPROACH_SPEED,
    CARRY_SPEED,
    clear_hand,
    move_to,
    park,
    swing_to,
    wait,
)
from remodel_sim.abilities.primitives.viewpoints import views_around
from remodel_sim.core.belief.belief_state import EndState, TipSighting
from remodel_sim.core.camera import Picture
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Array
from remodel_sim.core.robot.arm import ToolPose
from remodel_sim.core.vision.drawing import BLUE, ORANGE, Drawing
from remodel_sim.core.vision.tracing import at_distance
from remodel_sim.core.vision.wire_ends import EndSighting, find_ends, trace_from
from remodel_sim.core.workpiece.layout import GRASP_DISTANCE_M
from remodel_sim.core.workpiece.panel import End
from remodel_states.core.codes import Code

# The arm rings down before a picture is taken [s].
STILL_S = 0.10
# A wire is traced so far behind its tip to find the grasp [m].
TRACE_M = 0.075


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
        line: the wire from the tip on, as far as it is seen, (n, 3) [m], world frame.
    """

    point: Array
    tip_yaw: float
    tip: TipSighting
    line: Array


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
    if end not in above.ends and (yield from look_from_aside(station, end)) is None:
        raise AbilityError(
            Code.TIP_NOT_FOUND,
            f"end {end.value} of {wire_id!r} is not seen within 150 mm of where it was left; "
            "look again or feed it again",
        )


def look_from_aside(station: Station, end: End, view: int = 0) -> Steps[GraspSighting | None]:
    """Look with the wrist camera for a loose end that other wires hide from above, and note it.

    A wire in the air hides different places from each side, and from each view.

    Returns:
        What is seen of the end; None when it is not seen.
    """
    expected = station.book.expected[end]
    tools = views_around(station, expected, math.pi / 2, view=view)
    for tool in tools if view else tools[1:]:
        seen = yield from _look_for(station, tool, end, expected, GRASP_DISTANCE_M)
        if seen is not None:
            return seen
    return None


def _look_close(station: Station, end: End, distance: float) -> Steps[GraspSighting]:
    """Look at an end from straight above it, or from aside where another wire hides it."""
    coarse = station.book.tips[end]
    out = np.array([math.cos(coarse.out_yaw), math.sin(coarse.out_yaw)])
    middle = coarse.tip[:2] - out * distance / 2
    for tool in views_around(station, middle, coarse.out_yaw):
        seen = yield from _look_for(station, tool, end, coarse.tip[:2], distance)
        if seen is not None:
            return seen
    del station.book.tips[end]
    raise AbilityError(
        Code.TIP_NOT_FOUND,
        f"end {end.value} of {station.wire.id!r} is not seen from the hand; look again",
    )


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
    return GraspSighting(grasp, math.atan2(-tangent[1], -tangent[0]), sighting.tip, line)


def _count_within(line: Array, length: float) -> int:
    along = np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))
    return int(np.searchsorted(along, length)) + 2


def mark_end(drawing: Drawing, sighting: EndSighting, text: str) -> None:
    """Draw an arrow along the ferrule, and a note."""
    ferrule = sighting.ferrule
    reach = ferrule.out * max(ferrule.length, 18.0)
    drawing.arrow(ferrule.centre - reach * 0.8, ferrule.centre + reach * 1.2, BLUE)
    drawing.note(text, ferrule.centre + reach, BLUE)


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
