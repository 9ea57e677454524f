"""The cell in three dimensions: its robots, its state and its recording; userdata beside it.

A link is drawn by the boxes of its visual geometry and by the meshes of its collision geometry,
which have a tenth of the size of the visual ones. Lengths in [m], angles in [rad], frames of the
link; quaternions x, y, z, w.
"""

from __future__ import annotations

import ast
import json
import math
import re
import xml.etree.ElementTree as ElementTree
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import accumulate
from math import dist
from typing import Any, TypeAlias

import yaml

from flexbe_core.engine.visit import Place

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


_LONGEST = 20_000  # characters of a value that is recorded; a picture is larger


class _MessageLoader(yaml.SafeLoader):  # type: ignore[misc]
    """Reads what a ROS message prints, whose numbers may be `3e-07`, which is no number in YAML."""


_MessageLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"-?[0-9.]+e[+-]?[0-9]+\Z"), [*"-0123456789"]
)


@dataclass(frozen=True)
class Value:
    """One value of userdata.

    Attributes:
        container: path of the container that has it, `/Place`; empty: the behavior itself.
        key: its name there.
        kind: name of its class.
        literal: the Python literal that stands for it; empty if none does.
    """

    container: str
    key: str
    kind: str
    literal: str

    @property
    def name(self) -> str:
        """Return the name by which a start at a state takes it."""
        return f"{self.container}/{self.key}" if self.container else self.key


@dataclass(frozen=True)
class StateValues:
    """What a state found when it became active, at a ROS time [s]."""

    time_s: float
    path: str
    values: tuple[Value, ...]

    def as_json(self) -> list[Any]:
        """Return what `from_json` reads."""
        rows = [[v.container, v.key, v.kind, v.literal] for v in self.values]
        return [round(self.time_s, 3), self.path, rows]

    @classmethod
    def from_json(cls, found: Any) -> StateValues:  # noqa: ANN401 - whatever a file has
        """Return recorded values.

        Raises:
            ValueError, TypeError: if it is something else.
        """
        time_s, path, rows = found
        values = (Value(*map(str, row)) for row in rows)
        return cls(float(time_s), str(path), tuple(values))


def values_around(path: str, known: Mapping[Place, tuple[str, str]]) -> tuple[Value, ...]:
    """Return the values of the behavior and of the containers around a state.

    Args:
        path: of the state, `/Place/Insert`.
        known: class and text of all values.
    """
    return tuple(
        Value(container, key, kind, literal_of(kind, text))
        for (container, key), (kind, text) in known.items()
        if path.startswith(f"{container}/")
    )


@dataclass(frozen=True)
class Row:
    """A value of a state, as text: as it was found, and as it was left behind; empty if neither."""

    key: str
    found: str = ""
    left: str = ""


def literal_of(kind: str, text: str) -> str:
    """Return the literal of a value that was printed; of a message, that of its fields.

    Args:
        kind: name of its class.
        text: as `str` returns it.
    """
    if len(text) > _LONGEST:
        return ""
    if kind == "str":
        return repr(text)
    try:
        ast.literal_eval(text)
    except (ValueError, SyntaxError, MemoryError, RecursionError, TypeError):
        return _fields_of(text)
    return text


def _fields_of(text: str) -> str:
    """Return the fields of a ROS message, which prints itself as YAML; empty of anything else."""
    try:
        fields = yaml.load(text, _MessageLoader)
    except yaml.YAMLError:
        return ""
    return repr(fields) if isinstance(fields, dict) else ""


@dataclass(frozen=True)
class Robot:
    """A robot, where its root link is in the world, and what precedes its joints' names.

    Attributes:
        description: URDF from which `model` was read.
    """

    model: RobotModel
    prefix: str = ""
    position: Vector = (0.0, 0.0, 0.0)
    rotation: Quaternion = (0.0, 0.0, 0.0, 1.0)
    description: str = field(default="", repr=False)


@dataclass(frozen=True)
class Line:
    """A wire as the points of its middle [m], world frame, with its diameter [m]."""

    points: tuple[Vector, ...]
    diameter: float
    colour: str


