"""What is checked of a laid wire, from above: its route, its ducts, its forks, its first end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from remodel_skills.parameters import FixtureParameters, LookingParameters
from remodel_skills.primitives.motions import park
from remodel_skills.primitives.observation.views import ComponentViews
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.colour import BLUE, ORANGE, Drawing
from remodel_vision.laid_wire import Passing, WireLines, points_of_colour, wire_past
from remodel_vision.opening_occupancy import is_seen_empty
from remodel_vision.standing import route_outside_ducts
from remodel_work.camera import Picture, best_view
from remodel_work.errors import AbilityError
from remodel_work.fixtures import SLOPE_LENGTH_M, WALL_M
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Duct, Panel, PanelClip, WireEnd
from remodel_work.routes import places_in, step_in, world_from_clip


def observe_route(context: RobotContext, points: Array) -> Steps[WireLines]:
    """Observe points (n, 3) [m] from above, the empty hand out of the way."""
    if context.belief.grip is None:
        yield from park(context)
    return (yield from observe_board(context, points))


def observe_places(context: RobotContext, points: Array) -> Steps[tuple[Picture, ...]]:
    """Observe all of points (n, 3) [m] from above, by as many cameras as that needs."""
    if context.belief.grip is None:
        yield from park(context)
    pictures = context.cameras.take_overhead_pictures(points)
    yield
    return pictures


def observe_board(context: RobotContext, points: Array) -> Steps[WireLines]:
    """Observe points (n, 3) [m] from above, the hands where they are."""
    picture = context.cameras.take_overhead_picture(points)
    yield
    return WireLines(picture, context.wire)


def clip_fault(clip: PanelClip, seen: WireLines, panel: Panel, looking: LookingParameters) -> str:
    """Return what is wrong with the wire at a clip; empty: nothing."""
    passings = [
        wire_past(place, looking.clip_search_m, seen) for place in _beside(clip, panel, looking)
    ]
    found = [passing for passing in passings if passing is not None]
    if len(found) < len(passings):
        return f"it is not visible at clip {clip.id!r}"
    aside = max(abs(passing.aside) for passing in found)
    above = float(np.mean([passing.height for passing in found])) - clip.height
    if aside <= looking.clip_aside_m and abs(above) <= looking.clip_above_m:
        return ""
    return (
        f"at clip {clip.id!r} it lies {aside * 1e3:.1f} mm aside and {above * 1e3:+.1f} mm above "
        "where it belongs"
    )


def _beside(clip: PanelClip, panel: Panel, looking: LookingParameters) -> tuple[Pose, ...]:
    out = clip.length / 2 + SLOPE_LENGTH_M + looking.beside_clip_m
    place = world_from_clip(clip, panel)
    return tuple(place @ Pose.level(x, 0.0, clip.height) for x in (-out, out))


def judge_clips(context: RobotContext, clips: Sequence[PanelClip], seen: WireLines) -> None:
    """Show the clips, and raise OUT_OF_DUCT when the wire does not lie in all of them."""
    panel, looking = context.panel, context.parameters.looking
    faults = [fault for clip in clips if (fault := clip_fault(clip, seen, panel, looking))]
    places = [place for clip in clips for place in _beside(clip, panel, looking)]
    _show(context, seen, places, faults)
    if faults:
        raise _out(context, faults)


def check_path_in_ducts(context: RobotContext, path: tuple[Pose, ...]) -> Steps[None]:
    """Check whether the wire lies in the ducts in which a path runs.

    Forks do not count: a wire that is held moves in them until both its ends are fixed.

    Raises:
        AbilityError: OUT_OF_DUCT when it lies beside one, CABLE_OCCLUDED when it is not visible
            in any. Where other wires hide it, it lies below them: beside a duct there are none.
    """
    found = duct_places(context, path)
    places = {duct: at for duct, at in found.items() if not duct.is_fork}
    if not places:
        return
    context.report("observing the ducts from above", 0.95)
    at = np.array([place.position for found in places.values() for place in found])
    seen = yield from observe_route(context, at)
    beside_m = context.parameters.looking.duct_search_m
    passings = {duct: _passings(duct, at, seen, beside_m) for duct, at in places.items()}
    if not any(passings.values()):
        ducts = ", ".join(duct.id for duct in places)
        raise AbilityError(
            Code.CABLE_OCCLUDED,
            f"{seen.wire.id!r} is seen in none of the ducts {ducts}, nor within "
            f"{beside_m * 1e3:.0f} mm of one; observe it from another side",
        )
    faults = [f for duct, found in passings.items() if (f := _duct_fault(duct, found))]
    _show(context, seen, [place for at in places.values() for place in at], faults)
    if faults:
        raise _out(context, faults)


def duct_places(context: RobotContext, path: tuple[Pose, ...]) -> dict[Duct, tuple[Pose, ...]]:
    """Return where a path runs in ducts."""
    found = {duct: tuple(places_in(duct, path, context.panel)) for duct in context.panel.ducts}
    return {duct: places for duct, places in found.items() if places}


def _passings(
    duct: Duct, places: Sequence[Pose], seen: WireLines, beside_m: float
) -> list[Passing]:
    """Return how the wire passes a duct, or so far beside it, at the places where it is seen."""
    reach = duct.width / 2 + beside_m
    found = [wire_past(place, reach, seen) for place in places]
    return [passing for passing in found if passing is not None]


def _duct_fault(duct: Duct, passings: Sequence[Passing]) -> str:
    """Return how far beside a duct the wire lies; what is still held above it does not count."""
    down = [abs(passing.aside) for passing in passings if passing.height < duct.height]
    beside = max(down, default=0.0) - duct.width / 2
    return f"it lies {beside * 1e3:.0f} mm beside duct {duct.id!r}" if beside > 0 else ""


def _show(
    context: RobotContext, seen: WireLines, places: Sequence[Pose], faults: Sequence[str]
) -> None:
    drawing = Drawing(seen.picture.rgb, seen.picture.view)
    colour = ORANGE if faults else BLUE
    for place in places:
        drawing.circle(seen.picture.view.project(place.position)[0], 6, colour)
    drawing.title(f"{seen.wire.id}: {'; '.join(faults) or 'lies where it should'}")
    context.cameras.show("overhead", seen.picture, drawing.image)


def _out(context: RobotContext, faults: Sequence[str]) -> AbilityError:
    return AbilityError(
        Code.OUT_OF_DUCT,
        f"{context.wire.id!r} does not lie where it should: {'; '.join(faults)}; pick its end and "
        "route it again",
    )


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


@dataclass(frozen=True, eq=False)
class Section:
    """Where a wire is seen across a fork, before or behind its posts.

    Attributes:
        aside: of what is seen from the fork's middle, along its y, (n,) [m].
        height: of its surface above the plate, (n,) [m].
    """

    aside: Array
    height: Array


def check_forks(context: RobotContext) -> Steps[tuple[Duct, ...]]:
    """Return the forks of the wire, having checked that it lies in all of them.

    Raises:
        AbilityError: OUT_OF_DUCT when it passes beside one or above its posts, or when it is not
            visible.
    """
    wire = context.wire
    forks = tuple(duct for duct in context.panel.ducts if duct.is_fork and duct.id in wire.ducts)
    if not forks:
        return ()
    context.report("observing the forks from above", 0.95)
    looking = context.parameters.looking
    seen = yield from observe_route(context, _places(context, forks))
    sections = {fork: sections_of(fork, seen, context.panel, looking) for fork in forks}
    faults = {fork: _fault(fork, found, wire.radius) for fork, found in sections.items()}
    held = [fork for fork, fault in faults.items() if not fault]
    _show_forks(context, seen, faults)
    if not any(section.aside.size for found in sections.values() for section in found):
        raise _out_of_forks(f"{wire.id!r} is not visible near any of its {len(forks)} forks")
    if len(held) < len(forks):
        texts = "; ".join(fault for fault in faults.values() if fault)
        raise _out_of_forks(f"{wire.id!r} lies in {len(held)} of its {len(forks)} forks: {texts}")
    return forks


def _places(context: RobotContext, forks: Sequence[Duct]) -> Array:
    board = context.panel.world_from_panel
    return np.array([(board @ fork.panel_from_duct).position for fork in forks])


def sections_of(
    fork: Duct, seen: WireLines, panel: Panel, looking: LookingParameters
) -> tuple[Section, Section]:
    """Return where the wire is seen across a fork, before its posts and behind them."""
    place = panel.world_from_panel @ fork.panel_from_duct
    near, far = (fork.length / 2 + beyond for beyond in looking.beyond_posts_m)
    half = fork.width / 2 + looking.duct_search_m
    points = place.inverse().apply(points_of_colour(seen, place.position, half + far))
    x, y, z = points[np.abs(points[:, 1]) < half].T
    before, behind = ((near < side * x) & (side * x < far) for side in (-1, 1))
    radius = seen.wire.radius
    first, last = (_section(y[side], z[side], radius, looking) for side in (before, behind))
    return first, last


def _section(y: Array, z: Array, radius: float, looking: LookingParameters) -> Section:
    """Return what of points (n,) each [m] across a fork stands on the plate."""
    cells, cell_of = np.unique(np.floor(y / looking.across_fork_m), return_inverse=True)
    counts = np.bincount(cell_of, minlength=len(cells))
    heights = np.bincount(cell_of, z, minlength=len(cells)) / counts
    stands = (counts >= looking.least_points) & (heights > radius)
    return Section((cells[stands] + 0.5) * looking.across_fork_m, heights[stands])


def _fault(fork: Duct, sections: Sequence[Section], radius: float) -> str:
    """Return what is wrong with a wire of a radius [m] at a fork; empty: nothing."""
    above = max(float(part.height.max(initial=0.0)) for part in sections) - radius - fork.height
    if above > 0:
        return f"it passes {above * 1e3:.0f} mm above the posts of {fork.id!r}"
    for to in (-1, 1):
        # A wire that leaves a fork aslant is beside its posts before or behind them, not both.
        far = min(float((to * part.aside).max(initial=0.0)) for part in sections)
        beside = far - fork.width / 2
        if beside > WALL_M / 2:
            return f"it passes {beside * 1e3:.0f} mm beside {fork.id!r}"
    return ""


def _show_forks(context: RobotContext, seen: WireLines, faults: Mapping[Duct, str]) -> None:
    drawing = Drawing(seen.picture.rgb, seen.picture.view)
    for fork, fault in faults.items():
        middle = (context.panel.world_from_panel @ fork.panel_from_duct).position
        drawing.circle(seen.picture.view.project(middle)[0], 6, ORANGE if fault else BLUE)
    texts = "; ".join(fault for fault in faults.values() if fault)
    drawing.title(f"{seen.wire.id}: {texts or 'lies in its forks'}")
    context.cameras.show("overhead", seen.picture, drawing.image)


def _out_of_forks(found: str) -> AbilityError:
    return AbilityError(Code.OUT_OF_DUCT, f"{found}; draw it out and place it again")


def check_end(context: RobotContext, end: WireEnd) -> Steps[None]:
    """Check whether an end of the live wire is still where it was fixed, the hand where it is.

    Where the picture does not show the terminal's component and its opening, the end counts as
    being there.

    Raises:
        AbilityError: CAME_OUT; the end counts as loose from then on.
    """
    belief, wire = context.belief, context.wire
    ((component_id, terminal_id),) = [
        key for key, fixed in belief.occupied.items() if fixed == (wire.id, end)
    ]
    component = context.panel.component(component_id)
    drawn = context.panel.world_from_panel @ component.panel_from_component
    near = belief.seen.get(component_id, drawn)
    seen = yield from observe_board(context, near.position[None])
    found = ComponentViews(context, component).add(seen.picture, near)
    if found is None:
        return
    socket = found.world_from_component @ component.terminal(terminal_id).component_from_socket
    if not is_seen_empty(seen.picture, socket, wire):
        return
    where = f"'{component_id}/{terminal_id}'"
    drawing = Drawing(seen.picture.rgb, seen.picture.view)
    drawing.circle(seen.picture.view.project(socket.position)[0], 6, ORANGE)
    drawing.title(f"{wire.id}: end {end.value} is not in {where}")
    context.cameras.show("overhead", seen.picture, drawing.image)
    belief.loosen(end)
    raise AbilityError(
        Code.CAME_OUT,
        f"end {end.value} of {wire.id!r} was fixed in {where}, and nothing is seen there any more; "
        "discard the wire and place a new piece",
    )
