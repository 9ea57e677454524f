"""RouteWire: carry the held end along a path."""

from __future__ import annotations

import math
from dataclasses import dataclass

from remodel_sim.abilities.grasping import check_grip
from remodel_sim.abilities.motions import CARRY_SPEED, disengage, move_to
from remodel_sim.abilities.station import Station, Steps
from remodel_sim.core.arm import ToolPose
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Pose
from remodel_sim.core.goals import RouteGoal


@dataclass(frozen=True)
class WireRouted:
    """A wire carried along.

    Attributes:
        message: for a person.
        reached: number of path poses reached.
    """

    message: str
    reached: int


def route_wire(station: Station, goal: RouteGoal) -> Steps[WireRouted]:
    """Lift to the first pose's height, then go from pose to pose in straight lines."""
    yield from disengage(station)
    for i, pose in enumerate(goal.path):
        station.report(f"carrying the wire to pose {i + 1} of {len(goal.path)}", i / len(goal.path))
        tool = held_tool(station, pose)
        try:
            if i == 0 and tool.z > station.commanded.z:
                yield from move_to(station, station.commanded.at(z=tool.z), CARRY_SPEED)
            yield from move_to(station, tool, CARRY_SPEED)
            check_grip(station)
        except AbilityError as error:
            error.readings["reached"] = i
            raise
    count = len(goal.path)
    return WireRouted(f"{goal.cable_id} carried along {count} poses", count)


def held_tool(station: Station, pose: Pose) -> ToolPose:
    """Return the tool pose that points the held wire's tip along a pose's x axis."""
    x, y, z = (float(v) for v in pose.position)
    flip = station.book.grip.flip if station.book.grip is not None else 0.0
    return ToolPose(x, y, z, pose.yaw - (0.0 if math.isclose(flip, 0.0) else flip))
