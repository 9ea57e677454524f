"""What `import` and `plan` print with `--json`, for programs such as the console's order desk."""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from remodel_planning.core.plan.cable_tasks import cable_tasks
from remodel_planning.core.plan.checker import check
from remodel_planning.core.plan.explanation import against_arms, violations
from remodel_planning.core.problem.cables import cores_of
from remodel_planning.core.problem.choices import features_of
from remodel_planning.core.problem.problem import TICKS_PER_S, Plan

if TYPE_CHECKING:
    from remodel_planning.core.orders.work_order import WorkOrder
    from remodel_planning.core.problem.conflict import Requirement
    from remodel_planning.core.problem.preferences import Preferred
    from remodel_planning.core.search.planned import Planned
    from remodel_production.core.imports.shared.account import Account
    from remodel_production.core.production import Order

Document = dict[str, Any]  # JSON
_VIOLATIONS = 1000  # that are listed; a plan of thousands of wires may have millions


def add_json_option(parser: argparse.ArgumentParser) -> None:
    """Add --json."""
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def order_document(order: Order, account: Account) -> Document:
    """Return what an import read, assumed and left out."""
    things = ("components", "wires", "cables", "segments", "clips")
    return {
        "order": order.name,
        "title": order.title,
        "counts": {name: len(getattr(order, name)) for name in things},
        "wires_in_cabinet": len(order.in_cabinet().wires),
        "account": asdict(account),
    }


def triage_document(order: WorkOrder) -> Document:
    """Return which tasks are for the robot, by which other methods, and which by hand."""
    return {
        "use_case": order.use_case,
        "robot": [task.name for task in order.whole_tasks],
        "cables": order.cables,
        "outside": [asdict(each) for each in order.outside],
        "other_methods": [asdict(each) for each in order.other_methods],
        "by_hand": [asdict(each) for each in order.by_hand],
    }


def plan_document(planned: Planned, preferred: Preferred) -> Document:
    """Return a valid plan with its times [s], and what preferences about it can name.

    Args:
        planned: the plan.
        preferred: the preferences that it was made by.
    """
    problem, plan = planned.tables.problem, planned.plan
    verdict = check(problem, plan)
    in_order = sorted(plan.actions, key=lambda action: action.start_ticks)  # as of the durations
    actions = [
        {
            "action": action.kind.value,
            "arm": action.arm,
            "wire": action.wire or "",
            "target": str(action.target or (action.end.letter if action.end is not None else "")),
            "start_s": (action.start_ticks - problem.start_ticks) / TICKS_PER_S,
            "duration_s": ticks / TICKS_PER_S,
        }
        for action, ticks in zip(in_order, verdict.durations, strict=True)
    ]
    return {
        "cost": verdict.cost,
        "makespan_s": verdict.makespan / TICKS_PER_S,
        "penalties": verdict.penalties,
        "arms": [arm.name for arm in problem.arms],
        "features": features_of(problem),
        "cables": cores_of(problem),
        "split_cables": [str(c) for c in cable_tasks(problem, plan) if len(c.parts) > 1],
        "violations": list(itertools.islice(_violated(preferred, plan), _VIOLATIONS)),
        "segments": sorted({name for wire in problem.wires for name in wire.segments}),
        "actions": actions,
    }


def _violated(preferred: Preferred, plan: Plan) -> Iterator[Document]:
    """Yield the preferences that a plan violates, each with the wires that show it."""
    for item in violations(preferred.problem, plan):
        before, after = item.soft.before, item.soft.after
        words = f"{before} should be picked before {after}"
        yield {"reason": item.soft.reason, "wires": [before, after], "words": words}
    arm_of = {wire.name: wire.preferred_arm for wire in preferred.problem.wires}
    for reason, wires in against_arms(preferred, plan).items():
        for wire in wires:
            words = f"{wire} should be picked by {arm_of[wire]}"
            yield {"reason": reason, "wires": [wire], "words": words}


def conflict_document(error: str, conflicts: Sequence[Sequence[Requirement]]) -> Document:
    """Return why there is no plan: the error, and smallest sets of requirements for it."""
    return {
        "error": error,
        "conflicts": [
            [{"source": r.source, "index": r.index, "entry": dict(r.entry)} for r in conflict]
            for conflict in conflicts
        ],
    }
