"""Read the file of a cell's drivers: config/robots/*.yaml, in the form of robot.schema.json."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import rospkg
import yaml

from remodel_states.core.tables import schema_problems
from remodel_work.cell.cell_design import CellDesign
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import CellError

TICK_HZ = 120.0
# A wrist sensor's bandwidth of 20 Hz, as the simulated one has [s].
FILTER_S = 0.008
# As of the simulated hand [m/s].
FINGER_SPEED, FINGER_TOUCH_SPEED = 0.10, 0.012
# Two ticks.
LEAD_S = 2.0 / TICK_HZ
POSE = "geometry_msgs/PoseStamped"


class RobotFileError(CellError):
    """The file of a robot's drivers cannot be read or is invalid."""


@dataclass(frozen=True)
class CameraTopics:
    """The pictures of a camera; depth: None if it measures none."""

    image: str
    depth: str | None = None


@dataclass(frozen=True)
class RobotTopics:
    """What the drivers of one robot publish, and take.

    Attributes:
        joint_states: topic of the measured joints.
        joints: their names there, in the order of the arm's model.
        fingers: the names of the two fingers' joints, and the topic that has them.
        wrench: topic, frame ("hand", "base", "world") and sign of the measured force; 1: that of
            the wrist on the hand.
        filter_s: time constant of the low pass of the force [s].
        motion: topic and type of the commands to the arm.
        lead_s: commands to be somewhere after a tick are due so much later, so that a late one
            shakes nothing [s]. Steps of a push are due at once.
        frame: of commanded poses, "world" or "base", and what the driver calls it.
        gripper: topic and type of the commands to the fingers.
        hand_mass: what the wrist carries [kg].
        finger_speeds: of a finger where nothing is near, and of one about to touch [m/s].
        camera: on the hand.
    """

    joint_states: str
    joints: tuple[str, ...]
    fingers: tuple[str, str]
    fingers_topic: str
    wrench: tuple[str, str, int]
    filter_s: float
    motion: tuple[str, str]
    lead_s: float
    frame: tuple[str, str]
    gripper: tuple[str, str]
    hand_mass: float
    finger_speeds: tuple[float, float]
    camera: CameraTopics


@dataclass(frozen=True)
class CellTopics:
    """The drivers of a cell.

    Attributes:
        file: that says so.
        design: of the cell.
        tick_s: time between two commands to an arm [s].
        robots: by their names in the design.
        overheads: the cameras above the board, in the order of the design.
        operate_clamp, present_wire, operate_magazine: names of services.
        load_panel: the same; None: what holds the board need not know which.
        is_simulated: nothing real moves; the operator console says so.
    """

    file: str
    design: CellDesign
    tick_s: float
    robots: dict[str, RobotTopics]
    overheads: tuple[CameraTopics, ...]
    operate_clamp: str
    load_panel: str | None
    present_wire: str
    operate_magazine: str
    is_simulated: bool


def read_robot(robot: str) -> CellTopics:
    """Read a robot's file: the name of one that the package has, or the path of your own.

    Raises:
        RobotFileError: with everything that is wrong, each with its place, what was found and what
            is allowed.
        CellFileError: of the cell that it names.
    """
    folder = Path(rospkg.RosPack().get_path("remodel_skills")) / "config/robots"
    file = Path(robot) if robot.endswith((".yaml", ".yml")) else folder / f"{robot}.yaml"
    if not file.is_file():
        there_are = ", ".join(sorted(path.stem for path in folder.glob("*.yaml")))
        raise RobotFileError(
            f"robot {robot}: no such robot or file; there are: {there_are}, or the path of a "
            ".yaml file"
        )
    try:
        parsed = yaml.safe_load(file.read_text())
    except (OSError, yaml.YAMLError) as error:
        raise RobotFileError(f"robot {file}: {error}") from error
    schema = json.loads((folder / "robot.schema.json").read_text())
    problems = list(schema_problems(parsed, schema))
    if not problems:
        cell = str(parsed["cell"])
        beside = file.parent / cell
        design = read_cell(str(beside) if beside.is_file() else cell)
        problems = list(_contradictions(parsed, design))
    if problems:
        lines = "\n".join(f"  - {problem}" for problem in problems)
        raise RobotFileError(f"robot {file}: {len(problems)} problems:\n{lines}")
    return _topics(str(file), parsed, design)


def _contradictions(parsed: dict[str, Any], design: CellDesign) -> list[str]:
    """Return where the file does not fit the design of its cell."""
    named, designed = set(parsed["robots"]), {robot.name for robot in design.robots}
    if named != designed:
        return [
            f"robots: found {', '.join(sorted(named))}; cell {design.name} has "
            f"{', '.join(sorted(designed))}"
        ]
    above = 1 + len(parsed.get("also_overhead", ()))
    if above != len(design.overheads):
        return [
            f"overhead, also_overhead: found {above} cameras; cell {design.name} has "
            f"{len(design.overheads)} above the board"
        ]
    without_depth = [
        f"robots.{robot.name}.camera: found no depth; the camera of cell {design.name} measures it"
        for robot in design.robots
        if robot.camera.depth and "depth" not in parsed["robots"][robot.name]["camera"]
    ]
    return without_depth + [
        f"robots.{robot.name}.joint_states.joints: found {found} names; the arm of cell "
        f"{design.name} has {len(robot.arm.limits[0])} joints"
        for robot in design.robots
        if (found := len(parsed["robots"][robot.name]["joint_states"]["joints"]))
        != len(robot.arm.limits[0])
    ]


def _topics(file: str, parsed: dict[str, Any], design: CellDesign) -> CellTopics:
    fixture, magazine = parsed["fixture"], parsed["magazine"]
    return CellTopics(
        file=file,
        design=design,
        tick_s=1.0 / float(parsed.get("tick_hz", TICK_HZ)),
        robots={name: _robot(robot) for name, robot in parsed["robots"].items()},
        overheads=tuple(map(_camera, (parsed["overhead"], *parsed.get("also_overhead", ())))),
        operate_clamp=fixture["operate_clamp"],
        load_panel=fixture.get("load_panel"),
        present_wire=magazine["present_wire"],
        operate_magazine=magazine["operate"],
        is_simulated=parsed.get("simulated", False),
    )


def _robot(parsed: dict[str, Any]) -> RobotTopics:
    states, wrench, motion = parsed["joint_states"], parsed["wrench"], parsed["motion"]
    frame = motion.get("frame", "world")
    return RobotTopics(
        joint_states=states["topic"],
        joints=tuple(states["joints"]),
        fingers=tuple(states["fingers"]),
        fingers_topic=states.get("fingers_topic", states["topic"]),
        wrench=(wrench["topic"], wrench["frame"], wrench.get("sign", 1)),
        filter_s=float(wrench.get("filter_s", FILTER_S)),
        motion=(motion["topic"], motion["type"]),
        lead_s=float(motion.get("lead_s", LEAD_S)),
        frame=(frame, motion.get("frame_id", frame)),
        gripper=(parsed["gripper"]["topic"], parsed["gripper"]["type"]),
        hand_mass=float(parsed["hand_mass"]),
        finger_speeds=(
            float(parsed["gripper"].get("speed", FINGER_SPEED)),
            float(parsed["gripper"].get("touch_speed", FINGER_TOUCH_SPEED)),
        ),
        camera=_camera(parsed["camera"]),
    )


def _camera(parsed: dict[str, str]) -> CameraTopics:
    return CameraTopics(parsed["image"], parsed.get("depth"))
