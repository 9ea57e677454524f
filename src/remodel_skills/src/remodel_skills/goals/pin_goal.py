"""The goal of PlacePin: where the two pins of the live wire go, and the path between them.

The wire's pins are its two ferrules. They go to two neighbouring connectors, `connector_space`
apart; poses of the path lie between them, `path_space` apart from the first connector on. The row
runs along the panel's x axis, or along y when it is rotated, from the panel's origin, or with its
middle there when it is centered.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from remodel_skills.belief_state import BeliefState, EndState
from remodel_skills.goals.checks import check_reach
from remodel_skills.goals.requirements import require, require_number
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose
from remodel_work.layout import GRASP_DISTANCE_M
from remodel_work.panel import Panel, PanelWire
from remodel_work.robot.arm import ToolPose

# How much shorter than the wire the way between its pins may be [m]: the wire is drawn straight, so
# each pin lies half of this beyond its place.
SLACK_M = (0.002, 0.010)
PATH_SPACE_M = (0.005, 1.0)
CONNECTOR_SPACE_M = (0.01, 1.0)
# A pin lies so far from a component at least: an open finger fits between [m].
ROOM_M = 0.024


@dataclass(frozen=True)
class PlacePinGoal:
    """Lay the live wire's two pins at two connectors, with two robots."""

    robot_1: str
    robot_2: str
    path_space: float
    connector_space: float
    centered: bool
    rotate: bool
    show_in_tf: bool

    def __post_init__(self) -> None:
        """Refuse one robot twice, and spaces that are none."""
        require(
            self.robot_1 != self.robot_2,
            f"robot_1_name and robot_2_name are both {self.robot_1!r}; it takes two robots",
        )
        require_number("path_space", self.path_space, *PATH_SPACE_M, "m")
        require_number("connector_space", self.connector_space, *CONNECTOR_SPACE_M, "m")
        require(
            self.path_space <= self.connector_space,
            f"path_space is {self.path_space:g} m; allowed: up to connector_space, "
            f"{self.connector_space:g} m",
        )

    def check(self, panel: Panel, belief: BeliefState) -> None:
        """Raise when a robot cannot lay the live wire there; asked for each of the two."""
        if belief.feed is None:
            raise AbilityError(Code.WIRE_NOT_FED, "no wire has been fed; feed one first")
        wire = panel.wire(belief.feed.wire_id)
        for end, state in belief.ends.items():
            if state is not EndState.LOOSE:
                raise AbilityError(
                    Code.INVALID_GOAL,
                    f"end {end.value} of {wire.id!r} is {state.value} in a terminal; extract it "
                    "first",
                )
        self._check_length(wire)
        for name, pose in pin_row(self, wire, panel).items():
            self._check_place(name, pose, panel)
            if name.startswith("pin"):
                x, y, z = (float(v) for v in pose.position - pose.rotation[:, 0] * GRASP_DISTANCE_M)
                check_reach(belief.arm, ToolPose(x, y, z, pose.yaw))

    def _check_length(self, wire: PanelWire) -> None:
        least, most = (round(wire.length - slack, 4) for slack in reversed(SLACK_M))
        require(
            least <= self.connector_space <= most,
            f"connector_space is {self.connector_space:g} m; {wire.id!r} is {wire.length:g} m "
            f"long, allowed: {least:g} to {most:g} m",
        )

    def _check_place(self, name: str, pose: Pose, panel: Panel) -> None:
        x, y, _ = (float(v) for v in panel.world_from_panel.inverse().apply(pose.position))
        require(
            abs(x) <= panel.size[0] / 2 and abs(y) <= panel.size[1] / 2,
            f"{name} would lie beyond the plate, at x {x:.3f}, y {y:.3f} m; allowed: "
            f"{panel.size[0] / 2:g} and {panel.size[1] / 2:g} m; rotate or center the row",
        )
        for component in panel.components:
            local = component.panel_from_component.inverse().apply(np.array([x, y, 0.0]))
            beside = np.abs(local[:2]) - np.array(component.size[:2]) / 2
            require(
                float(beside.max()) > ROOM_M,
                f"{name} would lie at x {x:.3f}, y {y:.3f} m of the panel, nearer than "
                f"{ROOM_M * 1e3:.0f} mm to component {component.id!r}; rotate or center the row",
            )


def pin_row(goal: PlacePinGoal, wire: PanelWire, panel: Panel) -> dict[str, Pose]:
    """Return the poses by name, in the world: pin_1, path_1 to path_n, pin_2.

    The pins' x axes point out of the wire, those of the path from the first pin to the second.
    """
    start = -goal.connector_space / 2 if goal.centered else 0.0
    axis = np.array([0.0, 1.0, 0.0]) if goal.rotate else np.array([1.0, 0.0, 0.0])
    yaw = math.pi / 2 if goal.rotate else 0.0

    def at(along: float, turn: float = 0.0) -> Pose:
        place: Array = (start + along) * axis
        return panel.world_from_panel @ Pose.level(place[0], place[1], wire.radius, yaw + turn)

    between = math.ceil(goal.connector_space / goal.path_space - 1e-9) - 1
    path = {f"path_{k}": at(k * goal.path_space) for k in range(1, between + 1)}
    return {"pin_1": at(0.0, math.pi), **path, "pin_2": at(goal.connector_space)}
