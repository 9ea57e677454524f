"""`remodel check INSTANCE.json PLAN.json`: check a plan."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from remodel_planner.commands.options.common import refuses
from remodel_planner.commands.options.problem_files import (
    add_problem_options,
    read_plan,
    read_problem,
)
from remodel_tasks.core.plan.checker import Verdict, check


@refuses("check")
def main(arguments: list[str] | None = None) -> int:
    """Check the plan, print the verdict as JSON, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel check",
        description="Check a plan against its problem with code that the search does not share.",
        epilog="Exit code: 0 valid, 1 not valid, or refused (a file is malformed), 2 wrong usage.",
    )
    add_problem_options(parser)
    parser.add_argument("plan", type=Path, help="plan with a start for every action")
    options = parser.parse_args(arguments)
    problem = read_problem(options).problem
    plan = read_plan(options.plan)
    verdict = check(problem, plan)
    print(json.dumps(_document(verdict)))
    return 0 if verdict.valid else 1


def _document(verdict: Verdict) -> dict[str, object]:
    return {
        "valid": verdict.valid,
        "cost": verdict.cost,
        "makespan": verdict.makespan,
        "penalties": verdict.penalties,
        "violations": verdict.violations,
    }
