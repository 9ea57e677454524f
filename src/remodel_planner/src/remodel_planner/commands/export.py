"""`rosrun remodel_planner export INSTANCE --format pddl`: write a problem for other planners."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from remodel_planner.commands.problem_files import add_problem_options, read_plan, read_problem
from remodel_planner.core.planning import hddl, pddl
from remodel_planner.core.planning.checker import check
from remodel_planner.core.planning.symbolic import steps_of, symbols_of
from remodel_planner.edge.text_file import write_text
from remodel_planner.errors import PlannerError

_FORMATS = {"pddl": pddl, "hddl": hddl}


def main(arguments: list[str] | None = None) -> int:
    """Write the files, name them, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="export",
        description="Write a problem of one arm as PDDL with action costs or as HDDL: "
        "domain.FORMAT and problem.FORMAT, and plan.txt if a plan is given. Costs of plans are "
        "equal, to the unit.",
        epilog="Exit code: 0 written, 1 the plan is not valid, 2 wrong usage, 3 a file is "
        "malformed or cannot be written, or the problem cannot be told in the format.",
    )
    add_problem_options(parser)
    parser.add_argument("plan", type=Path, nargs="?", help="plan of that problem")
    parser.add_argument("--format", choices=sorted(_FORMATS), required=True)
    parser.add_argument("--output", type=Path, default=Path(), help="folder (default: this one)")
    options = parser.parse_args(arguments)
    try:
        problem = read_problem(options).problem
        symbols = symbols_of(problem)
        form = _FORMATS[options.format]
        texts = {
            f"domain.{options.format}": form.domain_text(),
            f"problem.{options.format}": form.problem_text(symbols),
        }
        if options.plan is not None:
            plan = read_plan(options.plan)
            verdict = check(problem, plan)
            if not verdict.valid:
                print("\n".join(("the plan is not valid:", *verdict.violations)))
                return 1
            texts["plan.txt"] = pddl.plan_text(steps_of(problem, plan, symbols), verdict.cost)
        for name, text in texts.items():
            write_text(options.output / name, text)
            print(options.output / name)
    except PlannerError as error:
        print(f"export: {error}", file=sys.stderr)
        return 3
    return 0
