"""The goals of the abilities, valid from birth.

`check` raises when the cell cannot take them as it is now.

Whatever raises here is found before anything moves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from remodel_skills.belief_state import BeliefState, EndState
from remodel_skills.goals.checks import (
    check_clamp,
    check_hand,
    check_held,
    check_live,
    check_opening,
    check_socket,
    check_tool_path,
)
from remodel_skills.goals.requirements import (
    require,
    require_number,
    require_pose,
    require_robot,
)
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import Panel, WireEnd
from remodel_work.routes import clips_along

# What the grip holds safely by friction [N].
MAX_FORCE_N = 25.0
# A connector's ribbed body gives a better hold.
MAX_MATING_FORCE_N = 40.0
GRASP_RANGE_M = (0.020, 0.080)

# The greatest force limit that goals of an ability may have [N].
FORCE_LIMITS_N = {"InsertCable": MAX_FORCE_N, "PlaceConnector": MAX_MATING_FORCE_N}


class Goal(Protocol):
    """What every goal can be asked."""

    def check(self, panel: Panel, belief: BeliefState) -> None:
        """Raise AbilityError when the cell cannot take the goal as it is now."""


@dataclass(frozen=True)
class LocateGoal:
    """Find a component and, unless the id is empty, one of its terminals.

    `view` 0 is the usual viewpoint, more are others.
    """

    component_id: str
    terminal_id: str
    view: int = 0

    def check(self, panel: Panel, belief: BeliefState) -> None:
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

    def check(self, panel: Panel, belief: BeliefState) -> None:
        """Raise when a name is unknown."""
        panel.wire(self.cable_id)
        check_clamp(self.component_id, self.terminal_id, panel)


@dataclass(frozen=True)
class DetectGoal:
    """Find a wire and its loose ends; `view` 0 is the usual viewpoint, more are others."""

    cable_id: str
    view: int = 0

    def check(self, panel: Panel, belief: BeliefState) -> None:
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
        """Refuse unknown robots and impossible distances."""
        require_robot(self.robot_name)
        if self.grasp_distance != 0.0:
            require_number("grasp_distance", self.grasp_distance, *GRASP_RANGE_M, "m")

    def check(self, panel: Panel, belief: BeliefState) -> None:
        """Raise when the end cannot be picked."""
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
        """Refuse unknown robots and poses that are not level."""
        require_robot(self.robot_name)
        require_pose("target_pose", self.target)

    def check(self, panel: Panel, belief: BeliefState) -> None:
        """Raise when nothing is held or the place is out of reach."""
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
        """Refuse unknown robots, an empty path and poses that are not level."""
        require_robot(self.robot_name)
        require(bool(self.path), "path is empty; it must have one pose or more")
        for i, pose in enumerate(self.path):
            require_pose(f"path[{i}]", pose)

    def check(self, panel: Panel, belief: BeliefState) -> None:
        """Raise when nothing is held or a pose is out of reach."""
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
        """Refuse unknown robots, tilted poses, and forces that the grip does not hold."""
        _require_push(self, MAX_FORCE_N)

    def check(self, panel: Panel, belief: BeliefState) -> None:
        """Raise when the end cannot go there."""
        check_live(self.cable_id, panel, belief)
        check_clamp(self.component_id, self.terminal_id, panel)
        connector = panel.wire(self.cable_id).connector_at(self.end)
        if connector is not None:
            raise AbilityError(
                Code.INVALID_GOAL,
                f"end {self.end.value} of {self.cable_id!r} is connector {connector.id!r}; place "
                "it with PlaceConnector",
            )
        check_free(self, self.end, panel, belief)


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
        """Refuse unknown robots, tilted poses, and forces that the grip does not hold."""
        _require_push(self, MAX_MATING_FORCE_N)

    def check(self, panel: Panel, belief: BeliefState) -> None:
        """Raise when the connector does not fit, or cannot go there."""
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
        check_free(self, connector.end, panel, belief)


@dataclass(frozen=True)
class FixGoal:
    """Close a terminal on the end in the hand; a pull test of 0 N means none."""

    robot_name: str
    cable_id: str
    component_id: str
    terminal_id: str
    pull_test_force: float

    def __post_init__(self) -> None:
        """Refuse unknown robots and forces that the grip does not hold."""
        require_robot(self.robot_name)
        require_number("pull_test_force", self.pull_test_force, 0.0, MAX_FORCE_N, unit="N")

    def check(self, panel: Panel, belief: BeliefState) -> None:
        """Raise when nothing is held."""
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
        """Refuse unknown robots and poses that are not level."""
        require_robot(self.robot_name)
        require_pose("socket_pose", self.socket)

    def check(self, panel: Panel, belief: BeliefState) -> None:
        """Raise when the wire or the socket is not there."""
        check_live(self.cable_id, panel, belief)
        check_socket(self.component_id, self.terminal_id, self.socket, panel, belief=belief)


def _require_push(goal: InsertGoal | ConnectGoal, most_n: float) -> None:
    require_robot(goal.robot_name)
    require_pose("socket_pose", goal.socket)
    require_number("force_limit", goal.force_limit, 1.0, most_n, unit="N")


def check_free(
    goal: InsertGoal | ConnectGoal, end: WireEnd, panel: Panel, belief: BeliefState
) -> None:
    """Raise unless a loose end, in the hand or to be picked, may now go into an opening."""
    key = (goal.component_id, goal.terminal_id)
    check_socket(*key, goal.socket, panel, belief)
    check_opening(*key, goal.socket, panel, belief)
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
