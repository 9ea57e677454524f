"""`remodel export INSTANCE --format pddl`: write a problem for other planners."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from remodel_pddl import hddl, pddl
from remodel_pddl.symbolic import steps_of, symbols_of
from remodel_planner.commands.options.common import refuses
from remodel_planner.commands.options.problem_files import (
    add_problem_options,
    read_plan,
    read_problem,
)
from remodel_production.errors import InstanceError
from remodel_tasks.core.plan.checker import check
from remodel_tasks.core.problem.instance import plan_data, problem_data
from remodel_tasks.core.problem.part import first_picks
from remodel_tasks.core.problem.problem import Plan, Problem
from remodel_tasks.edge.document_files import write_text

_SYMBOLIC = {"pddl": pddl, "hddl": hddl}
_NUMERIC = "planbench"


@refuses("export")
def main(arguments: list[str] | None = None) -> int:
    """Write the files, name them, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel export",
        description="Write a problem, and a plan of it if one is given. As PDDL with action costs "
        "or as HDDL, a problem of one arm: domain.FORMAT, problem.FORMAT, plan.txt; costs of plans "
        "are equal, to the unit. As planbench, any problem in the form of docs/planning.md: "
        "problem.json, plan.json.",
        epilog="Exit code: 0 written, 1 the plan is not valid, or refused (a file is malformed "
        "or cannot be written, or the format cannot express the problem), 2 wrong usage.",
    )
    add_problem_options(parser)
    parser.add_argument("plan", type=Path, nargs="?", help="plan of that problem")
    parser.add_argument("--format", choices=[*sorted(_SYMBOLIC), _NUMERIC], required=True)
    parser.add_argument(
        "--numeric-fluents",
        action="store_true",
        help="state the requirement :numeric-fluents in the domain, for parsers that read no costs "
        "without it; Fast Downward refuses it",
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path(),
        help="folder, made if it is missing (default: this one)",
    )
    options = parser.parse_args(arguments)
    if options.order is not None and options.plan is None:
        # Beside --order the one file is the plan; argparse takes it for the first one wanted.
        options.instance, options.plan = None, options.instance
    problem = read_problem(options).problem
    plan = read_plan(options.plan) if options.plan is not None else None
    verdict = check(problem, plan) if plan is not None else None
    if verdict is not None and not verdict.valid:
        print("\n".join(("the plan is not valid:", *verdict.violations)))
        return 1
    texts = (
        _documents(problem, plan)
        if options.format == _NUMERIC
        else _symbolic(
            problem,
            plan,
            options.format,
            verdict.cost + first_picks(problem) if verdict else 0,
            has_numeric_fluents=options.numeric_fluents,
        )
    )
    _make_folder(options.output)
    for name, text in texts.items():
        write_text(options.output / name, text)
        print(options.output / name)
    return 0


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InstanceError(f"{folder}: cannot be made a folder: {error.strerror}") from error


def _symbolic(
    problem: Problem, plan: Plan | None, name: str, cost: int, *, has_numeric_fluents: bool
) -> dict[str, str]:
    symbols = symbols_of(problem)
    form = _SYMBOLIC[name]
    domain = form.domain_text(has_numeric_fluents=has_numeric_fluents)
    texts = {f"domain.{name}": domain, f"problem.{name}": form.problem_text(symbols)}
    if plan is not None:
        texts["plan.txt"] = pddl.plan_text(steps_of(problem, plan, symbols), cost)
    return texts


def _documents(problem: Problem, plan: Plan | None) -> dict[str, str]:
    texts = {"problem.json": json.dumps(problem_data(problem))}
    if plan is not None:
        texts["plan.json"] = json.dumps(plan_data(plan))
    return texts
