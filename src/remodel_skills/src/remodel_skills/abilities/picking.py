"""Loose ends of the live wire: DetectCable, PickCable, PlaceCable.

DetectCable finds the wire and its loose ends from above. PickCable grasps one by friction and lifts
it; PlaceCable lays the held one down and releases it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remodel_skills.abilities.ability import Done, ability
from remodel_skills.belief_state import BeliefState, EndState
from remodel_skills.goal_checks import (
    Message,
    check_hand,
    check_held,
    check_live,
    check_tool_path,
    parse_end,
    pose_from,
    require_level,
    require_number,
    require_pose,
    require_robot,
)
from remodel_skills.parameters import Parameters
from remodel_skills.primitives.carrying import drop_into_bin, lay_down, let_down
from remodel_skills.primitives.force_motion import pull_out
from remodel_skills.primitives.grasping import pick_end
from remodel_skills.primitives.motions import held_tool, park
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
from remodel_work.panel import Panel, PanelWire, WireEnd
from remodel_work.robot.arm import ToolPose


@dataclass(frozen=True)
class DetectGoal:
    """Find a wire and its loose ends; `view` 0 is the usual viewpoint, more are others."""

    cable_id: str
    view: int = 0

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when the wire is unknown or not fed."""
        check_live(self.cable_id, panel, belief)


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


def _detect_goal(message: Message, board: Pose) -> DetectGoal:
    return DetectGoal(message.cable_id, message.view)


@ability("DetectCable", _detect_goal)
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


@dataclass(frozen=True)
class PickGoal:
    """Grasp a loose end; a distance of 0 means the cell's default."""

    robot_name: str
    cable_id: str
    end: WireEnd
    grasp_distance: float

    def __post_init__(self) -> None:
        """Refuse unknown robots."""
        require_robot(self.robot_name)

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when the end cannot be picked."""
        if self.grasp_distance != 0.0:
            allowed = parameters.tool.grasp_distance_range_m
            require_number("grasp_distance", self.grasp_distance, *allowed, "m")
        check_live(self.cable_id, panel, belief)
        check_hand(belief, self.end)
        if belief.grip is not None:
            raise AbilityError(
                Code.OTHER_CABLE_HELD,
                f"the gripper holds end {belief.grip.end.value} of {self.cable_id!r} already; "
                "place it first",
            )
        if belief.feed is not None and belief.ends[self.end].value != "loose":
            raise AbilityError(
                Code.INVALID_GOAL,
                f"end {self.end.value} of {self.cable_id!r} is {belief.ends[self.end].value} in a "
                "terminal; extract it first",
            )


@dataclass(frozen=True)
class CablePicked:
    """A wire in the hand.

    Attributes:
        message: for a person.
        grasp_pose: tool centre at the grasp.
        grip_width: between the pads [m].
    """

    message: str
    grasp_pose: ToolPose
    grip_width: float


def _pick_goal(message: Message, board: Pose) -> PickGoal:
    return PickGoal(
        message.robot_name, message.cable_id, parse_end(message.cable_end), message.grasp_distance
    )


@ability("PickCable", _pick_goal)
def pick_cable(context: RobotContext, goal: PickGoal) -> Steps[CablePicked]:
    """Find the end, grasp it so that the hand can insert it where it belongs, and lift it."""
    socket = context.panel.world_from_panel @ context.panel.panel_from_socket(
        *context.wire.goes_to(goal.end)
    )
    yield from pick_end(context, goal.end, goal.grasp_distance, socket, shares=(0.0, 1.0))
    gap = context.device.gripper.gap
    message = f"end {goal.end.value} of {goal.cable_id} held, {gap * 1e3:.1f} mm between the pads"
    return CablePicked(message, context.belief.picked_at[goal.end].tool, gap)


@dataclass(frozen=True)
class PlaceGoal:
    """Lay the held end down, of whatever wire when `cable_id` is empty.

    `target` has the tool centre at release, x along the wire towards the tip; an end from the
    magazine is released where the hand is.
    """

    robot_name: str
    cable_id: str
    target: Pose

    def __post_init__(self) -> None:
        """Refuse unknown robots and poses that are none."""
        require_robot(self.robot_name)
        require_pose("target_pose", self.target)

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when nothing is held, or the place is not level or out of reach."""
        require_level("target_pose", self.target, parameters.terminal.level_rad)
        if self.cable_id:
            check_live(self.cable_id, panel, belief)
        check_held(belief)
        if not belief.by_magazine:
            check_tool_path((self.target,), belief)


def _place_goal(message: Message, board: Pose) -> PlaceGoal:
    return PlaceGoal(
        message.robot_name, message.cable_id, pose_from("target_pose", message.target_pose, board)
    )


@ability("PlaceCable", _place_goal)
def place_cable(context: RobotContext, goal: PlaceGoal) -> Steps[Done]:
    """Carry the held end to the target, release it there, and lift the empty hand.

    An end that sits in a terminal is pulled out; one that is fixed there is released where it is.
    An end from the magazine has no place on the board: it is released above where the hand is. If
    nothing else holds the wire, it is dropped into the scrap bin.
    """
    yield from _draw_out(context)
    if context.belief.by_magazine and not _is_held_elsewhere(context):
        wire_id = context.wire.id
        yield from drop_into_bin(context, (0.2, 1.0))
        return Done(f"{wire_id} dropped into the scrap bin: nothing else held it")
    if context.belief.by_magazine:
        yield from let_down(context)
    else:
        yield from lay_down(context, held_tool(context, goal.target), (0.0, 1.0))
    x, y = context.commanded.x, context.commanded.y
    return Done(f"{context.wire.id} laid down at x {x * 1e3:.0f}, y {y * 1e3:.0f} mm")


def _is_held_elsewhere(context: RobotContext) -> bool:
    """Return whether a terminal or another robot holds the other end."""
    belief = context.belief
    assert belief.grip is not None, "the goal's check"
    other = belief.grip.end.other
    in_hand = any(grip.end is other for grip in belief.hands.values())
    return in_hand or belief.ends[other] is not EndState.LOOSE


def _draw_out(context: RobotContext) -> Steps[None]:
    """Pull the held end out of its opening, unless it is fixed there."""
    belief = context.belief
    grip, socket = belief.grip, belief.engaged
    if grip is None or socket is None:
        return
    context.report("pulling the end out of its opening", 0.0)
    try:
        yield from pull_out(context, socket, context.parameters.terminal.pushed_in_holds_n)
        belief.loosen(grip.end)
    except AbilityError as error:
        if error.code is not Code.EXTRACTION_STUCK:
            raise
        belief.ends[grip.end] = EndState.FIXED
        text = f"{error}; it is fixed: extract it first"
        raise AbilityError(error.code, text, **error.found) from error
