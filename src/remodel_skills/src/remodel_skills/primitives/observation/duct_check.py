"""Inspect ducts from above, by depth pictures, as steps of an ability."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remodel_skills.primitives.observation.route_check import observe_route
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.board.outside_ducts import route_outside_ducts
from remodel_vision.drawing import Drawing
from remodel_vision.wire_lines import WireLines
from remodel_work.camera import Picture
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Duct
from remodel_work.routes import places_in, step_in


@dataclass(frozen=True, eq=False)
class Inspection:
    """How a wire that is fixed at both ends lies in its ducts, seen from above.

    Attributes:
        share: of its route in ducts, at which it lies in them.
        seen: the picture, with depth.
        before: the same, before the wire was laid.
        route: where the wire's route turns, from opening to opening, (3,) each [m], world frame.
        places: in its ducts, x along them, world frame.
    """

    share: float
    seen: WireLines
    before: Picture
    route: list[Array]
    places: dict[Duct, tuple[Pose, ...]]


def inspect_ducts(context: RobotContext) -> Steps[Inspection | None]:
    """Observe how a wire lies in its ducts, once both its ends are fixed.

    Returns:
        None, when there are no ducts, or no pictures with depth from before and after.
    """
    wire, before = context.wire, context.belief.board_before
    ducts = [d for d in context.panel.ducts if d.id in wire.ducts and not d.is_fork]
    route = [context.panel.world_from_panel.apply(np.array(point)) for point in wire.route]
    path = tuple(Pose.level(*(float(v) for v in point)) for point in route)
    places = {duct: places_in(duct, path, context.panel) for duct in ducts}
    planned = sum(len(places[duct]) * step_in(duct) for duct in ducts)
    if not planned or before is None or before.depth is None:
        return None
    context.report("inspecting the ducts from above", 0.95)
    seen = yield from observe_route(context)
    ways = [np.array(route[:2]), np.array(route[-2:])]
    outside = route_outside_ducts(seen.picture, before, context.panel, places, wire.radius, ways)
    drawing = Drawing(seen.picture.rgb, seen.picture.view)
    drawing.title(f"{wire.id}: outside its ducts at {outside * 1e3:.0f} mm")
    context.cameras.show("overhead", seen.picture, drawing.image)
    return Inspection(max(0.0, 1.0 - outside / planned), seen, before, route, places)


def check_ducts(found: Inspection, least_share: float) -> None:
    """Raise OUT_OF_DUCT unless a wire lies in its ducts at such a share of its route."""
    if found.share < least_share:
        raise AbilityError(
            Code.OUT_OF_DUCT,
            f"{found.seen.wire.id!r} lies in its ducts at {found.share:.1%} of its route; allowed: "
            f"{least_share:.0%} or more; draw it out and place it again",
            in_ducts=found.share,
        )
