"""`remodel run ORDER`: place an order's wires, and report."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import rospy

from flexbe_core.ros.master import START_LIMIT_S, NoMasterError, join_interruptibly, require_master
from remodel_planner.commands.options.common import add_database_option
from remodel_planner.commands.runs.order_report import order_report, write_report
from remodel_planner.commands.runs.run_follower import RunFollower
from remodel_planner.core.run_report import summary_lines
from remodel_production.edge.database.production_database import ProductionDatabase, last_rehearsal
from remodel_production.errors import PlannerError
from remodel_supervision.core.runs.step import abridged
from remodel_supervision.edge.run_log import RunLog


def main(arguments: list[str] | None = None) -> int:
    """Place the wires, print one line per attempt, write the report, return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel run",
        description="Let the use case supervisor place the wires of an order, and report.",
        epilog="Exit code: 0 all wires placed, 1 not all, or no such order, 2 wrong usage, 3 ROS "
        "master, cell, engine, synthesizer or supervisor is not running or refuses, 130 "
        "interrupted.",
    )
    parser.add_argument("order", help="name of the order in the production database")
    parser.add_argument(
        "--use-case",
        default="",
        metavar="NAME",
        help="by which the order is done (default: the supervisor's; docs/use-cases.md)",
    )
    parser.add_argument(
        "--wires",
        type=int,
        default=6,
        help="how many wires, from the first that robots place (default 6)",
    )
    parser.add_argument(
        "--again", action="store_true", help="place wires again that are placed already"
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("out/run"),
        help="folder of the report, and of the supervisor's pictures (default out/run)",
    )
    parser.add_argument(
        "--wait",
        type=float,
        default=START_LIMIT_S,
        metavar="S",
        help=f"how long a ROS master may take to answer (default {START_LIMIT_S:g})",
    )
    add_database_option(parser)
    options = parser.parse_args(rospy.myargv()[1:] if arguments is None else arguments)
    if options.wires < 1:
        parser.error(f"--wires must be at least 1, found {options.wires}")
    try:
        database = ProductionDatabase(options.database)
        stored = database.order(options.order)
        order = stored.in_cabinet()
        rehearsal = last_rehearsal(database, options.order)
        preferences = database.preferences(options.order)
    except PlannerError as error:
        print(f"run: {error}", file=sys.stderr)
        return 1
    try:
        require_master(options.wait)
        join_interruptibly("run_order")
    except NoMasterError as error:
        print(f"run: {error}", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        return 130
    follower = RunFollower(RunLog(database), order)
    try:
        state = follower.run(options.wires, use_case=options.use_case, again=options.again)
    except PlannerError as error:
        print(f"run: {error}", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        print("run: interrupted; the supervisor continues the order", file=sys.stderr)
        return 130
    finally:
        database.close()
    report = order_report(stored, follower, state, options.output, rehearsal, preferences)
    print(*summary_lines(report), sep="\n")
    try:
        print(f"report: {write_report(report, options.output)}")
    except OSError as error:
        print(f"run: the report cannot be written: {error}", file=sys.stderr)
    explanation = f"remodel explain {follower.number} --database {options.database}"
    print(f"explanation: {explanation}")
    if report.stopped:
        short = abridged(report.stopped)
        print(f"run: {short}", file=sys.stderr)
        if short != report.stopped:
            print(f"all problems: {explanation}", file=sys.stderr)
        return 3
    return 0 if report.complete else 1
