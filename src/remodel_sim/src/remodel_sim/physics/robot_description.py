"""Descriptions of the arms.

Pybullet_data's Franka Panda or KUKA iiwa, either with the Panda's hand, and on it the cell's own
fingers and a wrist camera; below it a linear axis, if the arm has one.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pybullet_data

from remodel_sim.core.robot.arm import FRANKA_PANDA, KUKA_IIWA, Arm
from remodel_sim.core.robot.fingers import Fingers
from remodel_sim.core.robot.linear_axis import LinearAxis
from remodel_sim.core.workpiece.component_shape import Box

FINGER_ROOT_M = 0.0584  # hand frame to finger frame, as in the original
STEEL = (0.82, 0.83, 0.85)
RUBBER = (0.15, 0.15, 0.16)
# Camera housing on the side of the hand; the lens looks straight down. Hand frame.
CAMERA_MOUNT = (0.0, 0.118, 0.045)


HAND = "panda_hand"
FINGERS = ("panda_leftfinger", "panda_rightfinger")
# A linear axis is a rail, and on it a prismatic joint that carries the base.
RAIL = "axis_rail"
AXIS_JOINT = "axis"
AXIS_FORCE_N = 2000.0
RAIL_WIDTH_M = 0.20
RAIL_HEIGHT_M = 0.03
RAIL_MASS_KG = 50.0
BASE_LINKS = {FRANKA_PANDA.name: "panda_link0", KUKA_IIWA.name: "lbr_iiwa_link_0"}
# The iiwa's flange is this far beyond the frame of its last link [m], which is turned by half a
# turn; the hand is turned back to the yaw that the arm's model has for joint 7 at zero [rad].
IIWA_FLANGE_M = 0.045
IIWA_HAND_TURN = math.pi - KUKA_IIWA.yaw_zero


def robot_description(arm: Arm) -> str:
    """Return the URDF of an arm with its hand and fingers as text, with absolute mesh paths."""
    data = Path(pybullet_data.getDataPath())
    root = _read(data / "franka_panda/panda.urdf", "package://meshes")
    if arm.model == KUKA_IIWA:
        root = _with_hand_of(_read(data / "kuka_iiwa/model.urdf", "meshes"), root)
    links = {link.get("name"): link for link in root.iter("link")}
    for name, side in zip(FINGERS, (1, -1), strict=True):
        _replace_finger(links[name], arm.fingers, side)
    for limit in root.findall("joint[@type='prismatic']/limit"):
        limit.set("upper", f"{arm.fingers.opening / 2:g}")
    _add_camera(links[HAND])
    if arm.axis is not None:
        _put_on_axis(root, BASE_LINKS[arm.model.name], arm.axis)
    return ElementTree.tostring(root, encoding="unicode")


def _read(file: Path, meshes: str) -> ElementTree.Element:
    """Read a description; `meshes` begins its mesh paths, for the folder of that name beside it."""
    text = file.read_text().replace(f'filename="{meshes}', f'filename="{file.parent}/meshes')
    return ElementTree.fromstring(text)


def _with_hand_of(iiwa: ElementTree.Element, panda: ElementTree.Element) -> ElementTree.Element:
    """Bolt the Panda's hand to the iiwa's flange."""
    parts = (HAND, *FINGERS)
    iiwa.extend(link for link in panda.iter("link") if link.get("name") in parts)
    for joint in panda.iter("joint"):
        child, parent, origin = (joint.find(tag) for tag in ("child", "parent", "origin"))
        if child is None or parent is None or child.get("link") not in parts:
            continue
        if child.get("link") == HAND and origin is not None:
            parent.set("link", "lbr_iiwa_link_7")
            origin.set("xyz", f"0 0 {IIWA_FLANGE_M}")
            origin.set("rpy", f"0 0 {IIWA_HAND_TURN:.8f}")
        iiwa.append(joint)
    return iiwa


def _put_on_axis(root: ElementTree.Element, base: str, axis: LinearAxis) -> None:
    """Add a rail below the arm, for the eye only, and the joint that moves its base along y."""
    rail = ElementTree.SubElement(root, "link", name=RAIL)
    inertial = ElementTree.SubElement(rail, "inertial")
    ElementTree.SubElement(inertial, "mass", value=f"{RAIL_MASS_KG:g}")
    ElementTree.SubElement(
        inertial, "inertia", ixx="1", ixy="0", ixz="0", iyy="1", iyz="0", izz="1"
    )
    length = axis.upper - axis.lower + RAIL_WIDTH_M
    middle = (0.0, (axis.lower + axis.upper) / 2, -RAIL_HEIGHT_M / 2)
    _add_box(rail, "visual", middle, (RAIL_WIDTH_M, length, RAIL_HEIGHT_M), rgb=STEEL)
    joint = ElementTree.SubElement(root, "joint", name=AXIS_JOINT, type="prismatic")
    ElementTree.SubElement(joint, "parent", link=RAIL)
    ElementTree.SubElement(joint, "child", link=base)
    ElementTree.SubElement(joint, "axis", xyz="0 1 0")
    limits = {"lower": axis.lower, "upper": axis.upper, "velocity": axis.speed}
    limits["effort"] = AXIS_FORCE_N
    ElementTree.SubElement(joint, "limit", {name: f"{v:g}" for name, v in limits.items()})


def _replace_finger(link: ElementTree.Element, fingers: Fingers, side: int) -> None:
    for child in list(link):
        if child.tag in ("visual", "collision", "contact"):
            link.remove(child)
    for box in _finger_boxes(fingers):
        x, y, z = box.centre
        _add_box(link, "visual", (x, side * y, z), box.size, rgb=box.rgb)
    for box in _finger_boxes(fingers):
        x, y, z = box.centre
        _add_box(link, "collision", (x, side * y, z), box.size)


def _finger_boxes(fingers: Fingers) -> list[Box]:
    """Return a finger's boxes: z down from its root, y outward from the face that grips."""
    tip, stem = fingers.tip_m - FINGER_ROOT_M, fingers.stem
    pad = tip - fingers.pad_height
    stem_length = tip - fingers.pad_height / 2
    stem_size = (stem.width, stem.thickness, stem_length)
    boxes = [
        Box((0.0, stem.behind + stem.thickness / 2, stem_length / 2), stem_size, STEEL),
        _part_of_tip(fingers, 0.0, fingers.thickness, pad, tip),
    ]
    if fingers.notch is not None:
        tool, half = tip - fingers.below, fingers.notch.height / 2
        for top, bottom in ((pad, tool - half), (tool + half, tip)):
            boxes.append(_part_of_tip(fingers, -fingers.notch.depth, 0.0, top, bottom))
    return boxes


