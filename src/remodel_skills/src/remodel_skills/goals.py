"""The goals of the abilities, valid from birth.

`check` raises when the cell cannot take them as it is now: whatever raises here is found before
anything moves.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from remodel_skills.belief_state import BeliefState, EndState
from remodel_skills.goal_checks import (
    check_clamp,
    check_hand,
    check_hands_empty,
    check_held,
    check_live,
    check_opening,
    check_reach,
    check_socket,
    check_tool_path,
    require,
    require_level,
    require_number,
    require_pose,
    require_robot,
)
from remodel_skills.parameters import Parameters, TerminalParameters, ToolParameters
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose
from remodel_work.layout import GRASP_DISTANCE_M
from remodel_work.panel import Panel, PanelWire, WireEnd
from remodel_work.robot.arm import ToolPose
from remodel_work.routes import clips_along


class Goal(Protocol):
    """What every goal can be asked."""

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise AbilityError when the cell cannot take the goal as it is now."""


@dataclass(frozen=True)
class LocateGoal:
    """Find a component and, unless the id is empty, one of its terminals.

    `view` 0 is the usual viewpoint, more are others.
    """

    component_id: str
    terminal_id: str
    view: int = 0

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when a name is unknown."""
        component = panel.component(self.component_id)
        if self.terminal_id:
            component.terminal(self.terminal_id)


@dataclass(frozen=True)
class CheckGoal:
    """See whether an end of a wire sits in a terminal; any wire of the panel, fed or not."""

    cable_id: str
    end: WireEnd
    component_id: str
    terminal_id: str

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when a name is unknown."""
        panel.wire(self.cable_id)
        check_clamp(self.component_id, self.terminal_id, panel)


@dataclass(frozen=True)
class DetectGoal:
    """Find a wire and its loose ends; `view` 0 is the usual viewpoint, more are others."""

    cable_id: str
    view: int = 0

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when the wire is unknown or not fed."""
        check_live(self.cable_id, panel, belief)


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


@dataclass(frozen=True)
class RouteGoal:
    """Carry the held end along poses of the tool centre, x along the wire towards the tip.

    Or lay the wire into the clips that the path passes.
    """

    robot_name: str
    cable_id: str
    path: tuple[Pose, ...]

    def __post_init__(self) -> None:
        """Refuse unknown robots, an empty path and poses that are none."""
        require_robot(self.robot_name)
        require(bool(self.path), "path is empty; it must have one pose or more")
        for i, pose in enumerate(self.path):
            require_pose(f"path[{i}]", pose)

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when nothing is held, or a pose is not level or out of reach."""
        for i, pose in enumerate(self.path):
            require_level(f"path[{i}]", pose, parameters.terminal.level_rad)
        check_live(self.cable_id, panel, belief)
        check_held(belief)
        check_tool_path(self.path, belief)
        clips = clips_along(self.path, panel)
        if (
            clips
            and belief.grip is not None
            and belief.ends[belief.grip.end.other] is EndState.LOOSE
        ):
            other = belief.grip.end.other.value
            raise AbilityError(
                Code.INVALID_GOAL,
                f"the path passes clips {', '.join(clip.id for clip in clips)}, and end {other} of "
                f"{self.cable_id!r} is loose; insert and fix it first",
            )


@dataclass(frozen=True)
class InsertGoal:
    """Push an end into a terminal whose opening is at `socket`, x into the terminal."""

    robot_name: str
    cable_id: str
    end: WireEnd
    component_id: str
    terminal_id: str
    socket: Pose
    force_limit: float

    def __post_init__(self) -> None:
        """Refuse unknown robots and poses that are none."""
        _require_push(self)

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when the end cannot go there, or the grip does not hold the force."""
        _check_push(self, parameters.tool.grip_holds_n, parameters)
        check_live(self.cable_id, panel, belief)
        check_clamp(self.component_id, self.terminal_id, panel)
        connector = panel.wire(self.cable_id).connector_at(self.end)
        if connector is not None:
            raise AbilityError(
                Code.INVALID_GOAL,
                f"end {self.end.value} of {self.cable_id!r} is connector {connector.id!r}; place "
                "it with PlaceConnector",
            )
        terminal = panel.component(self.component_id).terminal(self.terminal_id)
        if self.force_limit <= terminal.insertion_force:
            raise AbilityError(
                Code.INVALID_GOAL,
                f"force_limit is {self.force_limit:.1f} N; the spring of "
                f"'{self.component_id}/{self.terminal_id}' lets a ferrule in with "
                f"{terminal.insertion_force:.1f} N: allow more, so that it meets the bottom",
            )
        check_free(self, self.end, panel, belief, parameters.terminal)


@dataclass(frozen=True)
class ConnectGoal:
    """Push a connector into the header whose face is at `socket`, x into it."""

    robot_name: str
    connector_id: str
    cable_id: str
    component_id: str
    terminal_id: str
    socket: Pose
    force_limit: float

    def __post_init__(self) -> None:
        """Refuse unknown robots and poses that are none."""
        _require_push(self)

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when the connector does not fit or cannot go there, or for too much force."""
        _check_push(self, parameters.tool.grip_holds_connector_n, parameters)
        check_live(self.cable_id, panel, belief)
        connector = panel.wire(self.cable_id).connector(self.connector_id)
        header = panel.component(self.component_id).terminal(self.terminal_id)
        if not connector.fits(header):
            raise AbilityError(
                Code.INVALID_GOAL,
                f"connector {connector.id!r} has {connector.ways} ways, "
                f"{connector.pitch * 1e3:.2f} mm apart; '{self.component_id}/{self.terminal_id}' "
                f"takes {header.ways}, {header.pitch * 1e3:.2f} mm apart",
            )
        check_free(self, connector.end, panel, belief, parameters.terminal)