@dataclass(frozen=True)
class Solid:
    """A box in the world frame; lengths in [m]."""

    position: Vector
    rotation: Quaternion
    size: Vector
    colour: str


@dataclass(frozen=True)
class CellState:
    """What is to be drawn; two states are compared by the identity of their parts."""

    robots: tuple[Robot, ...] = ()
    joints: Mapping[str, float] = field(default_factory=dict)
    wires: Mapping[str, Line] = field(default_factory=dict)
    boxes: Mapping[str, Solid] = field(default_factory=dict)


_TURNED = 0.02  # [rad], or [m] of a joint that slides
_MOVED_M = 0.005


def differences(then: CellState, now: CellState) -> tuple[str, ...]:
    """Return what is not now as it was then; empty if nothing is."""
    return tuple(_differences(then, now))


def _differences(then: CellState, now: CellState) -> Iterator[str]:
    turned = {
        name: abs(now.joints[name] - angle)
        for name, angle in then.joints.items()
        if name in now.joints
    }
    if turned and max(turned.values()) > _TURNED:
        name = max(turned, key=lambda one: turned[one])
        yield f"The robot stands elsewhere: joint {name} differs by {turned[name]:.2f}."
    missing = sorted(set(then.wires) - set(now.wires))
    if missing:
        yield f"Not in the cell now: {', '.join(missing)}."
    more = sorted(set(now.wires) - set(then.wires))
    if more:
        yield f"Only in the cell now: {', '.join(more)}."
    for name in sorted(set(then.wires) & set(now.wires)):
        pairs = zip(then.wires[name].points, now.wires[name].points, strict=False)
        moved_m = max((dist(a, b) for a, b in pairs), default=0.0)
        if moved_m > _MOVED_M:
            yield f"{name} lies up to {1000 * moved_m:.0f} mm elsewhere."
    boxes = set(then.boxes) & set(now.boxes)
    if set(then.boxes) != set(now.boxes):
        yield "Another panel is in the cell."
    moved = sorted(
        name
        for name in boxes
        if dist(then.boxes[name].position, now.boxes[name].position) > _MOVED_M
    )
    if moved:
        yield f"Moved: {', '.join(moved)}."


Change: TypeAlias = dict[str, Any]
_NOTICED_S = 1.0  # in which the record of a run notices that a state is active [s]
_KEY_EVERY = 64  # frames between two whole states that are kept, from which the others follow


def change_between(before: CellState, after: CellState) -> Change:
    """Return what is new in a state; empty if nothing is."""
    change: Change = {}
    if after.robots != before.robots:
        change["robots"] = [
            [one.description, one.prefix, one.position, one.rotation] for one in after.robots
        ]
    joints = {
        name: round(value, 4)
        for name, value in after.joints.items()
        if abs(value - before.joints.get(name, 1e9)) > 5e-4
    }
    wires = {
        name: [line.points, line.diameter, line.colour]
        for name, line in after.wires.items()
        if before.wires.get(name) is not line
    }
    gone = [name for name in before.wires if name not in after.wires]
    change |= {k: v for k, v in (("joints", joints), ("wires", wires), ("gone", gone)) if v}
    if after.boxes != before.boxes:
        change["boxes"] = {
            name: [box.position, box.rotation, box.size, box.colour]
            for name, box in after.boxes.items()
        }
    return change


def state_after(state: CellState, change: Change) -> CellState:
    """Return the state after a change.

    Raises:
        ValueError, TypeError, KeyError: if it is no change.
    """
    new: dict[str, Any] = {}
    if change.get("whole"):  # recorded by another console, or after a restart
        state = CellState()
    if "robots" in change:
        new["robots"] = tuple(
            Robot(_model(urdf), prefix, _triple(position), tuple(rotation), urdf)
            for urdf, prefix, position, rotation in change["robots"]
        )
    if "joints" in change:
        new["joints"] = {**state.joints, **{k: float(v) for k, v in change["joints"].items()}}
    if "wires" in change or "gone" in change:
        gone = set(change.get("gone", ()))
        kept = {name: line for name, line in state.wires.items() if name not in gone}
        lines = change.get("wires", {}).items()
        new["wires"] = kept | {
            name: Line(tuple(map(_triple, points)), float(diameter), str(colour))
            for name, (points, diameter, colour) in lines
        }
    if "boxes" in change:
        new["boxes"] = {
            name: Solid(_triple(position), tuple(rotation), _triple(size), str(colour))
            for name, (position, rotation, size, colour) in change["boxes"].items()
        }
    return replace(state, **new)


