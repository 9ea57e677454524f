"""The cell as it is drawn in three dimensions: its state, what changed in it, and a recording."""

from __future__ import annotations

import json
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import accumulate
from math import dist
from typing import Any, TypeAlias

from remodel_console.core.cell.robot_model import Quaternion, RobotModel, Vector, read_robot
from remodel_console.core.run.state_values import StateValues, Value


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
