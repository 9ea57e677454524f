"""Check from above whether a wire lies in its forks, as steps of an ability.

Many wires cross between the posts of a fork, and hide each other there. Beside the posts there is
none: what stands there, or above their tops, and has the wire's colour, is the wire.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from remodel_skills.parameters import LookingParameters
from remodel_skills.primitives.observation.route_check import observe_route
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.drawing import BLUE, ORANGE, Drawing
from remodel_vision.laid_wire import points_of_colour
from remodel_vision.wire_lines import WireLines
from remodel_work.errors import AbilityError
from remodel_work.fixtures import WALL_M
from remodel_work.geometry import Array
from remodel_work.panel import Duct, Panel


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
    _show(context, seen, faults)
    if not any(section.aside.size for found in sections.values() for section in found):
        raise _out(f"{wire.id!r} is not visible near any of its {len(forks)} forks")
    if len(held) < len(forks):
        texts = "; ".join(fault for fault in faults.values() if fault)
        raise _out(f"{wire.id!r} lies in {len(held)} of its {len(forks)} forks: {texts}")
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


def _show(context: RobotContext, seen: WireLines, faults: Mapping[Duct, str]) -> None:
    drawing = Drawing(seen.picture.rgb, seen.picture.view)
    for fork, fault in faults.items():
        middle = (context.panel.world_from_panel @ fork.panel_from_duct).position
        drawing.circle(seen.picture.view.project(middle)[0], 6, ORANGE if fault else BLUE)
    texts = "; ".join(fault for fault in faults.values() if fault)
    drawing.title(f"{seen.wire.id}: {texts or 'lies in its forks'}")
    context.cameras.show("overhead", seen.picture, drawing.image)


def _out(found: str) -> AbilityError:
    return AbilityError(Code.OUT_OF_DUCT, f"{found}; draw it out and place it again")
