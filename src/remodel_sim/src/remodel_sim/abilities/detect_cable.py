"""DetectCable: find the live wire and its loose ends from above."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from remodel_sim.abilities.ability import ability
from remodel_sim.abilities.execution.robot_context import Station, Steps
from remodel_sim.abilities.primitives.observing import (
    GraspSighting,
    OverheadSighting,
    look_from_above,
    look_from_aside,
    loose_ends,
    mark_end,
)
from remodel_sim.core.belief.belief_state import TipSighting
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Array
from remodel_sim.core.goals import DetectGoal
from remodel_sim.core.vision.drawing import ORANGE, Drawing
from remodel_sim.core.vision.wire_ends import trace_between, trace_from
from remodel_sim.core.workpiece.panel import End, Wire
from remodel_states.core.codes import Code


@dataclass(frozen=True, eq=False)
class CableDetected:
    """The live wire as seen.

    Attributes:
        message: for a person.
        centreline: (n, 3) [m], world frame, from end a on when that is loose.
        tips: of the loose ends, end a first.
        length: of the part seen [m].
        confidence: 0 to 1.
        truncated: never true: a wire that leaves the picture fails.
    """

    message: str
    centreline: Array
    tips: tuple[TipSighting, ...]
    length: float
    confidence: float
    truncated: bool


def _trace(above: OverheadSighting, wire: Wire) -> Array:
    """Return the wire's centreline (n, 2) [px], end a first: all of it, or the longest part."""
    seen = above.picture, above.likelihood, wire
    if len(above.ends) == 2:
        whole = trace_between((above.ends[End.A], above.ends[End.B]), *seen)
        if whole is not None:
            return whole
    paths = {end: trace_from(sighting, *seen) for end, sighting in above.ends.items()}
    first = max(paths, key=lambda end: (len(paths[end]), end is End.A))
    return paths[first] if first is End.A else paths[first][::-1]


def _look_aside(
    station: Station, above: OverheadSighting, ends: list[End], view: int
) -> Steps[dict[End, GraspSighting]]:
    """Look for ends from the hand; return those seen.

    Raises:
        AbilityError: CABLE_NOT_FOUND when no end is seen at all, TIP_NOT_FOUND when one of them is
            hidden from everywhere.
    """
    wire, seen = station.wire, dict[End, GraspSighting]()
    if not above.ends and not view:
        ends = []
    for end in ends:
        station.report(f"looking for end {end.value} from aside", 0.85)
        sighting = yield from look_from_aside(station, end, view)
        if sighting is not None:
            seen[end] = sighting
    found = {*above.ends, *seen}
    if not found:
        raise AbilityError(
            Code.CABLE_NOT_FOUND,
            f"no end of {wire.id!r} ({wire.colour}) is seen; feed the wire again",
        )
    for end in ends:
        if end not in found:
            others = ", ".join(sorted(end.value for end in found))
            raise AbilityError(
                Code.TIP_NOT_FOUND,
                f"end {end.value} of {wire.id!r} ({wire.colour}) is hidden, from above and from "
                f"aside; seen: {others}; feed the wire again",
            )
    return seen


def _centreline(above: OverheadSighting, aside: dict[End, GraspSighting], wire: Wire) -> Array:
    """Return the wire's centreline (n, 3) [m], end a first: from above, or from the hand."""
    if above.ends:
        return above.picture.view.on_plane(_trace(above, wire), wire.radius)
    first = max(aside, key=lambda end: (len(aside[end].line), end is End.A))
    return aside[first].line if first is End.A else aside[first].line[::-1]


def _goal(message: Any) -> DetectGoal:  # noqa: ANN401 - messages have no types
    return DetectGoal(message.cable_id, message.view)


@ability("DetectCable", _goal)
def detect_cable(station: Station, goal: DetectGoal) -> Steps[CableDetected]:
    """Look from above, find the ferrules of the wire, and follow it from one of them.

    An end that is hidden from above is looked for from the hand; with another view, and an empty
    hand, every end.
    """
    station.report("taking the arm out of the picture", 0.0)
    above = yield from look_from_above(station)
    station.report("following the wire", 0.8)
    wire, view = station.wire, above.picture.view
    drawing = Drawing(above.picture.rgb, view)
    wanted = loose_ends(station)
    hidden = [end for end in wanted if end not in above.ends]
    if hidden:
        text = ", ".join(end.value for end in hidden)
        drawing.title(f"{wire.id}: end {text} not seen from above")
        station.show("overhead", above.picture, drawing.image)
    if goal.view and station.book.grip is None:
        hidden = wanted
    aside = yield from _look_aside(station, above, hidden, goal.view)
    line = _centreline(above, aside, wire)
    length = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
    confidence = float(np.clip(1 - abs(length / wire.length - 1), 0, 1))
    drawing.path(view.project(line), ORANGE)
    for end, sighting in above.ends.items():
        mark_end(drawing, sighting, f"{wire.id} end {end.value}")
    drawing.title(
        f"{wire.id} ({wire.colour}): {length * 1e3:.0f} of {wire.length * 1e3:.0f} mm seen"
    )
    station.show("overhead", above.picture, drawing.image)
    ends = " and ".join(end.value for end in wanted)
    tips = tuple(station.book.tips[end] for end in wanted)
    message = f"loose end {ends} of {wire.id} seen, and {length * 1e3:.0f} mm of the wire"
    return CableDetected(message, line, tips, length, confidence, False)
