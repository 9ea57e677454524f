"""A cell as a value: its arms and hands, its cameras, its feeder and its own fixtures.

Everything stands in the world's frame, whose z = 0 is the plate's surface; the middle of the plate
lies at `world_from_panel`. Components, sockets and wires are the panel's, not the cell's. Beside
the plate stands each robot's scrap bin, where no wire is placed.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from remodel_states.core.cell import CellLimits, Footprint, footprint
from remodel_states.core.codes import Code
from remodel_work.camera import Lens, View, overhead_name
from remodel_work.cell.presenting import (
    LEAST_FREE_M,
    Feeder,
    Magazine,
    find_wire_problems,
    held_length,
)
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.layout import find_problems
from remodel_work.panel import BOARD, Duct, Panel, PanelClip
from remodel_work.robot.arm import Arm, Kinematics, ToolPose

# Two bases need this much room between them [m].
BASES_APART_M = 0.50
# A bin stands so far beside the plate, or further [m]: what is dropped clears the edge.
BIN_ROOM_M = 0.05
# A feeder lays wires along y, in channels that are turned from it by no more: at the farthest
# terminal, 0.30 m from the middle, that is 26 mm, half of the way to a channel's edge.
FED_TURN_RAD = math.radians(5.0)
# There are so many labels: DICT_4X4_250.
MARKERS = 250


@dataclass(frozen=True)
class Gripper:
    """How a parallel hand grips; its fingers are the arm's.

    Attributes:
        grip_force: per finger at which closing stops [N].
        pad_friction: Coulomb's, of the pads.
    """

    grip_force: float
    pad_friction: float


@dataclass(frozen=True)
class WristCamera:
    """A camera on the side of a hand that looks straight down; its name is part of its topics.

    Attributes:
        depth: whether it measures depth, beside colour.
    """

    name: str
    lens: Lens
    depth: bool = False


@dataclass(frozen=True)
class RobotDesign:
    """An arm with a hand.

    Attributes:
        name: as goals name it, such as "robot_1".
        arm: in its place.
        home: where the empty hand goes, out of the overhead camera's picture.
        gripper: its hand.
        camera: on its hand.
        prefix: put before the names of its frames and joints.
        scrap_bin: where the hand drops wires into its scrap bin; None: beside the plate.
        clearance: that motions keep to what stands on the plate [m]; None: they are not checked.
    """

    name: str
    arm: Kinematics
    home: ToolPose
    gripper: Gripper
    camera: WristCamera
    prefix: str
    scrap_bin: ToolPose | None = None
    clearance: float | None = None


@dataclass(frozen=True)
class Table:
    """What the plate lies on, to be seen only: its middle, and its size along x and y [m]."""

    x: float
    y: float
    length: float
    width: float


@dataclass(frozen=True, eq=False)
class CellDesign:
    """All of a cell but its panel.

    Attributes:
        name: of the cell.
        takes: the boards and wires that it can wire.
        robots: one or two.
        overheads: cameras for colour and depth that together see the whole plate.
        scene: camera for people.
        table: under the plate.
        feeder: lays wires; None where a magazine presents them.
        clips, ducts: the cell's own, besides the panel's; panel frame.
        magazine: presents wires beside the plate; None: the feeder does.
        labels: whether components carry labels; else they are located by their shape.
        world_from_panel: where the board lies, level: the middle of its surface.
    """

    name: str
    takes: CellLimits
    robots: tuple[RobotDesign, ...]
    overheads: tuple[View, ...]
    scene: View
    table: Table
    feeder: Feeder | None
    clips: tuple[PanelClip, ...]
    ducts: tuple[Duct, ...]
    magazine: Magazine | None = None
    labels: bool = True
    world_from_panel: Pose = BOARD

    @property
    def arms(self) -> tuple[Kinematics, ...]:
        """The robots' arms."""
        return tuple(robot.arm for robot in self.robots)

    @property
    def overhead_names(self) -> tuple[str, ...]:
        """The cameras above the plate."""
        return tuple(map(overhead_name, range(len(self.overheads))))

    @property
    def camera_names(self) -> tuple[str, ...]:
        """All cameras: from above, on the wrists, and for people."""
        return (*self.overhead_names, *(robot.camera.name for robot in self.robots), "scene")


def find_design_problems(design: CellDesign) -> tuple[str, ...]:
    """Return every problem of a cell, one sentence each: place, found, allowed."""
    return (
        *_names(design),
        *_labels(design),
        *_axes(design),
        *_fingers(design),
        *_homes(design),
        *_bins(design),
        *_bases(design),
        *_presenting(design),
    )


def _names(design: CellDesign) -> Iterator[str]:
    groups = {
        "name": [robot.name for robot in design.robots],
        "camera.name": list(design.camera_names),
        "prefix": [robot.prefix for robot in design.robots],
    }
    for what, names in groups.items():
        for name, count in Counter(names).items():
            if count > 1:
                yield f"robots: {count} have {what} {name!r}; each needs its own"


def _labels(design: CellDesign) -> Iterator[str]:
    if design.labels and design.takes.devices > MARKERS:
        yield (
            f"takes.devices: found {design.takes.devices}; allowed: up to {MARKERS}, as many as "
            "there are labels, or labels: false"
        )


def _axes(design: CellDesign) -> Iterator[str]:
    for i, robot in enumerate(design.robots):
        axis = robot.arm.axis
        if axis is not None and not axis.lower < axis.upper:
            yield (
                f"robots[{i}].axis: found lower {axis.lower}, upper {axis.upper}; allowed: lower "
                "less than upper"
            )


