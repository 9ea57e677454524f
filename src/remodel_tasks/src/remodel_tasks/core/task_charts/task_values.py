"""What the inputs and parameters of a task's states can refer to."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from remodel_tasks.core.decomposition.decomposed import Step
from remodel_tasks.core.orders.work_order import Task
from remodel_tasks.core.problem.problem import End, Point
from remodel_tasks.core.use_case.model import ARM, FORCE


@dataclass(frozen=True)
class TaskValues:
    """The values of a task.

    Attributes:
        first: the end that is inserted first.
        component_of: components by the names of terminals.
        height_m: of the tool centre while something is carried.
    """

    task: Task
    first: End
    component_of: dict[str, str]
    height_m: float

    def of(self, step: Step, arm: str) -> dict[str, object]:
        """Return what references may name in a step that an arm does."""
        values: dict[str, object] = {
            "task": self.task.name,
            ARM: arm,
            "slot_pose": poses([self.task.slot_mm], self.height_m)[0],
            "path": poses(step.route.path_mm, self.height_m),
            **self._of_end("first_", self.first),
            **self._of_end("second_", self.first.other),
        }
        if self.task.meeting_mm is not None:
            values["meeting_pose"] = poses([self.task.meeting_mm], self.height_m)[0]
        if step.end is not None:
            values |= self._of_end("", step.end)
            values |= {FORCE: step.force_n} if step.action.force_n else {}
            known = {"clearance_m": step.access.clearance_m, "approach": step.access.approach}
            values |= {name: value for name, value in known.items() if value is not None}
        if step.clip is not None:
            values["clip"] = step.clip.name
        return {**values, **dict(self.task.values)}

    def _of_end(self, prefix: str, end: End) -> dict[str, object]:
        terminal = self.task.terminals[end]
        component = self.component_of[terminal]
        return {
            f"{prefix}end": end.letter,
            f"{prefix}component": component,
            f"{prefix}terminal": terminal.removeprefix(f"{component}:"),
        }


def poses(path_mm: Sequence[Point], height_m: float) -> tuple[tuple[float, ...], ...]:
    """Return tool poses [x, y, z, yaw] in the panel frame [m, rad], facing along a path."""
    placed: list[tuple[float, ...]] = []
    for i, (x, y) in enumerate(path_mm):
        if i + 1 < len(path_mm):
            yaw = math.atan2(path_mm[i + 1][1] - y, path_mm[i + 1][0] - x)
        else:
            yaw = placed[-1][3] if placed else 0.0
        placed.append((x / 1e3, y / 1e3, height_m, round(yaw, 4)))
    return tuple(placed)
