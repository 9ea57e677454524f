"""`remodel explain RUN`: explain a recorded run."""

from __future__ import annotations

import argparse

from remodel_planner.commands.options.common import add_database_option
from remodel_planner.core.run_explanation import explain_run
from remodel_supervision.edge.run_log import kept_run
from remodel_tasks.edge.fault_file import read_faults


def main(arguments: list[str]) -> int:
    """Print the explanation of the run, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel explain",
        description="Print what was done in a recorded run, what failed, what was decided and why.",
        epilog="Exit code: 0 printed, 2 wrong usage, 3 no such run or database.",
    )
    parser.add_argument("run", type=int, metavar="RUN", help="number of the run")
    add_database_option(parser)
    options = parser.parse_args(arguments)
    kept = kept_run(options.database, options.run)
    events = [each.event for each in kept]
    print("\n".join(explain_run(options.run, kept[0].at, events, read_faults())))
    return 0
