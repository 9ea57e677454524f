#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Compare our plans with those of an optimal planner, to the unit.

Small panels of one arm are exported as PDDL and HDDL; Fast Downward, which knows nothing of ours,
finds their least cost, and unified-planning judges our plan. Runs them in an environment of their
own (--python). Exit code: 0 if all costs are equal, 1 if not.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from remodel_pddl import hddl, pddl
from remodel_pddl.symbolic import steps_of, symbols_of
from remodel_tasks.core.problem.instance import problem_from
from remodel_tasks.edge.anytime_planner import plan_problem

sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_tasks/test"))

from random_panel import random_panel

_WIRES = 10
_PLANNING_S = 1.0


def main() -> int:
    """Compare, print, and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--python", required=True, help="that has unified-planning")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5])
    options = parser.parse_args()
    equal = True
    for seed in options.seeds:
        with tempfile.TemporaryDirectory() as folder:
            cost = _export(Path(folder), seed)
            answer = json.loads(_peer(options.python, folder))
        same = answer["valid"] and cost == answer["plan"] == answer["optimal"]
        equal &= same
        print(
            f"sw1-{_WIRES}-{seed}: ours {cost}, judged {answer['plan']}, "
            f"optimal {answer['optimal']}: {'equal' if same else 'NOT EQUAL'}"
        )
    return 0 if equal else 1


def _export(folder: Path, seed: int) -> int:
    """Write a panel, and our plan of it, and return the plan's cost."""
    problem = problem_from(random_panel(_WIRES, seed, 1))
    planned = plan_problem(problem, _PLANNING_S)
    symbols = symbols_of(problem)
    for name, form in (("pddl", pddl), ("hddl", hddl)):
        (folder / f"domain.{name}").write_text(form.domain_text())
        (folder / f"problem.{name}").write_text(form.problem_text(symbols))
    steps = steps_of(problem, planned.plan, symbols)
    (folder / "plan.txt").write_text(pddl.plan_text(steps, planned.cost))
    return planned.cost


def _peer(python: str, folder: str) -> str:
    peer = Path(__file__).with_name("fast_downward_peer.py")
    done = subprocess.run([python, peer, folder], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[-1]


if __name__ == "__main__":
    sys.exit(main())
