"""Descriptions of the arms.

Pybullet_data's Franka Panda or KUKA iiwa, or a portal, each with the Panda's hand, and on it the
cell's own fingers and a wrist camera; below an arm a linear axis, if it has one.
"""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path

import pybullet_data

from remodel_work.component_shape import Box
from remodel_work.robot.arm import FRANKA_PANDA, KUKA_IIWA, Arm, Kinematics, LinearAxis
from remodel_work.robot.fingers import CAMERA_MOUNT, Eyelet, Fingers
from remodel_work.robot.portal import JOINT_NAMES, TURN_RAD, Portal

FINGER_ROOT_M = 0.0584  # hand frame to finger frame, as in the original
STEEL = (0.82, 0.83, 0.85)
RUBBER = (0.15, 0.15, 0.16)
BEVEL_THICKNESS_M = 0.001

HAND = "panda_hand"
FINGERS = ("panda_leftfinger", "panda_rightfinger")
# A finger's contacts are stiff and damped, for what it grips. Around each lies a sheath of the same
# shape for its contacts with parked wires, which yield: a link of its own, of this mass [kg].
SHEATHS = tuple(f"{finger}_sheath" for finger in FINGERS)
SHEATH_KG = 1e-3
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


# A portal's ram hangs from so far above the tool where the z axis stands lowest [m]: the beams are
# above the overhead camera, and not drawn.
RAM_WIDTH_M = 0.05
RAM_LENGTH_M = 0.9
PORTAL_FRAME = "portal_frame"
PORTAL_LINK_KG = 10.0


def robot_description(arm: Kinematics, *, sheaths: bool = False) -> str:
    """Return the URDF of a robot with its hand and fingers as text, with absolute mesh paths.

    `sheaths`: whether its fingers have them.
    """
    data = Path(pybullet_data.getDataPath())
    root = _read(data / "franka_panda/panda.urdf", "package://meshes")
    if isinstance(arm, Portal):
        root = _with_hand_of(_portal(arm), root, JOINT_NAMES[-1], (0.0, 0.0, arm.fingers.tool_m))
    elif _is_iiwa(arm):
        iiwa = _read(data / "kuka_iiwa/model.urdf", "meshes")
        root = _with_hand_of(iiwa, root, "lbr_iiwa_link_7", (0.0, 0.0, IIWA_FLANGE_M))
    links = {link.get("name"): link for link in root.iter("link")}
    for finger, sheath, side in zip(FINGERS, SHEATHS, (1, -1), strict=True):
        _replace_finger(links[finger], arm.fingers, side)
        if sheaths:
            _add_sheath(root, links[finger], sheath)
    for joint in root.iter("joint"):
        child, limit = joint.find("child"), joint.find("limit")
        if child is not None and limit is not None and child.get("link") in FINGERS:
            limit.set("upper", f"{arm.fingers.opening / 2:g}")
    _add_camera(links[HAND])
    if arm.axis is not None:
        _put_on_axis(root, foot_link(arm), arm.axis)
    return ElementTree.tostring(root, encoding="unicode")


def _read(file: Path, meshes: str) -> ElementTree.Element:
    """Read a description; `meshes` begins its mesh paths, for the folder of that name beside it."""
    text = file.read_text().replace(f'filename="{meshes}', f'filename="{file.parent}/meshes')
    return ElementTree.fromstring(text)


def foot_link(arm: Kinematics) -> str:
    """Return the link of a robot that its base, or its axis, carries."""
    if isinstance(arm, Portal):
        return PORTAL_FRAME
    assert isinstance(arm, Arm), "an arm or a portal"
    return BASE_LINKS[arm.model.name]


def _is_iiwa(arm: Kinematics) -> bool:
    return isinstance(arm, Arm) and arm.model == KUKA_IIWA


def _with_hand_of(
    robot: ElementTree.Element,
    panda: ElementTree.Element,
    flange: str,
    place: tuple[float, float, float],
) -> ElementTree.Element:
    """Bolt the Panda's hand to another robot's flange, a link, at a place in it [m]."""
    parts = (HAND, *FINGERS)
    robot.extend(link for link in panda.iter("link") if link.get("name") in parts)
    for joint in panda.iter("joint"):
        child, parent, origin = (joint.find(tag) for tag in ("child", "parent", "origin"))
        if child is None or parent is None or child.get("link") not in parts:
            continue
        if child.get("link") == HAND and origin is not None:
            parent.set("link", flange)
            origin.set("xyz", "{:.6f} {:.6f} {:.6f}".format(*place))
            roll, yaw = (math.pi, 0.0) if flange == JOINT_NAMES[-1] else (0.0, IIWA_HAND_TURN)
            origin.set("rpy", f"{roll:.8f} 0 {yaw:.8f}")
        robot.append(joint)
    return robot


