"""What a robot looks like, read from its URDF.

A link is drawn by the boxes of its visual geometry and by the meshes of its collision geometry,
which have a tenth of the size of the visual ones. Lengths in [m], angles in [rad], frames of the
link; quaternions x, y, z, w.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from dataclasses import dataclass

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
_GREY = "#d4d7db"


@dataclass(frozen=True)
class Shape:
    """A box of a size, or the mesh of a file, scaled; the other field is empty."""

    position: Vector
    rotation: Quaternion
    colour: str
    size: Vector = (1.0, 1.0, 1.0)
    mesh: str = ""


@dataclass(frozen=True)
class Joint:
    """What moves a link against its parent: kind `revolute`, `prismatic` or `fixed`."""

    name: str
    kind: str
    parent: str
    child: str
    position: Vector
    rotation: Quaternion
    axis: Vector


@dataclass(frozen=True)
class RobotModel:
    """The links of a robot and the joints between them; the root has no joint above it."""

    root: str
    shapes: dict[str, tuple[Shape, ...]]
    joints: tuple[Joint, ...]

    @property
    def meshes(self) -> tuple[str, ...]:
        """Return the files of all meshes, each once, in a fixed order."""
        files = (shape.mesh for shapes in self.shapes.values() for shape in shapes)
        return tuple(dict.fromkeys(filter(None, files)))


def read_robot(urdf: str) -> RobotModel:
    """Return the robot that a URDF describes.

    Raises:
        ValueError: if the text is no URDF with exactly one root link.
    """
    try:
        robot = ElementTree.fromstring(urdf)
        shapes = {link.attrib["name"]: tuple(_shapes(link)) for link in robot.iter("link")}
        joints = tuple(_joint(element) for element in robot.findall("joint"))
    except (ElementTree.ParseError, KeyError, AttributeError) as error:
        raise ValueError(f"the robot's description is no URDF: {error!r}") from error
    roots = sorted(set(shapes) - {joint.child for joint in joints})
    if len(roots) != 1:
        raise ValueError(f"the robot's description has the root links {roots}; it needs one")
    return RobotModel(roots[0], shapes, joints)


def _shapes(link: ElementTree.Element) -> Iterator[Shape]:
    yield from filter(lambda shape: not shape.mesh, _of_kind(link, "visual"))
    solid = [shape for shape in _of_kind(link, "collision") if shape.mesh]
    yield from solid or (shape for shape in _of_kind(link, "visual") if shape.mesh)


def _of_kind(link: ElementTree.Element, tag: str) -> Iterator[Shape]:
    for element in link.findall(tag):
        position, rotation = _origin(element)
        box, mesh = element.find("geometry/box"), element.find("geometry/mesh")
        if box is not None:
            yield Shape(position, rotation, _colour(element), _vector(box.attrib["size"]))
        elif mesh is not None:
            scale = _vector(mesh.get("scale", "1 1 1"))
            yield Shape(position, rotation, _GREY, scale, mesh.attrib["filename"])


def _joint(element: ElementTree.Element) -> Joint:
    position, rotation = _origin(element)
    parent, child, axis = (element.find(tag) for tag in ("parent", "child", "axis"))
    if parent is None or child is None:
        raise KeyError(f"parent or child of the joint {element.get('name')}")
    kind = element.attrib["type"].replace("continuous", "revolute")
    direction = _vector(axis.attrib["xyz"]) if axis is not None else (1.0, 0.0, 0.0)
    return Joint(
        element.attrib["name"],
        kind,
        parent.attrib["link"],
        child.attrib["link"],
        position,
        rotation,
        axis=direction,
    )


def _origin(element: ElementTree.Element) -> tuple[Vector, Quaternion]:
    origin = element.find("origin")
    if origin is None:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
    return _vector(origin.get("xyz", "0 0 0")), _quaternion(_vector(origin.get("rpy", "0 0 0")))


def _vector(text: str) -> Vector:
    x, y, z = map(float, text.split())
    return x, y, z


def _quaternion(rpy: Vector) -> Quaternion:
    """Return fixed-axis roll, pitch and yaw as a quaternion (REP 103)."""
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(a / 2), math.cos(a / 2)) for a in rpy)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def _colour(element: ElementTree.Element) -> str:
    colour = element.find("material/color")
    if colour is None:
        return _GREY
    red, green, blue, *_ = (round(255 * float(v)) for v in colour.attrib["rgba"].split())
    return f"#{red:02x}{green:02x}{blue:02x}"
