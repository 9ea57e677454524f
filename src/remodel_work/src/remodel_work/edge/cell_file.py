"""Read a cell's file: config/cells/*.yaml, in the form of config/cells/cell.schema.json."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import rospkg
import yaml

from remodel_states.core.cell import CellLimits
from remodel_states.core.tables import schema_problems
from remodel_work.camera import Lens, View, looking_at, looking_down
from remodel_work.cell.cell_design import (
    CellDesign,
    Gripper,
    RobotDesign,
    Table,
    WristCamera,
    find_design_problems,
)
from remodel_work.cell.presenting import Feeder, Magazine
from remodel_work.errors import CellFileError
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, Duct, PanelClip
from remodel_work.robot.arm import ARM_MODELS, Arm, Kinematics, LinearAxis, ToolPose
from remodel_work.robot.fingers import PANDA_FINGERS, Eyelet, Fingers, Stem
from remodel_work.robot.portal import Portal


def read_cell(cell: str = "one_panda") -> CellDesign:
    """Read a cell: the name of one that the package has, or the path of a file of your own.

    Raises:
        CellFileError: with everything that is wrong, each with its place, what was found and what
            is allowed.
    """
    folder = Path(rospkg.RosPack().get_path("remodel_work")) / "config/cells"
    file = Path(cell) if cell.endswith((".yaml", ".yml")) else folder / f"{cell}.yaml"
    if not file.is_file():
        there_are = ", ".join(sorted(path.stem for path in folder.glob("*.yaml")))
        raise CellFileError(
            cell, (f"no such cell or file; there are: {there_are}, or the path of a .yaml file",)
        )
    try:
        parsed = yaml.safe_load(file.read_text())
    except (OSError, yaml.YAMLError) as error:
        raise CellFileError(str(file), (str(error),)) from error
    problems = tuple(schema_problems(parsed, json.loads((folder / "cell.schema.json").read_text())))
    if problems:
        raise CellFileError(str(file), problems)
    design = _design(parsed)
    problems = find_design_problems(design)
    if problems:
        raise CellFileError(str(file), problems)
    return design


def _design(parsed: dict[str, Any]) -> CellDesign:
    overhead, scene = parsed["cameras"]["overhead"], parsed["cameras"]["scene"]
    table, fixtures = parsed["table"], parsed["fixtures"]
    return CellDesign(
        name=parsed["name"],
        takes=CellLimits.stated(parsed["name"], parsed["takes"]),
        robots=tuple(_robot(robot) for robot in parsed["robots"]),
        overheads=tuple(
            View(_lens(overhead), looking_down(*_point(at), math.radians(overhead["up_yaw_deg"])))
            for at in (overhead["at"], *overhead.get("also_at", ()))
        ),
        scene=View(
            _lens(scene),
            looking_at(np.array(_point(scene["at"])), np.array(_point(scene["looks_at"]))),
        ),
        table=Table(*(float(table[key]) for key in ("x", "y", "length", "width"))),
        feeder=_feeder(parsed["feeder"]) if "feeder" in parsed else None,
        clips=tuple(
            PanelClip(**{**clip, "pose": _flat_pose(clip["pose"])}) for clip in fixtures["clips"]
        ),
        ducts=tuple(
            Duct(**{**duct, "pose": _flat_pose(duct["pose"])}) for duct in fixtures["ducts"]
        ),
        magazine=_magazine(parsed["magazine"]) if "magazine" in parsed else None,
        labels=parsed.get("labels", True),
        world_from_panel=_board(parsed["board"]) if "board" in parsed else BOARD,
    )


def _board(parsed: dict[str, float]) -> Pose:
    yaw = math.radians(parsed.get("yaw_deg", 0.0))
    return Pose.level(float(parsed["x"]), float(parsed["y"]), 0.0, yaw)


def _feeder(parsed: dict[str, Any]) -> Feeder:
    fork = parsed["fork"]
    return Feeder(
        float(parsed["overlap"]),
        *(float(fork[key]) for key in ("behind_tip", "length", "height", "post", "clearance")),
    )


def _magazine(parsed: dict[str, Any]) -> Magazine:
    return Magazine(*(float(parsed[key]) for key in ("x", "height", "span", "y_min", "y_max")))


def _robot(parsed: dict[str, Any]) -> RobotDesign:
    camera = parsed["camera"]
    return RobotDesign(
        name=parsed["name"],
        arm=_kinematics(parsed),
        home=ToolPose(*_placed(parsed["home"])),
        gripper=Gripper(
            float(parsed["gripper"]["grip_force"]), float(parsed["gripper"]["pad_friction"])
        ),
        camera=WristCamera(camera["name"], _lens(camera), camera.get("depth", False)),
        prefix=parsed["prefix"],
        scrap_bin=ToolPose(*_placed(parsed["scrap_bin"])) if "scrap_bin" in parsed else None,
        clearance=float(parsed["clearance"]) if "clearance" in parsed else None,
    )


def _kinematics(parsed: dict[str, Any]) -> Kinematics:
    base, fingers = _placed(parsed["base"]), _fingers(parsed["gripper"])
    if parsed["arm"] == "portal":
        lower, upper = (_point(parsed["travel"][key]) for key in ("lower", "upper"))
        return Portal(base, lower, upper, fingers)
    limits = parsed.get("limits", {"lower_deg": (), "upper_deg": ()})
    least, most = (
        tuple(math.radians(angle) for angle in limits[key]) for key in ("lower_deg", "upper_deg")
    )
    model = ARM_MODELS[parsed["arm"]]
    return Arm(model, base, least, most, fingers=fingers, axis=_axis(parsed))


def _axis(robot: dict[str, Any]) -> LinearAxis | None:
    if "axis" not in robot:
        return None
    return LinearAxis(*(float(robot["axis"][key]) for key in ("lower", "upper", "speed")))


def _fingers(gripper: dict[str, Any]) -> Fingers:
    if "fingers" not in gripper:
        return PANDA_FINGERS
    parsed = gripper["fingers"]
    eyelet = Eyelet(**parsed["eyelet"]) if "eyelet" in parsed else None
    return Fingers(**{**parsed, "stem": Stem(**parsed["stem"]), "eyelet": eyelet})


def _lens(parsed: dict[str, Any]) -> Lens:
    return Lens(parsed["width"], parsed["height"], math.radians(parsed["field_of_view_deg"]))


def _point(parsed: dict[str, float]) -> tuple[float, float, float]:
    return float(parsed["x"]), float(parsed["y"]), float(parsed["z"])


def _placed(parsed: dict[str, float]) -> tuple[float, float, float, float]:
    return *_point(parsed), math.radians(parsed["yaw_deg"])


def _flat_pose(parsed: list[float]) -> tuple[float, float, float]:
    x, y, yaw_deg = parsed
    return float(x), float(y), math.radians(yaw_deg)
