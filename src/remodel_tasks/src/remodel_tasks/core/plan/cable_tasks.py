"""The cables of a plan: the cores of each are one task, picked one after another by one arm."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby

from remodel_tasks.core.problem.cables import cores_of
from remodel_tasks.core.problem.modes import possible_modes
from remodel_tasks.core.problem.problem import ActionKind, Plan, Problem, Stage


@dataclass(frozen=True)
class CableTask:
    """A cable as a plan does it.

    Attributes:
        parts: arm, and the cores that it picks with no other wire between them; one part, unless
            the plan could not keep the cores together.
        reason: why there are several parts; empty for one.
    """

    name: str
    parts: tuple[tuple[str, tuple[str, ...]], ...]
    reason: str = ""

    def __str__(self) -> str:
        """Return the line for a person."""
        done = ", ".join(f"{' '.join(cores)} by {arm}" for arm, cores in self.parts)
        if len(self.parts) == 1:
            return f"cable {self.name}: {done}"
        return f"cable {self.name} is in {len(self.parts)} parts: {done}; {self.reason}"


def cable_tasks(problem: Problem, plan: Plan) -> tuple[CableTask, ...]:
    """Return the cables of which a valid plan picks cores, in the order of their first picks."""
    several = cores_of(problem)
    picks = sorted(
        (action for action in plan.actions if action.kind is ActionKind.PICK),
        key=lambda action: action.start_ticks,
    )
    begun: dict[str, list[tuple[int, str, tuple[str, ...]]]] = {}
    for arm in problem.arms:
        own = [(i, str(pick.wire)) for i, pick in enumerate(picks) if pick.arm == arm.name]
        for cable, group in groupby(own, lambda pick: problem.wire[pick[1]].cable):
            cores = list(group)
            if cable in several:
                part = (cores[0][0], arm.name, tuple(core for _, core in cores))
                begun.setdefault(cable, []).append(part)
    return tuple(
        CableTask(
            cable,
            tuple((arm, cores) for _, arm, cores in sorted(parts)),
            _reason(problem, several[cable]) if len(parts) > 1 else "",
        )
        for cable, parts in sorted(begun.items(), key=lambda each: min(each[1]))
    )


def _reason(problem: Problem, cores: tuple[str, ...]) -> str:
    modes = possible_modes(problem)
    stored = [name for name in cores if problem.wire[name].stage is Stage.STORED]
    arms = [{mode.arm for mode in modes[name]} for name in stored]
    if not set.intersection(*arms):
        return "no arm reaches the ends of all its cores"
    return "order constraints keep its cores apart"
