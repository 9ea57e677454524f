#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Solve an exported problem by Fast Downward, to optimality, and judge an exported plan.

Runs in an environment of its own, with unified-planning and up-fast-downward. Usage: FOLDER, with
domain.pddl, problem.pddl, plan.txt, domain.hddl and problem.hddl. Prints a JSON object.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import up_fast_downward
from unified_planning.engines import SequentialPlanValidator
from unified_planning.io import PDDLReader

_COST = "; cost = "
_LIMIT_S = 300


def main() -> None:
    """Solve, judge, and print."""
    folder = Path(sys.argv[1])
    problem = PDDLReader().parse_problem(str(folder / "domain.pddl"), str(folder / "problem.pddl"))
    hierarchical = PDDLReader().parse_problem(
        str(folder / "domain.hddl"), str(folder / "problem.hddl")
    )
    plan = PDDLReader().parse_plan(problem, str(folder / "plan.txt"))
    validator = SequentialPlanValidator()
    validator.skip_checks = True  # it does not know all features by name, and judges them well
    verdict = validator.validate(problem, plan)
    print(
        json.dumps(
            {
                "optimal": optimal_cost(folder),
                "plan": int(next(iter(verdict.metric_evaluations.values()))),
                "valid": verdict.status.name == "VALID",
                "methods": len(hierarchical.methods),
            }
        )
    )


def optimal_cost(folder: Path) -> int:
    """Return the cost of an optimal plan, by A* without a heuristic."""
    driver = Path(up_fast_downward.__file__).parent / "downward" / "fast-downward.py"
    found = folder / "optimal.txt"
    subprocess.run(
        [
            *(sys.executable, driver, "--plan-file", found),
            *(folder / "domain.pddl", folder / "problem.pddl", "--search", "astar(blind())"),
        ],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        timeout=_LIMIT_S,
        check=True,
    )
    line = next(line for line in found.read_text().splitlines() if line.startswith(_COST))
    return int(line.removeprefix(_COST).split()[0])


if __name__ == "__main__":
    main()