@dataclass(frozen=True)
class FixGoal:
    """Close a terminal on the end in the hand; a pull test of 0 N means none."""

    robot_name: str
    cable_id: str
    component_id: str
    terminal_id: str
    pull_test_force: float

    def __post_init__(self) -> None:
        """Refuse unknown robots."""
        require_robot(self.robot_name)

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when nothing is held, or the grip does not hold the force."""
        most_n = parameters.tool.grip_holds_n
        require_number("pull_test_force", self.pull_test_force, 0.0, most_n, unit="N")
        check_live(self.cable_id, panel, belief)
        check_clamp(self.component_id, self.terminal_id, panel)
        check_held(belief)


@dataclass(frozen=True)
class ExtractGoal:
    """Pull a wire's end out of the terminal whose opening is at `socket`, x into it."""

    robot_name: str
    cable_id: str
    component_id: str
    terminal_id: str
    socket: Pose

    def __post_init__(self) -> None:
        """Refuse unknown robots and poses that are none."""
        require_robot(self.robot_name)
        require_pose("socket_pose", self.socket)

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when the wire or the socket is not there."""
        terminal = parameters.terminal
        require_level("socket_pose", self.socket, terminal.level_rad)
        check_live(self.cable_id, panel, belief)
        check_socket((self.component_id, self.terminal_id), self.socket, panel, belief, terminal)


def _require_push(goal: InsertGoal | ConnectGoal) -> None:
    require_robot(goal.robot_name)
    require_pose("socket_pose", goal.socket)


def _check_push(goal: InsertGoal | ConnectGoal, most_n: float, parameters: Parameters) -> None:
    require_level("socket_pose", goal.socket, parameters.terminal.level_rad)
    least_n = parameters.tool.least_push_n
    require_number("force_limit", goal.force_limit, least_n, most_n, unit="N")


def check_free(
    goal: InsertGoal | ConnectGoal,
    end: WireEnd,
    panel: Panel,
    belief: BeliefState,
    tolerances: TerminalParameters,
) -> None:
    """Raise unless a loose end, in the hand or to be picked, may now go into an opening."""
    key = (goal.component_id, goal.terminal_id)
    check_socket(key, goal.socket, panel, belief, tolerances)
    check_opening(key, goal.socket, panel, belief, tolerances)
    check_hand(belief, end)
    if belief.ends[end] is not EndState.LOOSE:
        raise AbilityError(
            Code.INVALID_GOAL,
            f"end {end.value} of {goal.cable_id!r} is {belief.ends[end].value} in a terminal; "
            "extract it first",
        )
    occupant = belief.occupied.get(key)
    if occupant is not None:
        raise AbilityError(
            Code.TERMINAL_OCCUPIED,
            f"terminal '{'/'.join(key)}' holds end {occupant[1].value} of {occupant[0]!r}",
        )


@dataclass(frozen=True)
class LayGoal:
    """Lead the live wire into the ducts of its route.

    Attributes:
        robot_name: of the robot that holds the free end.
        guide_name: of the robot that leads the wire.
        cable_id: the wire.
    """

    robot_name: str
    guide_name: str
    cable_id: str

    def __post_init__(self) -> None:
        """Refuse unknown robots, and one robot twice."""
        require_robot(self.robot_name)
        require(bool(self.guide_name.strip()), "guide_name is empty; it must name a second robot")
        require(
            self.robot_name != self.guide_name,
            f"robot_name and guide_name are both {self.robot_name!r}; it takes two robots",
        )

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when a robot cannot do its part; asked for each of the two."""
        check_live(self.cable_id, panel, belief)
        wire = panel.wire(self.cable_id)
        require(
            bool(wire.ducts),
            f"the route of {wire.id!r} passes no duct; carry it with RouteWire",
        )
        free = _free_end(wire, belief)
        if belief.robot == self.guide_name:
            _check_guide(belief)
        else:
            check_held(belief, free)


