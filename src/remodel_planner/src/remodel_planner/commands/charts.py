"""`remodel charts ORDER PLAN.json`: make a state chart of each task of a plan."""

from __future__ import annotations

import argparse
from pathlib import Path

from remodel_planner.commands.options.common import refuses
from remodel_planner.commands.options.problem_files import (
    add_problem_options,
    read_order,
    read_plan,
)
from remodel_tasks.core.plan.checker import check
from remodel_tasks.core.task_charts.planned_tasks import planned_tasks
from remodel_tasks.edge.document_files import keep_chart


@refuses("charts")
def main(arguments: list[str] | None = None) -> int:
    """Write the charts, print one line a task, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel charts",
        description="Write the state chart of each task, in the order of a plan. A chart that is "
        "there already, unchanged, is left alone.",
        epilog="Exit code: 0 written, 1 the plan is not valid, or refused (a file is malformed "
        "or cannot be written), 2 wrong usage.",
    )
    add_problem_options(parser)
    parser.add_argument("plan", type=Path, help="plan of that order")
    parser.add_argument("--output", type=Path, required=True, help="folder of the charts")
    options = parser.parse_args(arguments)
    prepared = read_order(options)
    plan = read_plan(options.plan)
    verdict = check(prepared.preferred.problem, plan)
    if not verdict.valid:
        print("\n".join(("the plan is not valid:", *verdict.violations)))
        return 1
    charts = [(task.name, task.chart) for task in planned_tasks(prepared, plan)]
    for name, chart in charts:
        file, written = keep_chart(chart, options.output)
        print(f"{name}: {file} {'written' if written else 'unchanged'}")
    return 0
