"""Inspect ducts with the camera of an empty hand, as steps of an ability.

The overhead camera sees a duct's floor only where the duct stands below it, and not where a hand
holds the rest of the wire; a hand looks down into each part of a duct from straight above.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from remodel_sim.abilities.execution.robot_context import RobotContext, Steps
from remodel_sim.abilities.primitives.motions import past_robots, swing_to, wait
from remodel_sim.abilities.primitives.observation.observing import STILL_S
from remodel_sim.abilities.primitives.observation.route_check import observe_route
from remodel_sim.abilities.primitives.observation.viewpoints import camera_above
from remodel_sim.core.camera import Picture
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Array, Pose
from remodel_sim.core.robot.arm import ToolPose
from remodel_sim.core.vision.board.outside_ducts import (
    length_beside_ducts,
    length_outside_ducts,
)
from remodel_sim.core.vision.drawing import BLUE, ORANGE, Drawing
from remodel_sim.core.vision.laid_wire import are_new, is_new, stood_at, surface_at, wire_past
from remodel_sim.core.vision.wire_lines import WireLines
from remodel_sim.core.workpiece.layout import WORLD_FROM_PANEL
from remodel_sim.core.workpiece.panel import Duct, PanelWire
from remodel_sim.core.workpiece.routes import places_in, step_in
from remodel_states.core.codes import Code

# So many neighbouring places of a duct are inspected from above their middle, with the tool so high
# [m]; where another robot is in the way, from so far along the duct.
IN_A_VIEW = 6
INSPECT_Z = 0.25
ALONG_M = (0.0, 0.06, -0.06, 0.12, -0.12)
# The wire itself must be seen at this share of the places, and where others lie in the same duct at
# as many times less as there are wires: they may lie over it.
LEAST_SEEN = 0.15
# What stands so far above a rim is a wire that does not lie in its duct; what is higher than the
# second hangs between two hands, and hides what is below [m].
ABOVE_M = 0.003
OVERHEAD_M = 0.060
# So far beyond a duct's walls a wire may lie on them, or over them [m].
BEYOND_M = 0.020
# What is so near to a wall may be the wall [m].
WALL_M = 0.004
# A duct is looked into at points that are so far apart [m].
POINTS_M = 0.002
# So much of a wire may lie on the plate beside its ducts, but for its way to its terminals [m].
MOST_BESIDE_M = 0.030
# A wire must lie below the rims at so much of its route in ducts.
LEAST_IN_DUCTS = 0.8


@dataclass(frozen=True)
class Inspected:
    """What the camera shows of a place in a duct.

    Attributes:
        is_seen: whether the wire is.
        is_below: whether it lies below the rim there; None: unknown.
    """

    is_seen: bool
    is_below: bool | None


def share_in_ducts(
    context: RobotContext, places: Mapping[Duct, Sequence[Pose]], before: Picture
) -> Steps[float]:
    """Inspect ducts; return at which share of the observed places the wire lies below the rim.

    It does where nothing new stands above the rim, also where other wires hide it.

    Args:
        context: of a robot with an empty hand, whose camera measures depth.
        places: frames in each duct, x along it, world frame.
        before: with depth, of the board from above before the wire was laid.

    Raises:
        AbilityError: CABLE_OCCLUDED when the wire is visible in too few places.
    """
    found: list[Inspected] = []
    for duct, part in _parts(places):
        for tool in _inspecting(context, part):
            try:
                yield from swing_to(context, tool)
            except AbilityError as error:
                if error.code not in (Code.UNREACHABLE, Code.ROBOT_IN_THE_WAY):
                    raise
                continue
            break
        else:
            found += [Inspected(is_seen=False, is_below=None)] * len(part)
            continue
        yield from wait(context, STILL_S)
        found += _inspect(context, duct, part, before)
        yield
    seen = sum(each.is_seen for each in found) / max(1, len(found))
    needed = _least_seen(context, places)
    if seen < needed:
        raise AbilityError(
            Code.CABLE_OCCLUDED,
            f"{context.wire.id!r} is in view at {seen:.0%} of its route in ducts; needed: "
            f"{needed:.1%} or more; draw it out and place it again",
        )
    judged = [each.is_below for each in found if each.is_below is not None]
    return sum(judged) / len(judged)


def check_beside_ducts(
    context: RobotContext, before: Picture, ways: Sequence[Array]
) -> Steps[None]:
    """Check that a wire was laid nowhere on the plate but in its ducts.

    In full ducts others that it moved may be taken for it; beside them there are none.

    Args:
        context: of any robot; an overhead camera that measures depth.
        before: with depth, of the board from above before the wire was laid.
        ways: lines (2, 3) along which it may be outside its ducts, world frame [m].

    Raises:
        AbilityError: OUT_OF_DUCT.
    """
    picture = context.take_overhead_picture()
    yield
    wire = context.wire
    beside = length_beside_ducts(picture, before, context.panel, wire.radius, ways)
    if beside > MOST_BESIDE_M:
        raise AbilityError(
            Code.OUT_OF_DUCT,
            f"{wire.id!r} lies beside its ducts, on {beside * 1e3:.0f} mm of the plate; allowed: "
            f"{MOST_BESIDE_M * 1e3:.0f} mm; draw it out and place it again",
        )


def check_ducts(context: RobotContext) -> Steps[float | None]:
    """Return at which share of its route a wire that is fixed at both ends lies in its ducts.

    What it is longer than its route goes back into the ducts while its second end is inserted, and
    may lift it out of them.

    Returns:
        None, when there are no ducts, or no pictures with depth from before and after.

    Raises:
        AbilityError: OUT_OF_DUCT.
    """
    wire, before = context.wire, next(iter(context.belief.untouched), None)
    ducts = [d for d in context.panel.ducts if d.id in wire.ducts and not d.is_fork]
    route = [WORLD_FROM_PANEL.apply(np.array(point)) for point in wire.route]
    path = tuple(Pose.level(*(float(v) for v in point), 0.0) for point in route)
    planned = sum(len(places_in(duct, path)) * step_in(duct) for duct in ducts)
    if not planned or before is None or before.depth is None:
        return None
    context.report("inspecting the ducts from above", 0.95)
    seen = yield from observe_route(context)
    ways = [np.array(route[:2]), np.array(route[-2:])]
    outside = length_outside_ducts(seen.picture, before, ducts, wire.radius, ways)
    share = max(0.0, 1.0 - outside / planned)
    drawing = Drawing(seen.picture.rgb, seen.picture.view)
    drawing.title(f"{wire.id}: outside its ducts at {outside * 1e3:.0f} mm")
    context.show("overhead", seen.picture, drawing.image)
    if share < LEAST_IN_DUCTS:
        raise AbilityError(
            Code.OUT_OF_DUCT,
            f"{wire.id!r} lies in its ducts at {share:.1%} of its route; allowed: "
            f"{LEAST_IN_DUCTS:.0%} or more; draw it out and place it again",
            in_ducts=share,
        )
    return share


def _least_seen(context: RobotContext, places: Mapping[Duct, Sequence[Pose]]) -> float:
    """Return at which share of the places the wire must be in view."""
    laid = [context.panel.wire(name) for name in context.belief.fed if name != context.wire.id]
    shares = [
        LEAST_SEEN / (1 + sum(duct.id in wire.ducts for wire in laid))
        for duct, at in places.items()
        for _ in at
    ]
    return sum(shares) / max(1, len(shares))


def _parts(places: Mapping[Duct, Sequence[Pose]]) -> Iterator[tuple[Duct, Sequence[Pose]]]:
    for duct, at in places.items():
        for first in range(0, len(at), IN_A_VIEW):
            yield duct, at[first : first + IN_A_VIEW]


def _inspecting(context: RobotContext, part: Sequence[Pose]) -> Iterator[ToolPose]:
    """Yield tool poses from which the hand's camera looks down on a part of a duct."""
    middle = np.mean([place.position for place in part], axis=0)
    along = part[0].rotation[:, 0]
    for away in ALONG_M:
        tool = camera_above(context, (middle + away * along)[:2], part[0].yaw, INSPECT_Z)
        if context.arm.reaches(tool) and past_robots(context, tool):
            yield tool


