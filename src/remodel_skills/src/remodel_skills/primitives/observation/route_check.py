"""Check from above whether a wire lies in its clips and ducts, as steps of an ability."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from remodel_skills.parameters import LookingParameters
from remodel_skills.primitives.motions import park
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.drawing import BLUE, ORANGE, Drawing
from remodel_vision.laid_wire import Passing, wire_past
from remodel_vision.wire_lines import WireLines
from remodel_work.camera import Picture
from remodel_work.errors import AbilityError
from remodel_work.fixtures import SLOPE_LENGTH_M
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Duct, Panel, PanelClip
from remodel_work.routes import places_in, world_from_clip


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


def check_ducts(context: RobotContext, path: tuple[Pose, ...]) -> Steps[None]:
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