def _fingers(design: CellDesign) -> Iterator[str]:
    for i, robot in enumerate(design.robots):
        fingers = robot.arm.fingers
        place, eyelet = f"robots[{i}].gripper.fingers", fingers.eyelet
        least = fingers.below
        if eyelet is not None:
            least += eyelet.above + eyelet.height / 2
            lowest = round(eyelet.height / 2 + eyelet.bevel, 6)
            if eyelet.above < lowest:
                yield (
                    f"{place}.eyelet.above: found {eyelet.above}; allowed: {lowest} or more: the "
                    "pads below it and its bevel grip"
                )
        if fingers.pad_height < least:
            yield (
                f"{place}.pad_height: found {fingers.pad_height}; allowed: {least:.5g} or more: "
                "from the tips to above the wire and the eyelet"
            )
        if fingers.pad_height > fingers.length:
            yield f"{place}.pad_height: found {fingers.pad_height}; allowed: up to the length"


def _homes(design: CellDesign) -> Iterator[str]:
    for i, robot in enumerate(design.robots):
        lower, higher = robot.arm.limits
        wide: Sequence[tuple[float, float]] = ()
        if isinstance(robot.arm, Arm):
            lower, higher = lower[-7:], higher[-7:]
            wide = tuple(zip(robot.arm.model.lower, robot.arm.model.higher, strict=True))
        for j, (least, most) in enumerate(wide):
            if not least <= lower[j] <= higher[j] <= most:
                yield (
                    f"robots[{i}].limits: joint {j + 1} has {lower[j]:.4f} to {higher[j]:.4f} rad; "
                    f"allowed within {least:.4f} to {most:.4f} rad"
                )
        for name, tool in (("home", robot.home), ("scrap_bin", robot.scrap_bin)):
            try:
                if tool is not None:
                    robot.arm.joints_for(tool)
            except AbilityError as error:
                yield f"robots[{i}].{name}: {error}"


def _bins(design: CellDesign) -> Iterator[str]:
    plate = design.takes.plate
    taken = _plate_at(design.world_from_panel, plate)
    for i, robot in enumerate(design.robots):
        if robot.scrap_bin is None:
            continue
        x, y = at = robot.scrap_bin.position[:2]
        if np.maximum(taken.low - at, at - taken.high).max() < BIN_ROOM_M - 1e-9:
            yield (
                f"robots[{i}].scrap_bin: found x {x:.3f}, y {y:.3f} m; allowed: {BIN_ROOM_M} m or "
                f"more beside the largest plate that the cell takes, {plate[0]:.2f} x "
                f"{plate[1]:.2f} m; or let it take smaller ones (takes.plate)"
            )


def _plate_at(place: Pose, size: tuple[float, float]) -> Footprint:
    """Return the rectangle along the world's axes around a plate of a size [m]."""
    x, y, _ = (float(v) for v in place.position)
    return footprint((x, y), size, place.yaw)


def _presenting(design: CellDesign) -> Iterator[str]:
    magazine, yaw = design.magazine, design.world_from_panel.yaw
    if design.feeder is not None and abs(yaw) > FED_TURN_RAD + 1e-9:
        yield (
            f"board.yaw_deg: found {round(math.degrees(yaw), 3):g}; allowed: within "
            f"{math.degrees(FED_TURN_RAD):g} of 0, since the feeder lays wires along y"
        )
    if (magazine is None) == (design.feeder is None):
        found = "both" if magazine is not None else "none"
        yield f"feeder, magazine: found {found}; allowed: one of them"
    if magazine is not None and magazine.y_max - magazine.y_min < magazine.span:
        yield (
            f"magazine: y_min {magazine.y_min:.3f} to y_max {magazine.y_max:.3f} m; a wire with a "
            f"span of {magazine.span:.3f} m needs as much"
        )
    if magazine is None:
        return
    least, presented = design.takes.wire_length[0], 2 * held_length() + LEAST_FREE_M
    if least < presented - 1e-9:
        yield (
            f"takes.wire_length.least: found {least:g} m; allowed: {presented:g} m or more, since "
            "the magazine presents no shorter ones"
        )


def _bases(design: CellDesign) -> Iterator[str]:
    standing = [robot for robot in design.robots if isinstance(robot.arm, Arm)]
    for first, second in combinations(standing, 2):
        (xa, ya, *_), (xb, yb, *_) = first.arm.base, second.arm.base
        apart = math.hypot(xb - xa, yb - ya)
        if apart < BASES_APART_M:
            yield (
                f"robots: the bases of {first.name!r} and {second.name!r} are {apart:.2f} m apart; "
                f"allowed: {BASES_APART_M:.2f} m or more"
            )


def held_panel(design: CellDesign, panel: Panel) -> Panel:
    """Return a panel where a cell holds it, with the cell's own fixtures."""
    return replace(
        panel,
        clips=(*panel.clips, *design.clips),
        ducts=(*panel.ducts, *design.ducts),
        world_from_panel=design.world_from_panel,
    )


def find_panel_problems(design: CellDesign, panel: Panel) -> tuple[str, ...]:
    """Return why a cell cannot hold a panel, one sentence each; none: it can."""
    held = held_panel(design, panel)
    problems = find_problems(
        held,
        design.arms,
        design.takes,
        has_magazine=design.magazine is not None,
        has_labels=design.labels,
    )
    if design.magazine is None or problems:
        return tuple(problems)
    return tuple(find_wire_problems(held))


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
    low, high = _plate_at(panel.world_from_panel, panel.size[:2])
    y = high[1] + BEYOND_EDGE_M if robot.home.y >= middle_y else low[1] - BEYOND_EDGE_M
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
