"""Inspect ducts from above, by depth pictures, as steps of an ability."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remodel_skills.parameters import FixtureParameters
from remodel_skills.primitives.observation.route_check import observe_places
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.board.outside_ducts import route_outside_ducts
from remodel_vision.drawing import Drawing
from remodel_vision.wire_lines import WireLines
from remodel_work.camera import Picture, best_view
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Duct
from remodel_work.routes import places_in, step_in


@dataclass(frozen=True, eq=False)
class Inspection:
    """How a wire that is fixed at both ends lies in its ducts, seen from above.

    Attributes:
        outside_m: along how much of its route in ducts it lies outside them [m].
        length_m: of that route [m].
        wire_id: of the wire.
        seen: the pictures, with depth, each beside the one before the wire was laid.
        route: where the wire's route turns, from opening to opening, (3,) each [m], world frame.
        places: in its ducts, x along them, world frame.
    """

    outside_m: float
    length_m: float
    wire_id: str
    seen: tuple[tuple[WireLines, Picture], ...]
    route: list[Array]
    places: dict[Duct, tuple[Pose, ...]]

    @property
    def share(self) -> float:
        """The share of its route in ducts at which it lies in them."""
        return max(0.0, 1.0 - self.outside_m / self.length_m)

    def seen_at(self, point: Array) -> tuple[WireLines, Picture]:
        """Return the picture that shows a point (3,) [m] best, and the one from before."""
        views = [lines.picture.view for lines, _ in self.seen]
        return self.seen[best_view(views, point[None])]

    def most_outside_m(self, fixture: FixtureParameters) -> float:
        """Return along how much of its route it may lie outside [m].

        A share of a long route; on a short one, what the walls force out of the ducts, but no
        more than would leave a part of it in them: slack bulges out through the far wall.
        """
        long_m = (1.0 - fixture.duct_least_share) * self.length_m
        short_m = (1.0 - fixture.duct_short_share) * self.length_m
        return max(long_m, min(fixture.duct_walls_m, short_m))


def inspect_ducts(context: RobotContext) -> Steps[Inspection | None]:
    """Observe how a wire lies in its ducts, once both its ends are fixed.

    Returns:
        None, when there are no ducts, or no pictures with depth from before and after.
    """
    wire, belief = context.wire, context.belief
    ducts = [d for d in context.panel.ducts if d.id in wire.ducts and not d.is_fork]
    route = [context.panel.world_from_panel.apply(np.array(point)) for point in wire.route]
    path = tuple(Pose.level(*(float(v) for v in point)) for point in route)
    places = {duct: places_in(duct, path, context.panel) for duct in ducts}
    planned = sum(len(places[duct]) * step_in(duct) for duct in ducts)
    if not planned or not belief.untouched or belief.untouched[0].depth is None:
        return None
    context.report("inspecting the ducts from above", 0.95)
    at = np.array([place.position for found in places.values() for place in found])
    pairs = [
        (picture, before)
        for picture in (yield from observe_places(context, at))
        if (before := belief.board_before(picture.view)) is not None
    ]
    if not pairs:
        return None
    ways = [np.array(route[:2]), np.array(route[-2:])]
    outside = route_outside_ducts(pairs, context.panel, places, wire.radius, ways)
    for picture, _ in pairs:
        drawing = Drawing(picture.rgb, picture.view)
        drawing.title(f"{wire.id}: outside its ducts at {outside * 1e3:.0f} mm")
        context.cameras.show("overhead", picture, drawing.image)
    seen = tuple((WireLines(picture, wire), before) for picture, before in pairs)
    return Inspection(outside, planned, wire.id, seen, route, places)


def check_ducts(found: Inspection, fixture: FixtureParameters) -> None:
    """Raise OUT_OF_DUCT if a wire lies outside its ducts along more of its route than it may."""
    most_m = found.most_outside_m(fixture)
    if found.outside_m > most_m:
        raise AbilityError(
            Code.OUT_OF_DUCT,
            f"{found.wire_id!r} lies outside its ducts along {found.outside_m * 1e3:.0f} of "
            f"{found.length_m * 1e3:.0f} mm of its route; allowed: {most_m * 1e3:.0f} mm; draw it "
            "out and place it again",
            in_ducts=found.share,
        )
