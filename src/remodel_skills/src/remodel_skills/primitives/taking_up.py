"""Handle a placed wire again."""

from __future__ import annotations

import numpy as np

from remodel_skills.belief_state import NO_CHANNEL, Feed, Grip
from remodel_skills.robot_context import RobotContext
from remodel_states.core.codes import Code
from remodel_work.cell.feeding import resting_place
from remodel_work.cell.magazine import plan_presentation
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import PanelWire, WireEnd


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