def frame_text(time_s: float, change: Change) -> str:
    """Return a frame as a line of a file."""
    return json.dumps([round(time_s, 3), change], separators=(",", ":")) + "\n"


@dataclass(frozen=True)
class Recording:
    """The frames of a run, in the order in which they were recorded.

    Attributes:
        frames: ROS time [s] and line of each; as text, they take a fifth of the memory.
    """

    frames: tuple[tuple[float, str], ...]

    @cached_property
    def _times_s(self) -> tuple[float, ...]:
        """Return the times; the clock of a cell that was restarted begins again, these go on."""
        return tuple(accumulate((time_s for time_s, _ in self.frames), max))

    @cached_property
    def _keys(self) -> tuple[CellState, ...]:
        keys, state = [], CellState()
        for place, (_, line) in enumerate(self.frames):
            state = state_after(state, _change_in(line))
            if place % _KEY_EVERY == 0:
                keys.append(state)
        return tuple(keys)

    @cached_property
    def _robots(self) -> tuple[Robot, ...]:
        """Return the robots that are known first; a run may begin before they are."""
        found = (line for _, line in self.frames if '"robots":' in line)
        line = next(found, None)
        return state_after(CellState(), _change_in(line)).robots if line else ()

    def at(self, time_s: float) -> CellState:
        """Return the state at a ROS time [s]; before the first frame, that of the first."""
        if not self.frames:
            return CellState()
        place = max(0, bisect_right(self._times_s, time_s) - 1)
        first = place // _KEY_EVERY
        state = self._keys[first]
        for _, line in self.frames[first * _KEY_EVERY + 1 : place + 1]:
            state = state_after(state, _change_in(line))
        return state if state.robots else replace(state, robots=self._robots)

    @cached_property
    def _values(self) -> tuple[StateValues, ...]:
        """Return the userdata that states found, in the order of the frames."""
        found = (line for _, line in self.frames if '"values":' in line)
        return tuple(StateValues.from_json(_change_in(line)["values"]) for line in found)

    def values_at(self, path: str, entered_s: float, left_s: float) -> tuple[Value, ...]:
        """Return the userdata that a visit of a state found; empty if it was not recorded.

        Args:
            path: of the state, `/Place/Insert`.
            entered_s: ROS time at which the state became active [s].
            left_s: ROS time at which it was left [s].
        """
        visits = [
            one
            for one in self._values
            if one.path == path and entered_s - _NOTICED_S <= one.time_s <= left_s
        ]
        nearest = min(visits, key=lambda one: abs(one.time_s - entered_s), default=None)
        return nearest.values if nearest else ()

    @classmethod
    def read(cls, lines: Iterable[str]) -> Recording:
        """Return what lines of a file hold; one that was cut off ends it."""
        recording = cls(tuple(_frames(lines)))
        recording.at(0.0)  # here, on the thread that reads, and not when a page shows it
        return recording


def _frames(lines: Iterable[str]) -> Iterator[tuple[float, str]]:
    for line in lines:
        try:
            time_s, change = json.loads(line)
            if not isinstance(change, dict):
                return
            state_after(CellState(), change)
            if "values" in change:
                StateValues.from_json(change["values"])
            yield float(time_s), line
        except (ValueError, TypeError, KeyError):
            return


def _change_in(line: str) -> Change:
    _, change = json.loads(line)
    return dict(change)


@lru_cache(maxsize=16)
def _model(urdf: str) -> RobotModel:
    return read_robot(urdf)


def _triple(values: Iterable[float]) -> tuple[float, float, float]:
    x, y, z = values
    return x, y, z
