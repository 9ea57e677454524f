"""Take up an end, or a wire between its ends, as steps of an ability."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from remodel_skills.belief_state import NO_CHANNEL, Feed, Grip
from remodel_skills.primitives.grasping import check_grip, close_fingers_on
from remodel_skills.primitives.in_ducts import AMONG_WIRES, lowest
from remodel_skills.primitives.motions import (
    clear_hand,
    is_free,
    move_to,
    nearest_hand_yaw,
    park,
    rise,
)
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.colour import ORANGE, Drawing
from remodel_vision.standing import APART_M, graspable_places
from remodel_work.camera import Picture
from remodel_work.cell.presenting import plan_presentation, resting_place
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import PanelWire, WireEnd
from remodel_work.robot.arm import ToolPose


def take_up(context: RobotContext, wire_id: str) -> None:
    """Make a placed wire the live one, so that it can be handled again; a live one is.

    Every other robot must be idle; raises BUSY.
    """
    if context.device.magazine.is_at_hand(wire_id):
        return
    for other in context.peers:
        if other.busy:
            raise AbilityError(
                Code.BUSY,
                f"{other.name} is busy, and {wire_id!r} can be handled again only while it is "
                "not; try again",
            )
    tools = {name: robot.commanded for name, robot in context.robots.items()}
    placed = context.device.magazine.take_up(wire_id, tools)
    wire = context.panel.wire(wire_id)
    feed, places = _as_presented(context, wire)
    lay_at = {end: Grip.of_tip(end, place) for end, place in places.items()}
    for robot in context.robots.values():
        robot.arm_restarted()
        expected = {end: np.array(point) for end, point in placed.expected.items()}
        robot.belief.resume_wire(feed, expected, placed.fixed, lay_at)


def _as_presented(context: RobotContext, wire: PanelWire) -> tuple[Feed, dict[WireEnd, Pose]]:
    """Return how a wire was presented, and where its ends go when they are extracted.

    One from the magazine has no channel to lie in: its ends stay before their terminals.
    """
    panel = context.panel
    feeder, magazine = context.cell.feeder, context.cell.magazine
    if magazine is not None:
        direction = plan_presentation(magazine, panel, wire).direction
        openings = {end: panel.panel_from_socket(*wire.goes_to(end)) for end in WireEnd}
        places = {end: panel.world_from_panel @ opening for end, opening in openings.items()}
        return Feed(wire.id, NO_CHANNEL, direction), places
    assert feeder is not None, "a cell has a feeder or a magazine"
    lying = {end: resting_place(panel, wire, end, feeder.overlap) for end in WireEnd}
    channel = panel.channel_in_front_of(panel.panel_from_socket(*wire.goes_to(WireEnd.A)).position)
    feed = Feed(wire.id, channel.id, lying[WireEnd.A][1])
    return feed, {end: place for end, (place, _) in lying.items()}


def end_wire(context: RobotContext) -> None:
    """Note that no piece of the live wire is left."""
    wire_id = context.wire.id
    for robot in context.robots.values():
        robot.belief.end_wire(wire_id)


def pick_up(context: RobotContext) -> Steps[bool]:
    """Pick the live wire up between its ends, where it lies highest and the hand has room.

    It is what stands higher than before it was touched, by the overhead depth camera. No tip stands
    out of the hand then: the grip's distance is 0.

    Returns:
        Whether the hand holds it. It does not where no picture from before shows what is new, or
        the wire is seen nowhere, or slips away.
    """
    if not context.belief.untouched:
        return False
    context.report(f"searching for {context.wire.id} anywhere", 0.5)
    tried: list[Pose] = []
    for _ in range(context.parameters.motion.pick_up_attempts):
        yield from park(context)
        yield from clear_hand(context)
        pictures = context.cameras.take_overhead_pictures()
        yield
        picture, place = _next_place(context, pictures, tried)
        _show(context, picture, place)
        if place is None:
            return False
        tried.append(place)
        try:
            yield from _grasp(context, _tool_at(context, place))
        except AbilityError as error:
            if error.code not in (Code.GRASP_MISSED, Code.GRASP_SLIPPED):
                raise
        else:
            return True
    return False


def _next_place(
    context: RobotContext, pictures: Sequence[Picture], tried: Sequence[Pose]
) -> tuple[Picture, Pose | None]:
    """Return where the wire lies highest, and the hand reaches it, apart from what was tried.

    It is in the first of the pictures that shows such a place.
    """
    for picture in pictures:
        before = context.belief.board_before(picture.view)
        if before is None:
            continue
        for place in graspable_places(picture, before, context.wire.radius):
            away = [float(np.linalg.norm((place.position - t.position)[:2])) for t in tried]
            is_new = min(away, default=APART_M) >= APART_M
            if is_new and _has_room(context, _tool_at(context, place)):
                return picture, place
    return pictures[0], None


def _show(context: RobotContext, picture: Picture, place: Pose | None) -> None:
    drawing = Drawing(picture.rgb, picture.view)
    if place is not None:
        drawing.circle(picture.view.project(place.position)[0], 9, ORANGE)
    found = "not seen" if place is None else "highest here"
    drawing.title(f"Picking up {context.wire.id}: {found}")
    context.cameras.show("overhead", picture, drawing.image)


def _tool_at(context: RobotContext, place: Pose) -> ToolPose:
    x, y, z = (float(v) for v in place.position)
    yaw = nearest_hand_yaw(context.arm, x, y, place.yaw, near=context.commanded.yaw)
    return ToolPose(x, y, max(z, lowest(context)), yaw)


def _has_room(context: RobotContext, tool: ToolPose) -> bool:
    """Return whether the open hand reaches a tool pose from above, past all but wires."""
    above = _above(context, tool)
    return (
        context.arm.reaches(tool)
        and context.arm.reaches(above)
        and context.space.has_room(tool)
        and is_free(context, tool, AMONG_WIRES, start=above)
    )


def _above(context: RobotContext, tool: ToolPose) -> ToolPose:
    return tool.at(z=max(context.parameters.motion.travel_z_m, tool.z))


def _grasp(context: RobotContext, tool: ToolPose) -> Steps[None]:
    """Close the hand on the wire at a tool pose, and lift it.

    Raises:
        AbilityError: GRASP_MISSED, GRASP_SLIPPED; the hand is empty.
    """
    motion = context.parameters.motion
    context.report(f"grasping {context.wire.id} where it lies", 0.6)
    above = _above(context, tool)
    yield from move_to(
        context, above.at(z=max(above.z, context.commanded.z)), motion.free_speed_m_s
    )
    yield from move_to(context, above, motion.free_speed_m_s)
    yield from move_to(context, tool, motion.approach_speed_m_s, AMONG_WIRES)
    yield from close_fingers_on(context, context.wire.diameter)
    context.belief.grip = Grip(end=WireEnd.A, distance=0.0, height=0.0, flip=0.0, tool=tool)
    context.belief.tips.clear()
    yield from rise(context)
    check_grip(context)