def _inspect(
    context: RobotContext, duct: Duct, part: Sequence[Pose], before: Picture
) -> list[Inspected]:
    """Inspect places of a duct in view of the hand's camera.

    Beyond a duct's walls the wire is not searched for: devices may have its colour.
    """
    picture = context.take_wrist_picture()
    heights = tuple({float(place.position[2]) for place in part})
    lines = WireLines(picture, context.wire, heights)
    found = []
    for place in part:
        passing = wire_past(place, duct.width / 2, lines)
        if passing is not None and not is_new(passing, place, before, context.wire.radius):
            passing = None
        is_below = _nothing_new_above(duct, place, picture, before, context.wire.radius)
        if passing is not None and is_below is None:
            is_below = passing.height < duct.height
        is_seen = passing is not None or _is_new_inside(duct, place, picture, before, context.wire)
        found.append(Inspected(is_seen, is_below))
    drawing = Drawing(picture.rgb, picture.view)
    for place, each in zip(part, found, strict=True):
        colour = BLUE if each.is_below else ORANGE
        drawing.circle(picture.view.project(place.position)[0], 6, colour)
    below = sum(each.is_below is True for each in found)
    drawing.title(f"{context.wire.id}: below the rim of {duct.id!r} at {below} places")
    context.show("wrist", picture, drawing.image)
    return found


def _is_new_inside(
    duct: Duct, place: Pose, picture: Picture, before: Picture, wire: PanelWire
) -> bool:
    """Return whether a wire was laid across a place, between the walls of a duct.

    In a bundle of wires of one colour none is seen as a line.
    """
    half = duct.width / 2 - WALL_M
    across = np.arange(-half, half, POINTS_M)
    points = place.apply(np.column_stack([np.zeros_like(across), across, np.zeros_like(across)]))
    surface = surface_at(picture, points)
    new = are_new(surface, before, wire.radius)
    width = max(2, math.floor(wire.diameter / POINTS_M))
    return bool(np.any(np.convolve(new, np.ones(width), "valid") == width))


def _nothing_new_above(
    duct: Duct, place: Pose, picture: Picture, before: Picture, radius: float
) -> bool | None:
    """Return whether no wire of a radius [m] was laid above the rim across a place.

    What stood there before does not count; None: something hides what is there, or was.
    """
    half = duct.width / 2 + BEYOND_M
    across = np.arange(-half, half, POINTS_M)
    rim = np.full_like(across, duct.height - float(place.position[2]))
    points = place.apply(np.column_stack([np.zeros_like(across), across, rim]))
    surface = surface_at(picture, points)
    if (surface[:, 2] > duct.height + OVERHEAD_M).any():
        return None
    above = surface[surface[:, 2] > duct.height + ABOVE_M]
    if not len(above):
        return True
    if are_new(above, before, radius / 2).any():
        return False
    return None if (stood_at(above, before) > duct.height + OVERHEAD_M).any() else True
