"""`remodel plan INSTANCE.json`: plan the wiring of a panel."""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path

from remodel_planner.commands.options.common import (
    count,
    refuses,
    seconds,
    seed,
    stages,
    stop_on_signals,
)
from remodel_planner.commands.options.documents import (
    add_json_option,
    conflict_findings,
    plan_findings,
    print_json,
    triage_of,
)
from remodel_planner.commands.options.problem_files import (
    ConflictError,
    add_problem_options,
    print_triage,
    read_problem,
)
from remodel_production.errors import InfeasibleError
from remodel_tasks.core.problem.conflict import keeping, requirements_in
from remodel_tasks.core.problem.instance import plan_data
from remodel_tasks.core.problem.part import cable_tasks
from remodel_tasks.core.search import Planned, tables_of
from remodel_tasks.edge.anytime_planner import (
    AnytimePlanner,
    Limits,
    Result,
    plan_problem,
    require_valid,
)
from remodel_tasks.edge.document_files import write_json
from remodel_tasks.edge.search_kernel import Kernel


@refuses("plan")
def main(arguments: list[str] | None = None) -> int:
    """Plan, check the plan, write it, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel plan",
        description="Plan the wiring of a panel with one or two arms. The first plan is written at "
        "once and replaced by better ones only when the time is over, the target is reached, or "
        "the command gets SIGINT or SIGTERM.",
        epilog="Exit code: 0 planned, 1 refused (the instance is malformed or has no plan), "
        "2 wrong usage.",
    )
    add_problem_options(parser)
    parser.add_argument("--output", type=Path, required=True, help="file of the plan (JSON)")
    parser.add_argument(
        "--time-limit", type=seconds, default=1.0, metavar="S", help="[s] of search (default 1)"
    )
    parser.add_argument(
        "--moves",
        type=count,
        metavar="N",
        help="end each search after N moves and not by the clock: the same plan on any machine",
    )
    parser.add_argument("--seed", type=seed, default=1, help="decides among equals (default 1)")
    parser.add_argument("--target", type=int, metavar="COST", help="stop at this cost")
    parser.add_argument(
        "--relax",
        action="store_true",
        help="if there is no plan, print what it would cost to drop each requirement of the "
        "smallest set that contradicts; write no plan then",
    )
    add_json_option(parser)
    options = parser.parse_args(arguments)
    try:
        _plan(options)
    except ConflictError as error:
        if options.json:
            print_json(conflict_findings(str(error), error.conflicts))
        if options.relax and error.conflicts:
            print(f"plan: {error}")
            _relax(error, options)
            return 1
        raise
    return 0


def _relax(error: ConflictError, options: argparse.Namespace) -> None:
    """Print the cost of a plan without each of the requirements that contradict.

    Of several contradictions, each is relaxed without all requirements of the others.
    """
    for number, conflict in enumerate(error.conflicts):
        others = [r for i, other in enumerate(error.conflicts) if i != number for r in other]
        beside = " and the other contradictions" if others else ""
        for dropped in conflict:
            kept = [
                each
                for each in requirements_in(error.documents)
                if each != dropped and each not in others
            ]
            try:
                problem = error.build(keeping(error.documents, kept)).problem
                cost = f"cost {plan_problem(problem, options.time_limit).cost}"
            except InfeasibleError as other:
                cost = f"no plan, {str(other).splitlines()[0]}"
            print(f"without `{dropped.name}`{beside}: {cost}")


def _plan(options: argparse.Namespace) -> None:
    with stages(3, is_json=options.json) as begin:
        begin("reading the order")
        files = read_problem(options)
        problem = files.problem
        tables = tables_of(problem)
        kernel = Kernel()
        begin("making a first plan")
        with stop_on_signals() as stopped:
            started = time.perf_counter()
            planner = AnytimePlanner(kernel, tables, options.seed)
            first = planner.first()
            first_ms = 1e3 * (time.perf_counter() - started)
            _write(first, options.output)
            limit_s = options.time_limit if options.moves is None else math.inf
            limits = Limits(limit_s, options.target, stopped, options.moves)
            begin("searching for a better plan")
            result = planner.improved(limits)
        best = min(first, result.planned, key=lambda planned: planned.cost)
        _write(best, options.output)
    triage = files.prepared.order if files.prepared is not None else None
    if options.json:
        found = triage_of(triage) if triage is not None else None
        print_json(plan_findings(best, files.preferred, _ending(result, limits), found))
        return
    print(f"{problem.name}: cost {best.cost} (makespan {best.makespan}, penalty {best.penalty})")
    print(f"first plan: cost {first.cost} after {first_ms:.1f} ms")
    print(f"search: {_ending(result, limits)}; plan: {options.output}")
    for cable in cable_tasks(problem, best.plan):
        if len(cable.parts) > 1:
            print(cable)
    if triage is not None:
        print_triage(triage, "remodel tasks")


def _ending(result: Result, limits: Limits) -> str:
    if result.complete:
        return "done"
    if limits.stopped():
        return "stopped by a signal"
    if limits.target is not None and result.planned.cost <= limits.target:
        return "target reached"
    return "time limit reached"


def _write(planned: Planned, file: Path) -> None:
    """Write a plan that the checker accepts."""
    require_valid(planned)
    write_json(file, plan_data(planned.plan))