def _part_of_tip(fingers: Fingers, inner: float, outer: float, top: float, bottom: float) -> Box:
    centre = (0.0, (inner + outer) / 2, (top + bottom) / 2)
    return Box(centre, (fingers.width, outer - inner, bottom - top), RUBBER)


def _add_camera(hand: ElementTree.Element) -> None:
    x, y, z = CAMERA_MOUNT
    _add_box(hand, "visual", (x, y - 0.006, z - 0.016), (0.05, 0.022, 0.024), rgb=(0.2, 0.2, 0.22))


def _add_box(
    link: ElementTree.Element,
    tag: str,
    centre: tuple[float, float, float],
    size: tuple[float, float, float],
    rgb: tuple[float, float, float] | None = None,
) -> None:
    element = ElementTree.SubElement(link, tag)
    ElementTree.SubElement(element, "origin", xyz="{:.5f} {:.5f} {:.5f}".format(*centre))
    geometry = ElementTree.SubElement(element, "geometry")
    ElementTree.SubElement(geometry, "box", size="{:.5f} {:.5f} {:.5f}".format(*size))
    if rgb is not None:
        material = ElementTree.SubElement(element, "material", name="rgb_{}_{}_{}".format(*rgb))
        ElementTree.SubElement(material, "color", rgba="{} {} {} 1".format(*rgb))
