"""`remodel tasks ORDER`: print how the tasks of an order decompose."""

from __future__ import annotations

import argparse

from remodel_planner.commands.options.common import refuses
from remodel_planner.commands.options.problem_files import (
    add_problem_options,
    print_triage,
    read_order,
)
from remodel_tasks.core.decomposition.decomposed import outline_of_order


@refuses("tasks")
def main(arguments: list[str] | None = None) -> int:
    """Print the decompositions, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel tasks",
        description="Print the actions of each task of an order, how long they are expected to "
        "take, which methods were rejected, and why.",
        epilog="Exit code: 0 printed, 1 refused (a file is malformed, or no method does a task), "
        "2 wrong usage.",
    )
    add_problem_options(parser)
    options = parser.parse_args(arguments)
    prepared = read_order(options)
    print("\n".join(outline_of_order(prepared.order, [plan.alone for plan in prepared.plans])))
    print_triage(prepared.order)
    return 0
