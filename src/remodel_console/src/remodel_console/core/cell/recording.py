"""The cell in three dimensions over time: what changed from one moment to the next, as JSON.

A frame is `[ROS time [s], change]`; a change has what is new of robots, joints, wires and boxes,
and the names of wires that are gone. One that is `whole` counts from an empty cell. A robot is
stored as its URDF. Besides, a change may have the userdata that a state found, as `values`.
"""

from __future__ import annotations

import json
from bisect import bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import accumulate
from typing import Any, TypeAlias

from remodel_console.core.cell.cell_state import CellState, Line, Robot, Solid
from remodel_console.core.cell.robot_model import RobotModel, read_robot
from remodel_console.core.run.state_values import StateValues, Value

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