def _portal(portal: Portal) -> ElementTree.Element:
    """Return three carriages, one on the other, and what turns the hand, a link per joint."""
    root = ElementTree.Element("robot", name="portal")
    _add_link(root, PORTAL_FRAME)
    parent = PORTAL_FRAME
    limits = [*zip(portal.lower, portal.upper, strict=True), (-TURN_RAD, TURN_RAD)]
    axes = ("1 0 0", "0 1 0", "0 0 1", "0 0 1")
    for name, axis, (lower, upper) in zip(JOINT_NAMES, axes, limits, strict=True):
        link = _add_link(root, name)
        turns = name == JOINT_NAMES[-1]
        joint = ElementTree.SubElement(
            root, "joint", name=name, type="revolute" if turns else "prismatic"
        )
        ElementTree.SubElement(joint, "parent", link=parent)
        ElementTree.SubElement(joint, "child", link=name)
        ElementTree.SubElement(joint, "axis", xyz=axis)
        ElementTree.SubElement(
            joint,
            "limit",
            lower=f"{lower:g}",
            upper=f"{upper:g}",
            velocity="2",
            effort=f"{AXIS_FORCE_N:g}",
        )
        parent = name
    middle = (0.0, 0.0, portal.fingers.tool_m + RAM_LENGTH_M / 2)
    ram = (RAM_WIDTH_M, RAM_WIDTH_M, RAM_LENGTH_M)
    _add_box(link, "visual", middle, ram, rgb=STEEL)
    _add_box(link, "collision", middle, ram)
    return root


def _add_link(
    root: ElementTree.Element, name: str, mass: float = PORTAL_LINK_KG, moment: float = 0.1
) -> ElementTree.Element:
    """Add a link of a mass [kg] and a moment of inertia about every axis [kg m^2]."""
    link = ElementTree.SubElement(root, "link", name=name)
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "mass", value=f"{mass:g}")
    moments = {name: f"{moment:g}" for name in ("ixx", "iyy", "izz")}
    ElementTree.SubElement(inertial, "inertia", moments | dict.fromkeys(("ixy", "ixz", "iyz"), "0"))
    return link


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
        centre, roll = (x, side * y, z), side * box.rpy[0]
        _add_box(link, "visual", centre, box.size, rgb=box.rgb, roll=roll)
        _add_box(link, "collision", centre, box.size, roll=roll)


def _add_sheath(root: ElementTree.Element, finger: ElementTree.Element, sheath: str) -> None:
    """Fix a link to a finger, with the finger's solids; see SHEATHS."""
    link = _add_link(root, sheath, SHEATH_KG, moment=1e-7)
    # Bullet draws, in white, the solids of a link that has nothing to draw: it gets a speck.
    _add_box(link, "visual", (0.0, 0.0, 0.0), (1e-5, 1e-5, 1e-5), rgb=RUBBER)
    link.extend(copy.deepcopy(finger.findall("collision")))
    joint = ElementTree.SubElement(root, "joint", name=f"{sheath}_joint", type="fixed")
    ElementTree.SubElement(joint, "parent", link=str(finger.get("name")))
    ElementTree.SubElement(joint, "child", link=sheath)


def _finger_boxes(fingers: Fingers) -> Iterator[Box]:
    """Yield a finger's boxes: z down from its root, y outward from the face that grips."""
    tip, stem, eyelet = fingers.tip_m - FINGER_ROOT_M, fingers.stem, fingers.eyelet
    pad, stem_end = tip - fingers.pad_height, tip - fingers.pad_height / 2
    if eyelet is None:
        yield _part_of_tip(fingers, fingers.thickness, pad, tip)
    else:
        # The stem is the back of the eyelet.
        middle = tip - fingers.below - eyelet.above
        stem_end = middle + eyelet.height / 2
        yield _part_of_tip(fingers, eyelet.depth, pad, middle - eyelet.height / 2)
        yield _part_of_tip(fingers, fingers.thickness, stem_end + eyelet.bevel, tip)
        if eyelet.bevel > 0:
            yield _bevel(fingers, eyelet, stem_end)
    stem_size = (stem.width, stem.thickness, stem_end)
    yield Box((0.0, stem.behind + stem.thickness / 2, stem_end / 2), stem_size, STEEL)


def _part_of_tip(fingers: Fingers, outer: float, top: float, bottom: float) -> Box:
    return Box((0.0, outer / 2, (top + bottom) / 2), (fingers.width, outer, bottom - top), RUBBER)


def _bevel(fingers: Fingers, eyelet: Eyelet, top: float) -> Box:
    """Return the slope below a notch, from its back down to the face that grips."""
    length = math.hypot(eyelet.depth, eyelet.bevel)
    down = math.atan2(eyelet.bevel, eyelet.depth)
    # The plate lies below the slope.
    below = BEVEL_THICKNESS_M / 2
    y = eyelet.depth / 2 + below * math.sin(down)
    z = top + eyelet.bevel / 2 + below * math.cos(down)
    size = (fingers.width, length, BEVEL_THICKNESS_M)
    return Box((0.0, y, z), size, RUBBER, rpy=(-down, 0.0, 0.0))


def _add_camera(hand: ElementTree.Element) -> None:
    x, y, z = CAMERA_MOUNT
    _add_box(hand, "visual", (x, y - 0.006, z - 0.016), (0.05, 0.022, 0.024), rgb=(0.2, 0.2, 0.22))


def _add_box(
    link: ElementTree.Element,
    tag: str,
    centre: tuple[float, float, float],
    size: tuple[float, float, float],
    rgb: tuple[float, float, float] | None = None,
    roll: float = 0.0,
) -> None:
    element = ElementTree.SubElement(link, tag)
    place = {"xyz": "{:.5f} {:.5f} {:.5f}".format(*centre), "rpy": f"{roll:.6f} 0 0"}
    ElementTree.SubElement(element, "origin", place)
    geometry = ElementTree.SubElement(element, "geometry")
    ElementTree.SubElement(geometry, "box", size="{:.5f} {:.5f} {:.5f}".format(*size))
    if rgb is not None:
        material = ElementTree.SubElement(element, "material", name="rgb_{}_{}_{}".format(*rgb))
        ElementTree.SubElement(material, "color", rgba="{} {} {} 1".format(*rgb))
