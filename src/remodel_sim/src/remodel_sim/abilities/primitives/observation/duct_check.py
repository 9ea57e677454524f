"""Inspect ducts with the camera of an empty hand, as steps of an ability.

The overhead camera sees a duct's floor only where the duct stands below it, and not where a hand
holds the rest of the wire; a hand looks down into each part of a duct from straight above.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from remodel_sim.abilities.execution.robot_context import RobotContext, Steps
from remodel_sim.abilities.primitives.motions import past_robots, swing_to, wait
from remodel_sim.abilities.primitives.observation.observing import STILL_S
from remodel_sim.abilities.primitives.observation.viewpoints import camera_above
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Pose
from remodel_sim.core.robot.arm import ToolPose
from remodel_sim.core.vision.drawing import BLUE, ORANGE, Drawing
from remodel_sim.core.vision.laid_wire import wire_past
from remodel_sim.core.vision.wire_lines import WireLines
from remodel_sim.core.workpiece.panel import Duct
from remodel_states.core.codes import Code

# So many neighbouring places of a duct are inspected from above their middle, with the tool so high
# [m]; where another robot is in the way, from so far along the duct.
IN_A_VIEW = 6
INSPECT_Z = 0.25
ALONG_M = (0.0, 0.06, -0.06, 0.12, -0.12)
# The wire must be seen in its duct or above it at this share of the places.
LEAST_OBSERVED = 0.5


def share_in_ducts(context: RobotContext, places: Mapping[Duct, Sequence[Pose]]) -> Steps[float]:
    """Inspect ducts; return at which share of the observed places the wire lies below the rim.

    Args:
        context: of a robot with an empty hand, whose camera measures depth.
        places: frames in each duct, x along it, world frame.

    Raises:
        AbilityError: CABLE_OCCLUDED when the wire is observed at too few places.
    """
    below, above, unseen = 0, 0, 0
    for duct, part in _parts(places):
        for tool in _inspecting(context, part):
            try:
                yield from swing_to(context, tool)
            except AbilityError as error:
                if error.code not in (Code.UNREACHABLE, Code.ROBOT_IN_THE_WAY):
                    raise
                continue
            break
        else:
            unseen += len(part)
            continue
        yield from wait(context, STILL_S)
        found = _inspect(context, duct, part)
        yield
        below += found.count(True)
        above += found.count(False)
        unseen += found.count(None)
    observed = (below + above) / max(1, below + above + unseen)
    if observed < LEAST_OBSERVED:
        raise AbilityError(
            Code.CABLE_OCCLUDED,
            f"{context.wire.id!r} is in view at {observed:.0%} of its route in ducts; needed: "
            f"{LEAST_OBSERVED:.0%} or more; draw it out and place it again",
        )
    return below / (below + above)


def _parts(places: Mapping[Duct, Sequence[Pose]]) -> Iterator[tuple[Duct, Sequence[Pose]]]:
    for duct, at in places.items():
        for first in range(0, len(at), IN_A_VIEW):
            yield duct, at[first : first + IN_A_VIEW]


def _inspecting(context: RobotContext, part: Sequence[Pose]) -> Iterator[ToolPose]:
    """Yield tool poses from which the hand's camera looks down on a part of a duct."""
    middle = np.mean([place.position for place in part], axis=0)
    along = part[0].rotation[:, 0]
    for away in ALONG_M:
        tool = camera_above(context, (middle + away * along)[:2], part[0].yaw, INSPECT_Z)
        if context.arm.reaches(tool) and past_robots(context, tool):
            yield tool


def _inspect(context: RobotContext, duct: Duct, part: Sequence[Pose]) -> list[bool | None]:
    """Return for each place whether the wire is below the rim; None: it is not seen there.

    Beyond a duct's walls it is not searched for: devices may have its colour.
    """
    picture = context.take_wrist_picture()
    heights = tuple({float(place.position[2]) for place in part})
    lines = WireLines(picture, context.wire, heights)
    passings = [wire_past(place, duct.width / 2, lines) for place in part]
    found = [None if passing is None else passing.height < duct.height for passing in passings]
    drawing = Drawing(picture.rgb, picture.view)
    for place, is_below in zip(part, found, strict=True):
        colour = BLUE if is_below else ORANGE
        drawing.circle(picture.view.project(place.position)[0], 6, colour)
    drawing.title(f"{context.wire.id}: below the rim of {duct.id!r} at {found.count(True)} places")
    context.show("wrist", picture, drawing.image)
    return found
