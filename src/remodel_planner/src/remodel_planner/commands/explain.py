"""`remodel explain INSTANCE.json PLAN.json`: explain a plan, or a run."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from remodel_planner.commands.options.common import add_database_option, refuses
from remodel_planner.commands.options.problem_files import (
    add_problem_options,
    read_plan,
    read_problem,
)
from remodel_tasks.core.plan.checker import check
from remodel_tasks.core.plan.explanation import Listing, explain, listing_of
from remodel_tasks.core.problem.problem import Plan, Problem
from remodel_tasks.core.search import tables_of
from remodel_tasks.edge.anytime_planner import AnytimePlanner
from remodel_tasks.edge.search_kernel import Kernel


@refuses("explain")
def main(arguments: list[str] | None = None) -> int:
    """Print the explanation of a plan, or of a run, and return the exit code."""
    words = sys.argv[1:] if arguments is None else arguments
    if words and words[0].isdigit():
        return _explain_run(words)
    parser = argparse.ArgumentParser(
        prog="remodel explain",
        description="Print what a plan costs, which preferences it violates, why, and what "
        "satisfying each of them would cost.",
        usage="remodel explain RUN [--database URL]\n"
        "       remodel explain [OPTIONS] [INSTANCE] PLAN",
        epilog="With the number of a run, print what was done in it, what failed, what was decided "
        "and why. Exit code: 0 explained, 1 the plan is not valid, or refused (a file is "
        "malformed), 2 wrong usage.",
    )
    add_problem_options(parser)
    parser.add_argument("plan", type=Path, help="plan of that problem")
    options = parser.parse_args(words)
    preferred = read_problem(options).preferred
    plan = read_plan(options.plan)
    verdict = check(preferred.problem, plan)
    if not verdict.valid:
        print("\n".join(("the plan is not valid:", *verdict.violations)))
        return 1
    alternatives = _Alternatives(preferred.problem, plan)
    lines = list(explain(preferred, plan, verdict, alternatives))
    print("\n".join(lines))
    return 0


def _explain_run(words: list[str]) -> int:
    """Print the explanation of a run; exit code 3 without such a run or database."""
    from remodel_planner.core.run_explanation import explain_run
    from remodel_supervision.edge.run_log import kept_run  # the database takes long to load
    from remodel_tasks.edge.fault_file import read_faults

    parser = argparse.ArgumentParser(
        prog="remodel explain",
        description="Print what was done in a recorded run, what failed, what was decided and why.",
        epilog="Exit code: 0 printed, 2 wrong usage, 3 no such run or database.",
    )
    parser.add_argument("run", type=int, metavar="RUN", help="number of the run")
    add_database_option(parser)
    options = parser.parse_args(words)
    kept = kept_run(options.database, options.run)
    events = [each.event for each in kept]
    print("\n".join(explain_run(options.run, kept[0].at, events, read_faults())))
    return 0


class _Alternatives:
    """Simulates a plan with one wire changed."""

    def __init__(self, problem: Problem, plan: Plan) -> None:
        self._problem = problem
        self._tables = tables_of(problem)
        self._planner = AnytimePlanner(Kernel(), self._tables)
        self._listing = listing_of(problem, plan)
        self._cost = self._cost_of(self._listing)

    def picked_before(self, first: str, second: str) -> int:
        """Return the difference if a wire is picked right before another one."""
        listing = self._listing.with_first_before(self._problem, first, second)
        return self._cost_of(listing) - self._cost

    def done_by(self, wire: str, arm: str) -> int | None:
        """Return the least difference if an arm picks a wire; None if it cannot."""
        names = [arm.name for arm in self._problem.arms]
        modes = [m for m in self._tables.modes[wire] if names[m.arm] == arm]
        costs = [self._cost_of(self._listing.with_mode(wire, mode)) for mode in modes]
        return min(costs) - self._cost if costs else None

    def _cost_of(self, listing: Listing) -> int:
        number = {name: i for i, name in enumerate(self._tables.wires)}
        order = np.array([number[name] for name in listing.wires], np.int32)
        modes = np.array([listing.modes[name].number for name in self._tables.wires], np.int32)
        return self._planner.patched(order, modes).cost
