"""The arm's description.

Pybullet_data's Franka Panda with the cell's own fingers and wrist camera.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pybullet_data

from remodel_sim.core.arm import TOOL_M

FINGER_ROOT_M = 0.0584  # hand frame to finger frame, as in the original
PAD_BELOW_TOOL_M = 0.003  # the pads reach this far below the tool centre: half the thickest wire
PAD_HEIGHT_M = 0.014
PAD_LENGTH_M = 0.018  # along the wire
PAD_THICKNESS_M = 0.004
STEM_THICKNESS_M = 0.008
# Camera housing on the side of the hand; the lens looks straight down. Hand frame.
CAMERA_MOUNT = (0.0, 0.118, 0.045)


def robot_description() -> str:
    """Return the URDF as text, with absolute mesh paths."""
    folder = Path(pybullet_data.getDataPath()) / "franka_panda"
    text = (folder / "panda.urdf").read_text().replace("package://meshes", f"{folder}/meshes")
    root = ElementTree.fromstring(text)
    links = {link.get("name"): link for link in root.iter("link")}
    for name, side in (("panda_leftfinger", 1), ("panda_rightfinger", -1)):
        _replace_finger(links[name], side)
    _add_camera(links["panda_hand"])
    return ElementTree.tostring(root, encoding="unicode")


def _replace_finger(link: ElementTree.Element, side: int) -> None:
    for child in list(link):
        if child.tag in ("visual", "collision", "contact"):
            link.remove(child)
    tip = TOOL_M - FINGER_ROOT_M + PAD_BELOW_TOOL_M
    pad_y = side * PAD_THICKNESS_M / 2
    stem_length = tip - PAD_HEIGHT_M / 2
    stem_y = side * (PAD_THICKNESS_M + STEM_THICKNESS_M / 2 - 0.001)
    pad = (PAD_LENGTH_M, PAD_THICKNESS_M, PAD_HEIGHT_M)
    stem = (0.012, STEM_THICKNESS_M, stem_length)
    _add_box(link, "visual", (0, stem_y, stem_length / 2), stem, (0.82, 0.83, 0.85))
    _add_box(link, "visual", (0, pad_y, tip - PAD_HEIGHT_M / 2), pad, (0.15, 0.15, 0.16))
    _add_box(link, "collision", (0, stem_y, stem_length / 2), stem)
    _add_box(link, "collision", (0, pad_y, tip - PAD_HEIGHT_M / 2), pad)


def _add_camera(hand: ElementTree.Element) -> None:
    x, y, z = CAMERA_MOUNT
    _add_box(hand, "visual", (x, y - 0.006, z - 0.016), (0.05, 0.022, 0.024), (0.2, 0.2, 0.22))


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
