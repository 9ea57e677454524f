"""DetectCable: find the live wire and its loose ends from above."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remodel_skills.abilities.ability import ability
from remodel_skills.goal_checks import Message
from remodel_skills.goals import DetectGoal
from remodel_skills.primitives.motions import park
from remodel_skills.primitives.observation.observing import (
    GraspObservation,
    OverheadObservation,
    loose_ends,
    mark_end,
    observe_from_above,
    observe_from_aside,
)
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.cables.lines import arc_lengths
from remodel_vision.colour import ORANGE, Drawing
from remodel_vision.wire_ends import STRAIGHT_M, TipObservation, line_between, line_from
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose
from remodel_work.panel import PanelWire, WireEnd


@dataclass(frozen=True, eq=False)
class CableDetected:
    """The live wire as seen.

    Attributes:
        message: for a person.
        centreline: (n, 3) [m], world frame, from end a on when that is loose.
        tips: of the loose ends, end a first.
        length: of the part seen [m].
        confidence: 0 to 1.
    """

    message: str
    centreline: Array
    tips: tuple[TipObservation, ...]
    length: float
    confidence: float


def _line(above: OverheadObservation) -> Array:
    """Return the wire's centreline (n, 2) [px], end a first: all of it, or the longest part."""
    if len(above.ends) == 2:
        whole = line_between((above.ends[WireEnd.A], above.ends[WireEnd.B]), above.lines)
        if whole is not None:
            return whole
    paths = {end: line_from(seen, above.lines) for end, seen in above.ends.items()}
    first = max(paths, key=lambda end: (len(paths[end]), end is WireEnd.A))
    return paths[first] if first is WireEnd.A else paths[first][::-1]


def _observe_from_aside(
    context: RobotContext, above: OverheadObservation, ends: list[WireEnd], view: int
) -> Steps[dict[WireEnd, GraspObservation]]:
    """Search for ends with the wrist camera; return those found.

    Raises:
        AbilityError: CABLE_NOT_FOUND when no end is visible, TIP_NOT_FOUND when one of them is
            hidden from everywhere.
    """
    wire, seen = context.wire, dict[WireEnd, GraspObservation]()
    if not above.ends and not view:
        ends = []
    for end in ends:
        context.report(f"searching for end {end.value} from aside", 0.85)
        observation = yield from observe_from_aside(context, end, view)
        if observation is not None:
            seen[end] = observation
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


def _centreline(
    above: OverheadObservation,
    aside: dict[WireEnd, GraspObservation],
    wire: PanelWire,
    *,
    hangs: bool,
) -> Array:
    """Return the wire's centreline (n, 3) [m], end a first: from above, or from the hand.

    Of a wire that `hangs` in the magazine only the first seen end, which is level.
    """
    if above.ends and hangs:
        end = min(above.ends, key=lambda end: end.value)
        observation = above.ends[end]
        pixels = line_from(observation, above.lines)
        line = above.picture.view.on_plane(pixels, observation.tip.tip[2])
        level = arc_lengths(line[:, :2]) <= STRAIGHT_M
        return line[level] if end is WireEnd.A else line[level][::-1]
    if above.ends:
        return above.picture.view.on_plane(_line(above), wire.radius)
    first = max(aside, key=lambda end: (len(aside[end].line), end is WireEnd.A))
    return aside[first].line if first is WireEnd.A else aside[first].line[::-1]


def _goal(message: Message, board: Pose) -> DetectGoal:
    return DetectGoal(message.cable_id, message.view)


@ability("DetectCable", _goal)
def detect_cable(context: RobotContext, goal: DetectGoal) -> Steps[CableDetected]:
    """Find the ferrules of the wire from above, and follow it from one of them.

    The wrist camera searches for an end that is hidden from above; with another view, and an
    empty hand, for every end.
    """
    context.report("taking the arm out of the picture", 0.0)
    above = yield from observe_from_above(context)
    context.report("following the wire", 0.8)
    wire, view = context.wire, above.picture.view
    drawing = Drawing(above.picture.rgb, view)
    wanted = loose_ends(context)
    hidden = [end for end in wanted if end not in above.ends]
    if hidden:
        text = ", ".join(end.value for end in hidden)
        drawing.title(f"{wire.id}: end {text} not seen from above")
        context.cameras.show("overhead", above.picture, drawing.image)
    if goal.view and context.belief.grip is None:
        hidden = wanted
    aside = yield from _observe_from_aside(context, above, hidden, goal.view)
    if aside and context.peers and context.belief.grip is None:
        yield from park(context)  # the robot that picks the end may be another one
    hangs = context.belief.by_magazine and not context.belief.is_touched
    line = _centreline(above, aside, wire, hangs=hangs)
    length = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
    visible = STRAIGHT_M if hangs else wire.length
    confidence = float(np.clip(1 - abs(length / visible - 1), 0, 1))
    drawing.path(view.project(line), ORANGE)
    for end, observation in above.ends.items():
        mark_end(drawing, observation, f"{wire.id} end {end.value}")
    drawing.title(
        f"{wire.id} ({wire.colour}): {length * 1e3:.0f} of {wire.length * 1e3:.0f} mm seen"
    )
    context.cameras.show("overhead", above.picture, drawing.image)
    ends = " and ".join(end.value for end in wanted)
    tips = tuple(context.belief.tips[end] for end in wanted)
    message = f"loose end {ends} of {wire.id} seen, and {length * 1e3:.0f} mm of the wire"
    return CableDetected(message, line, tips, length, confidence)
