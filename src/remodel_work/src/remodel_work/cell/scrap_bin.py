"""Where a robot's scrap bin stands: beyond an edge of the plate, where no wire is placed."""

from __future__ import annotations

import math

import numpy as np

from remodel_states.core.codes import Code
from remodel_work.cell.cell_design import RobotDesign
from remodel_work.errors import AbilityError
from remodel_work.panel import Panel
from remodel_work.robot.arm import ToolPose

# A cell whose file names no place has its bin so far beyond the plate's edge, and drops from so
# high: a wire's end clears the components there.
BEYOND_EDGE_M = 0.08
DROP_Z_M = 0.15
STEP_M = 0.02


def bin_of(robot: RobotDesign, panel: Panel) -> ToolPose:
    """Return the tool pose above a robot's scrap bin; its yaw is only one of those in reach.

    The default is beside the plate, on the side where the robot's hand waits: in the middle, or as
    near to it as the arm reaches.

    Raises:
        AbilityError: UNREACHABLE when no such place is within reach.
    """
    if robot.scrap_bin is not None:
        return robot.scrap_bin
    middle_x, middle_y, _ = panel.world_from_panel.position
    side = math.copysign(1.0, robot.home.y - middle_y)
    y = float(middle_y + side * (panel.size[1] / 2 + BEYOND_EDGE_M))
    base_x = robot.arm.base[0]
    count = math.ceil(abs(middle_x - base_x) / STEP_M)
    for x in np.linspace(middle_x, base_x, count):
        for yaw in (math.pi / 2, -math.pi / 2):
            tool = ToolPose(float(x), y, DROP_Z_M, yaw)
            if robot.arm.reaches(tool):
                return tool
    raise AbilityError(
        Code.UNREACHABLE,
        f"{robot.name} reaches no place for a scrap bin beside the plate, at y {y * 1e3:.0f} mm; "
        "name one in the cell's file (robots[].scrap_bin)",
    )
