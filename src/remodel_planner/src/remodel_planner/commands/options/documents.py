"""What `import` and `plan` print with `--json`, for programs such as the console's order desk."""

from __future__ import annotations

import argparse
import itertools
import json
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import msgspec

from remodel_run import findings
from remodel_tasks.core.plan.checker import check
from remodel_tasks.core.plan.explanation import against_arms, violations
from remodel_tasks.core.problem.part import cable_tasks, cores_of
from remodel_tasks.core.problem.preferences import features_of
from remodel_tasks.core.problem.problem import TICKS_PER_S

if TYPE_CHECKING:
    from remodel_tasks.core.orders.work_order import WorkOrder
    from remodel_tasks.core.problem.conflict import Requirement
    from remodel_tasks.core.problem.preferences import Preferred
    from remodel_tasks.core.problem.problem import Plan
    from remodel_tasks.core.search import Planned

_VIOLATIONS = 1000  # that are listed; a plan of thousands of wires may have millions


def add_json_option(parser: argparse.ArgumentParser) -> None:
    """Add --json."""
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def print_json(value: findings.Imported | findings.Plan | findings.NoPlan) -> None:
    """Print findings as a JSON object, without what there is none of."""
    fields = msgspec.to_builtins(value).items()
    print(json.dumps({name: found for name, found in fields if found is not None}))


def triage_of(order: WorkOrder) -> findings.Triage:
    """Return which tasks are for the robot, by which other methods, and which by hand."""
    return findings.Triage(
        order.use_case,
        tuple(task.name for task in order.whole_tasks),
        order.cables,
        order.other_methods,
        by_hand=order.by_hand,
        outside=order.outside,
    )


def plan_findings(
    planned: Planned, preferred: Preferred, search: str, triage: findings.Triage | None
) -> findings.Plan:
    """Return a valid plan with its times [s], and what preferences about it can name.

    Args:
        planned: the plan.
        preferred: the preferences that it was made by.
        search: how the search for it ended.
        triage: of the order; None without one.
    """
    problem, plan = planned.tables.problem, planned.plan
    verdict = check(problem, plan)
    in_order = sorted(plan.actions, key=lambda action: action.start_ticks)  # as of the durations
    actions = (
        findings.PlannedAction(
            action.kind.value,
            action.arm,
            action.wire or "",
            str(action.target or (action.end.letter if action.end is not None else "")),
            start_s=(action.start_ticks - problem.start_ticks) / TICKS_PER_S,
            duration_s=ticks / TICKS_PER_S,
        )
        for action, ticks in zip(in_order, verdict.durations, strict=True)
    )
    return findings.Plan(
        cost=verdict.cost,
        makespan_s=verdict.makespan / TICKS_PER_S,
        penalties=verdict.penalties,
        arms=tuple(arm.name for arm in problem.arms),
        features=tuple(features_of(problem)),
        cables=cores_of(problem),
        split_cables=tuple(str(c) for c in cable_tasks(problem, plan) if len(c.parts) > 1),
        violations=tuple(itertools.islice(_violated(preferred, plan), _VIOLATIONS)),
        segments=tuple(sorted({name for wire in problem.wires for name in wire.segments})),
        actions=tuple(actions),
        search=search,
        triage=triage,
    )


def _violated(preferred: Preferred, plan: Plan) -> Iterator[findings.Violated]:
    """Yield the preferences that a plan violates, each with the wires that show it."""
    for item in violations(preferred.problem, plan):
        before, after = item.soft.before, item.soft.after
        words = f"{before} should be picked before {after}"
        yield findings.Violated(item.soft.reason, (before, after), words)
    arm_of = {wire.name: wire.preferred_arm for wire in preferred.problem.wires}
    for reason, wires in against_arms(preferred, plan).items():
        for wire in wires:
            words = f"{wire} should be picked by {arm_of[wire]}"
            yield findings.Violated(reason, (wire,), words)


def conflict_findings(error: str, conflicts: Sequence[Sequence[Requirement]]) -> findings.NoPlan:
    """Return why there is no plan: the error, and smallest sets of requirements for it."""
    return findings.NoPlan(
        error,
        tuple(
            tuple(findings.Conflicting(r.source, r.index, dict(r.entry)) for r in conflict)
            for conflict in conflicts
        ),
    )
