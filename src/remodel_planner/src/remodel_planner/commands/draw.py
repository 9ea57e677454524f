"""`remodel draw INSTANCE.json PLAN.json`: draw a plan."""

from __future__ import annotations

import argparse
from pathlib import Path

from remodel_planner.commands.options.common import refuses
from remodel_planner.commands.options.problem_files import (
    add_problem_options,
    read_plan,
    read_problem,
)
from remodel_tasks.core.plan.checker import check
from remodel_tasks.core.plan.drawing import draw_plan
from remodel_tasks.edge.document_files import write_text


@refuses("draw")
def main(arguments: list[str] | None = None) -> int:
    """Write the drawing, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel draw",
        description="Draw what each arm does when, and the panel with its wires in their order.",
        epilog="Exit code: 0 drawn, 1 the plan is not valid, or refused (a file is malformed "
        "or cannot be written), 2 wrong usage.",
    )
    add_problem_options(parser)
    parser.add_argument("plan", type=Path, help="plan of that problem")
    parser.add_argument("--output", type=Path, required=True, help="file of the drawing (SVG)")
    options = parser.parse_args(arguments)
    problem = read_problem(options).problem
    plan = read_plan(options.plan)
    verdict = check(problem, plan)
    if not verdict.valid:
        print("\n".join(("the plan is not valid:", *verdict.violations)))
        return 1
    write_text(options.output, draw_plan(problem, plan, verdict))
    print(f"drawing: {options.output}")
    return 0