def _free_end(wire: PanelWire, belief: BeliefState) -> WireEnd:
    """Return the loose end of a wire; raises unless the other one is fixed."""
    loose = [end for end, state in belief.ends.items() if state is EndState.LOOSE]
    require(
        len(loose) == 1 and belief.ends[loose[0].other] is EndState.FIXED,
        f"of {wire.id!r}, end a is {belief.ends[WireEnd.A].value} and end b is "
        f"{belief.ends[WireEnd.B].value}; one must be fixed and the other one loose",
    )
    return loose[0]


def _check_guide(belief: BeliefState) -> None:
    """Raise unless the hand is empty and has an eyelet."""
    if belief.grip is not None:
        raise AbilityError(
            Code.OTHER_CABLE_HELD,
            f"{belief.robot}, which leads the wire, holds end {belief.grip.end.value}; place it "
            "first",
        )
    fingers = belief.arm.fingers
    require(
        fingers.eyelet is not None,
        f"the fingers of {belief.robot}, {fingers.name!r}, have no eyelet; lead wires with a "
        "robot whose fingers have one",
    )


@dataclass(frozen=True)
class DiscardGoal:
    """Take a wire off the panel; an empty `cable_id` means the one in the hand."""

    robot_name: str
    cable_id: str

    def __post_init__(self) -> None:
        """Refuse unknown robots."""
        require_robot(self.robot_name)

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when nothing is held, or a hand holds what it must place first."""
        if not self.cable_id:
            check_held(belief)
        elif panel.wire(self.cable_id).id not in belief.fed:
            return  # there is nothing to discard
        if belief.feed is not None and self.cable_id not in ("", belief.feed.wire_id):
            check_hands_empty(belief)
        for robot, grip in belief.hands.items():
            if robot != belief.robot:
                raise AbilityError(
                    Code.OTHER_CABLE_HELD,
                    f"{robot} holds end {grip.end.value}; have it placed first",
                )


@dataclass(frozen=True)
class PlacePinGoal:
    """Lay the live wire's two pins at two connectors, with two robots.

    The wire's pins are its two ferrules. They go to two neighbouring connectors, `connector_space`
    apart; poses of the path lie between them, `path_space` apart from the first connector on. The
    row runs along the panel's x axis, or along y when it is rotated, from the panel's origin, or
    with its middle there when it is centered.
    """

    robot_1: str
    robot_2: str
    path_space: float
    connector_space: float
    centered: bool
    rotate: bool
    show_in_tf: bool

    def __post_init__(self) -> None:
        """Refuse one robot twice."""
        require(
            self.robot_1 != self.robot_2,
            f"robot_1_name and robot_2_name are both {self.robot_1!r}; it takes two robots",
        )

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when a robot cannot lay the live wire there; asked for each of the two."""
        wires = parameters.wire
        require_number("path_space", self.path_space, *wires.path_space_range_m, "m")
        require_number("connector_space", self.connector_space, *wires.connector_space_range_m, "m")
        require(
            self.path_space <= self.connector_space,
            f"path_space is {self.path_space:g} m; allowed: up to connector_space, "
            f"{self.connector_space:g} m",
        )
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
        self._check_length(wire, wires.pin_slack_range_m)
        for name, pose in pin_row(self, wire, panel).items():
            self._check_place(name, pose, panel, parameters.tool.finger_room_m)
            if name.startswith("pin"):
                x, y, z = (float(v) for v in pose.position - pose.rotation[:, 0] * GRASP_DISTANCE_M)
                check_reach(belief.arm, ToolPose(x, y, z, pose.yaw))

    def _check_length(self, wire: PanelWire, slacks: tuple[float, float]) -> None:
        least, most = (round(wire.length - slack, 4) for slack in reversed(slacks))
        require(
            least <= self.connector_space <= most,
            f"connector_space is {self.connector_space:g} m; {wire.id!r} is {wire.length:g} m "
            f"long, allowed: {least:g} to {most:g} m",
        )

    def _check_place(self, name: str, pose: Pose, panel: Panel, room_m: float) -> None:
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
                float(beside.max()) > room_m,
                f"{name} would lie at x {x:.3f}, y {y:.3f} m of the panel, nearer than "
                f"{room_m * 1e3:.0f} mm to component {component.id!r}; rotate or center the row",
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


def find_demand_problems(
    robots: Collection[str],
    forces_n: Mapping[str, float],
    there: Collection[str],
    tool: ToolParameters,
) -> Iterator[str]:
    """Yield why goals of an order would be refused, one sentence each.

    Args:
        robots: that its goals name.
        forces_n: the greatest force limit [N] of its goals, by the ability.
        there: names of the cell's robots.
        tool: what their grips hold.
    """
    for robot in robots:
        if robot not in there:
            yield f"the order's goals name robot {robot!r}; the cell has {', '.join(there)}"
    limits_n = {
        "InsertCable": tool.grip_holds_n,
        "PlaceConnector": tool.grip_holds_connector_n,
    }
    for ability, force_n in forces_n.items():
        most_n = limits_n.get(ability, float("inf"))
        if force_n > most_n:
            yield (
                f"the use case has {ability} push with up to {force_n:g} N; this cell's grip "
                f"holds at most {most_n:g} N"
            )
