"""Observe wire ends from above and from the hand, as steps of an ability."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from remodel_skills.belief_state import EndState
from remodel_skills.primitives.motions import clear_hand, move_to, park, swing_to, wait
from remodel_skills.primitives.observation.views import views_around
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.cables.lines import arc_lengths, at_distance
from remodel_vision.colour import BLUE, ORANGE, Drawing
from remodel_vision.laid_wire import WireLines
from remodel_vision.wire_ends import EndObservation, TipObservation, find_ends, line_from
from remodel_work.camera import Picture
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array
from remodel_work.layout import GRASP_DISTANCE_M
from remodel_work.panel import WireEnd
from remodel_work.robot.arm import ToolPose


@dataclass(frozen=True, eq=False)
class OverheadObservation:
    """The live wire from above.

    Attributes:
        ends: the loose ends that are seen.
        picture: what the camera saw.
        lines: of the wire.
    """

    ends: dict[WireEnd, EndObservation]
    picture: Picture
    lines: WireLines


def loose_ends(context: RobotContext) -> list[WireEnd]:
    """Return the ends of the live wire that are neither in a terminal nor in a hand."""
    belief = context.belief
    held = {grip.end for grip in belief.hands.values()}
    return [e for e, state in belief.ends.items() if state is EndState.LOOSE and e not in held]


def observe_from_above(context: RobotContext) -> Steps[OverheadObservation]:
    """Observe the plate from above, the empty hand aside, and note the visible loose ends."""
    if context.belief.grip is None:
        yield from park(context)
    belief = context.belief
    expected = {end: belief.expected[end] for end in loose_ends(context)}
    places = list(expected.values()) or [context.panel.world_from_panel.position]
    picture = context.cameras.take_overhead_picture(np.array(places))
    yield
    ends, lines = find_ends(picture, context.wire, expected)
    for end, observation in ends.items():
        belief.tips[end] = observation.tip
    yield
    return OverheadObservation(ends, picture, lines)


@dataclass(frozen=True, eq=False)
class GraspObservation:
    """Where to grasp an end, by the wrist camera.

    Attributes:
        point: on the wire's axis, (3,) [m], world frame.
        tip_yaw: direction of the wire towards the tip, at that point [rad].
        tip: the end's apex.
        line: the wire from the tip on, as far as it is seen, (n, 3) [m], world frame.
    """

    point: Array
    tip_yaw: float
    tip: TipObservation
    line: Array


def observe_end(context: RobotContext, end: WireEnd, distance: float) -> Steps[GraspObservation]:
    """Find where to grasp a loose end: from above if it is not known, then from close by.

    Args:
        context: the cell.
        end: a loose end of the live wire.
        distance: from the tip to the grasp, along the wire [m].

    Raises:
        AbilityError: TIP_NOT_FOUND and the other codes of find_ends.
    """
    remembered = end in context.belief.tips
    if not remembered:
        yield from _find_from_above(context, end)
    try:
        return (yield from _observe_closely(context, end, distance))
    except AbilityError as error:
        if not remembered or error.code is not Code.TIP_NOT_FOUND:
            raise
    yield from _find_from_above(context, end)
    return (yield from _observe_closely(context, end, distance))


def _find_from_above(context: RobotContext, end: WireEnd) -> Steps[None]:
    above = yield from observe_from_above(context)
    wire_id = context.wire.id
    drawing = Drawing(above.picture.rgb, above.picture.view)
    for seen, observation in above.ends.items():
        mark_end(drawing, observation, f"{wire_id} end {seen.value}")
    drawing.title(f"Searching for end {end.value} of {wire_id}")
    context.cameras.show("overhead", above.picture, drawing.image)
    if end not in above.ends and (yield from observe_from_aside(context, end)) is None:
        raise AbilityError(
            Code.TIP_NOT_FOUND,
            f"end {end.value} of {wire_id!r} is not seen within 150 mm of where it was left; "
            "detect it again or feed it again",
        )


def observe_held_tip(context: RobotContext, expected: Array) -> Steps[TipObservation | None]:
    """Observe the tip of the held end from above; return None when the camera does not see it.

    Args:
        context: its hand holds the end.
        expected: where the tip is, (3,) [m], world frame, if it has not turned in the grip.
    """
    looking = context.parameters.looking
    grip = context.belief.grip
    assert grip is not None, "the hand holds the end"
    yield from wait(context, context.parameters.motion.still_s)
    picture = context.cameras.take_overhead_picture(expected[None])
    yield
    try:
        ends, _ = find_ends(picture, context.wire, {grip.end: expected})
    except AbilityError:
        return None
    seen = ends.get(grip.end)
    if seen is None:
        return None
    x, y, z = np.abs(seen.tip.tip - expected)
    if math.hypot(x, y) > looking.held_tip_m or z > looking.held_tip_height_m:
        return None
    drawing = Drawing(picture.rgb, picture.view)
    mark_end(drawing, seen, f"{context.wire.id} end {grip.end.value}")
    drawing.title(f"End {grip.end.value} of {context.wire.id} in the hand")
    context.cameras.show("overhead", picture, drawing.image)
    return seen.tip


def observe_from_aside(
    context: RobotContext, end: WireEnd, view: int = 0
) -> Steps[GraspObservation | None]:
    """Search with the wrist camera for a loose end that other wires hide from above, and note it.

    A wire in the air hides different places from each side, and from each view.

    Returns:
        What is seen of the end; None when it is not seen.
    """
    expected = context.belief.expected[end]
    tools = views_around(context, expected[:2], math.pi / 2, view=view)
    for tool in tools if view else tools[1:]:
        seen = yield from _search(context, tool, end, expected, distance=GRASP_DISTANCE_M)
        if seen is not None:
            return seen
    return None


def _observe_closely(
    context: RobotContext, end: WireEnd, distance: float
) -> Steps[GraspObservation]:
    """Observe an end from straight above it, or from aside where another wire hides it."""
    coarse = context.belief.tips[end]
    out = np.array([math.cos(coarse.out_yaw), math.sin(coarse.out_yaw)])
    middle = coarse.tip[:2] - out * distance / 2
    for tool in views_around(context, middle, coarse.out_yaw):
        seen = yield from _search(
            context, tool, end, coarse.tip, distance=distance, pitch=coarse.pitch
        )
        if seen is not None:
            return seen
    del context.belief.tips[end]
    raise AbilityError(
        Code.TIP_NOT_FOUND,
        f"end {end.value} of {context.wire.id!r} is not visible from the hand; detect it again",
    )


def _search(
    context: RobotContext,
    tool: ToolPose,
    end: WireEnd,
    expected: Array,
    distance: float,
    pitch: float = 0.0,
) -> Steps[GraspObservation | None]:
    """Observe from a tool pose of the empty hand; return where to grasp an end if it is visible.

    The hand's camera does not see heights: that of the tip is the expected one, and the wire rises
    towards it by `pitch` [rad].
    """
    wire = context.wire
    picture = yield from go_and_see(context, tool)
    try:
        ends, lines = find_ends(picture, wire, {end: expected})
    except AbilityError:
        context.belief.tips.pop(end, None)
        raise
    drawing = Drawing(picture.rgb, picture.view)
    observation = ends.get(end)
    if observation is None or _is_other_end(context, end, observation):
        drawing.title(f"End {end.value} of {wire.id} not seen")
        context.cameras.show("wrist", picture, drawing.image)
        return None
    z = float(observation.tip.tip[2])
    pixels = line_from(observation, lines)
    line = picture.view.on_plane(pixels, z)
    below = math.tan(pitch) * arc_lengths(line[:, :2])
    line = picture.view.on_plane(pixels, z - below)
    point, out = _between_pads(context, line[:, :2], distance)
    drawing.path(pixels[: _count_within(line, context.parameters.looking.drawn_m)])
    mark_end(drawing, observation, f"{wire.id} end {end.value}")
    grasp = np.array([*point, z - math.tan(pitch) * distance])
    drawing.circle(picture.view.project(grasp)[0], 9, ORANGE)
    drawing.note("grasp", picture.view.project(grasp)[0], ORANGE)
    drawing.title(f"End {end.value} of {wire.id} from the hand")
    context.cameras.show("wrist", picture, drawing.image)
    tip = replace(observation.tip, pitch=pitch)
    context.belief.tips[end] = tip
    return GraspObservation(grasp, math.atan2(out[1], out[0]), tip, line)


def _is_other_end(context: RobotContext, end: WireEnd, observation: EndObservation) -> bool:
    """Return whether what was taken for an end lies where the other one was seen."""
    known = context.belief.tips.get(end.other)
    if known is None or end.other not in loose_ends(context):
        return False
    return (
        float(np.linalg.norm((observation.tip.tip - known.tip)[:2]))
        < context.parameters.looking.same_tip_m
    )


def _between_pads(context: RobotContext, line: Array, distance: float) -> tuple[Array, Array]:
    """Return the middle (2,) and the direction (2,) out of a wire between the pads [m]."""
    width = context.fingers.width
    offsets = np.linspace(-0.5, 0.5, context.parameters.looking.places_between_pads)
    places = np.array([at_distance(line, distance + offset * width)[0] for offset in offsets])
    # Least squares: the direction of the straight line through places in even steps.
    return places.mean(axis=0), -offsets @ places


def _count_within(line: Array, length: float) -> int:
    along = np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))
    return int(np.searchsorted(along, length)) + 2


def mark_end(drawing: Drawing, observation: EndObservation, text: str) -> None:
    """Draw an arrow along the ferrule, and a note."""
    ferrule = observation.ferrule
    reach = ferrule.out * max(ferrule.length, 18.0)
    drawing.arrow(ferrule.centre - reach * 0.8, ferrule.centre + reach * 1.2, BLUE)
    drawing.note(text, ferrule.centre + reach, BLUE)


def go_and_see(context: RobotContext, tool: ToolPose) -> Steps[Picture]:
    """Bring the hand to a tool pose high up, and take a picture with the wrist camera."""
    motion = context.parameters.motion
    if context.belief.grip is None:
        yield from clear_hand(context)
        yield from swing_to(context, tool)
    else:
        yield from move_to(context, context.commanded.at(z=tool.z), motion.approach_speed_m_s)
        yield from move_to(context, tool, motion.carry_speed_m_s)
    yield from wait(context, motion.still_s)
    picture = context.cameras.take_wrist_picture()
    yield
    return picture
