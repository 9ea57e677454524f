"""`planner run_order ORDER`: place an order's wires, and report."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import rospy

from flexbe_core.ros.master import START_LIMIT_S, NoMasterError, join_interruptibly, require_master
from remodel_planner.commands.options.database_option import add_database_option
from remodel_planner.commands.runs.attempt_reporter import AttemptReporter
from remodel_planner.commands.runs.ends_in_cell import ends_in_cell
from remodel_planner.commands.runs.run_follower import RunFollower
from remodel_planner.core.reports.net_list import net_list
from remodel_planner.core.reports.run_report import Report
from remodel_planner.edge.report_files import write_report
from remodel_planning.core.decomposition.triage import triaged
from remodel_planning.core.orders.board_order import board_order
from remodel_planning.core.orders.cell_order import USE_CASE
from remodel_planning.edge.use_case_files import find_use_case
from remodel_production.core.board.board import board_of
from remodel_production.core.counted import counted
from remodel_production.core.panel.panel_layout import PanelRules, lay_out
from remodel_production.core.production import Order
from remodel_production.edge.catalogue_file import read_catalogue
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.edge.package_files import catalogue_file
from remodel_production.errors import PlannerError
from remodel_supervision.core.runs.abridged import abridged
from remodel_supervision.core.runs.attempts import Attempt
from remodel_supervision.core.runs.events import Ending, Part
from remodel_supervision.core.runs.state import RunState, Stage
from remodel_supervision.edge.run_log import RunLog


def main(arguments: list[str] | None = None) -> int:
    """Place the wires, print one line per attempt, write the report, return the exit code."""
    parser = argparse.ArgumentParser(
        prog="planner run_order",
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
        "--wires", type=int, default=6, help="how many wires, from the first (default 6)"
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
        order = database.order(options.order).in_cabinet()
    except PlannerError as error:
        print(f"run_order: {error}", file=sys.stderr)
        return 1
    try:
        require_master(options.wait)
        join_interruptibly("run_order")
    except NoMasterError as error:
        print(f"run_order: {error}", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        return 130
    follower = RunFollower(RunLog(database), order)
    started = time.monotonic()
    try:
        state = follower.run(options.wires, use_case=options.use_case, again=options.again)
    except PlannerError as error:
        print(f"run_order: {error}", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        print("run_order: interrupted; the supervisor continues the order", file=sys.stderr)
        return 130
    finally:
        database.close()
    wall_s = time.monotonic() - started
    pictures = options.output / "runs" / str(follower.number)
    report = _report(order, follower.attempts, state, pictures=pictures, wall_s=wall_s)
    page = write_report(report, options.output)
    _print_summary(report, page)
    explanation = (
        f"rosrun remodel_planner planner explain {follower.number} --database {options.database}"
    )
    print(f"explanation: {explanation}")
    if report.stopped:
        short = abridged(report.stopped)
        print(f"run_order: {short}", file=sys.stderr)
        if short != report.stopped:
            print(f"all problems: {explanation}", file=sys.stderr)
        return 3
    return 0 if report.complete else 1


def _report(
    order: Order,
    attempts: tuple[Attempt, ...],
    state: RunState,
    pictures: Path,
    wall_s: float,
) -> Report:
    reporter = AttemptReporter(pictures)
    reported = [attempt for attempt in attempts if attempt.part is not Part.CLEAR]
    wires = {wire.name: wire for wire in order.wires}
    lengths = _lengths(order, state) if reported else {}
    reports = tuple(
        reporter.report(attempt, wires.get(name), lengths.get(name, 0.0))
        for attempt in reported
        for name in [attempt.execution.wire]
    )
    overview = reporter.overview(attempts[-1]) if attempts else ()
    is_stopped = state.ended is not None and state.ended.ending is Ending.STOPPED
    stopped = state.ended.because if is_stopped and state.ended else ""
    here = {attempt.execution.wire for attempt in attempts}
    done = [name for name, task in state.tasks.items() if task.stage is Stage.DONE]
    before = frozenset(name for name in done if name not in here)
    return Report(
        order,
        state.whole_tasks,
        wall_s,
        reports,
        overview=overview,
        stopped=stopped,
        before=before,
        triage=_triage(order, state.use_case),
        nets=net_list(order.wires, ends_in_cell()),
    )


def _triage(order: Order, use_case: str) -> tuple[str, ...]:
    """Return a line for each wire by hand, and for wires that are done by another method."""
    if use_case in ("", USE_CASE):
        return ()
    try:
        methods = find_use_case(use_case)
        board = board_of(order, read_catalogue(catalogue_file()))
        found = triaged(board_order(board, methods, arms=1), methods)
    except PlannerError as error:  # the run is over, and its report is worth more than this part
        return (str(error),)
    return tuple(map(str, (*found.other_methods, *found.by_hand)))


def _lengths(order: Order, state: RunState) -> dict[str, float]:
    """Return the length of each wire [m], as it was cut."""
    catalogue = read_catalogue(catalogue_file())
    if state.use_case != USE_CASE:
        board = board_of(order, catalogue)
        return {
            wire.name: board.length_of(wire) for wire in order.wires if wire.name in board.routes
        }
    layout = lay_out(order.first(len(state.tasks)), catalogue, PanelRules())
    return {cut.wire.name: cut.length for cut in layout.wires}


def _print_summary(report: Report, page: Path) -> None:
    before = f" ({len(report.before)} of them before)" if report.before else ""
    if report.has_cables:
        print(f"{report.done} of {counted(len(report.tasks), 'task')} done")
    print(
        f"{report.placed} of {counted(report.planned, 'wire')} placed{before}, "
        f"{report.first_pass} without a failed operation; "
        f"{counted(report.failures, 'failed operation')}; "
        f"{report.cell_s:.0f} s in the cell, {report.wall_s:.0f} s on the clock"
    )
    if report.nets:
        wrong = [net for net in report.nets if not net.is_right]
        right = len(report.nets) - len(wrong)
        print(f"net list: {right} of {counted(len(report.nets), 'wire')} as designed")
        for net in wrong:
            print(f"  {net.wire}: designed {' to '.join(map(str, net.designed))}, found {net.says}")
    print(f"report: {page}")
