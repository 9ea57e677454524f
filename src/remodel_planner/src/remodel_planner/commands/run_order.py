"""`rosrun remodel_planner run_order ORDER`: place an order's wires, and report."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import rospy
from tqdm import tqdm

from remodel_planner.commands.database_option import add_database_option
from remodel_planner.core.cell_order import USE_CASE, cell_order
from remodel_planner.core.learning.learned_expectations import LearnedExpectations
from remodel_planner.core.panel_layout import PanelLayout, PanelRules, lay_out
from remodel_planner.core.recovery.fault import Do
from remodel_planner.core.recovery.history import Recovery
from remodel_planner.core.run import Execution
from remodel_planner.core.run_report import Report, failure_line
from remodel_planner.core.use_case.model import UseCase
from remodel_planner.core.use_case.planned_tasks import PlannedTask, planned_tasks
from remodel_planner.core.use_case.preparation import prepare
from remodel_planner.core.use_case.work_order import WorkOrder
from remodel_planner.edge.catalogue_file import read_catalogue
from remodel_planner.edge.fault_file import read_faults
from remodel_planner.edge.order_planner import plan_problem
from remodel_planner.edge.package_files import catalogue_file
from remodel_planner.edge.production_database import ProductionDatabase, Run
from remodel_planner.edge.report_files import write_report
from remodel_planner.edge.use_case_files import find_use_case
from remodel_planner.errors import CellError, PlannerError
from remodel_planner.ros.storyteller import Storyteller
from remodel_planner.ros.use_case_supervisor import UseCaseSupervisor, WireRun

# [s] of search for the best order: some wires, against minutes of work.
_PLANNING_S = 0.5

# What is done about a failed task, told to a person.
DONE = {
    Do.NEW_PART: "feeding a new wire",
    Do.REPLAN: "its turn comes later",
    Do.SET_ASIDE: "set aside",
    Do.STOP: "stopping",
}


def main(arguments: list[str] | None = None) -> int:
    """Place the wires, print one line a wire, write the report, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="run_order",
        description="Place the wires of an order in the cell, one after another, and report.",
        epilog="Exit code: 0 all wires placed, 1 not all, 2 wrong usage or no such order, 3 cell, "
        "engine or synthesizer is not there or refuses.",
    )
    parser.add_argument("order", help="name of the order in the production database")
    parser.add_argument("--wires", type=int, default=6, help="how many, from the first (default 6)")
    parser.add_argument(
        "--output", type=Path, default=Path("out/run"), help="folder of charts and report"
    )
    add_database_option(parser)
    options = parser.parse_args(rospy.myargv()[1:] if arguments is None else arguments)
    if options.wires < 1:
        parser.error(f"--wires must be at least 1, found {options.wires}")
    try:
        database = ProductionDatabase(options.database)
        order = database.order(options.order).in_cabinet().first(options.wires)
        layout = lay_out(order, read_catalogue(catalogue_file()), PanelRules())
        use_case = find_use_case(USE_CASE)
        recovery = Recovery(read_faults(), use_case.recovery)
        learned = LearnedExpectations(use_case.expectations, database.ability_calls())
        replan = partial(_planned, cell_order(layout), use_case, learned)
        tasks = replan([cut.wire.name for cut in layout.wires])
    except PlannerError as error:
        print(f"run_order: {error}", file=sys.stderr)
        return 2
    rospy.init_node("use_case_supervisor")
    try:
        charts = options.output.resolve() / "charts"
        charts.mkdir(parents=True, exist_ok=True)
        supervisor = UseCaseSupervisor(database, charts, recovery, replan)
        run = database.start_run(order)
        report = _run(run, supervisor, layout, tasks)
    except PlannerError as error:
        print(f"run_order: {error}", file=sys.stderr)
        return 3
    finally:
        database.close()
    page = write_report(report, options.output)
    _sum_up(report, page)
    print(f"story: rosrun remodel_planner explain {run.id} --database {options.database}")
    if report.stopped:
        print(f"run_order: {report.stopped}", file=sys.stderr)
        return 3
    return 0 if report.complete else 1


def _planned(
    order: WorkOrder, use_case: UseCase, learned: LearnedExpectations, names: Collection[str]
) -> tuple[PlannedTask, ...]:
    """Return the tasks of these names in the best order that is found in a moment."""
    tasks = tuple(task for task in order.tasks if task.name in names)
    prepared = prepare(replace(order, tasks=tasks), use_case, expectations=learned)
    planned = plan_problem(prepared.preferred.problem, _PLANNING_S)
    return tuple(planned_tasks(prepared, planned.plan))


def _run(
    run: Run,
    supervisor: UseCaseSupervisor,
    layout: PanelLayout,
    tasks: Sequence[PlannedTask],
) -> Report:
    teller = Storyteller()
    order = run.order
    stories, stopped, overview = [], "", ()
    print(f"order {order.name}: {len(order.wires)} wires, {len(order.components)} components")
    print(f"plan: {' '.join(task.name for task in tasks)}")
    started = time.monotonic()
    with tqdm(
        total=len(order.wires), unit="wire", file=sys.stdout, leave=False, disable=None
    ) as bar:
        try:
            for wire_run in supervisor.run(run, layout, PanelRules(), tasks):
                bar.write(_line(wire_run))
                bar.update(wire_run.last)
                stories.append(teller.story(wire_run))
            overview = teller.overview(supervisor.overview())
        except CellError as error:
            stopped = str(error)
    wall_s = time.monotonic() - started
    return Report(order, len(order.wires), wall_s, tuple(stories), overview, stopped)


def _line(wire_run: WireRun) -> str:
    wire, execution = wire_run.cut.wire, wire_run.execution
    result = "placed" if execution.placed else f"NOT placed ({execution.outcome})"
    if execution.attempt > 1:
        result += f" at attempt {execution.attempt}"
    if wire_run.decision:
        result += f", {DONE[wire_run.decision.do]} ({wire_run.decision.because})"
    head = (
        f"{wire.name:>4}  {wire.a!s:>12} to {wire.b!s:<14} {wire.colour} "
        f"{wire.section_mm2:g} mm2  {result}, {_insertions(execution)}, {execution.cell_s:.1f} s"
    )
    return "\n".join([head, *(f"        {failure_line(f)}" for f in execution.failures)])


def _insertions(execution: Execution) -> str:
    count = execution.tries("InsertCable")
    return f"{count} insertion" + ("" if count == 1 else "s")


def _sum_up(report: Report, page: Path) -> None:
    print(
        f"{report.placed} of {report.planned} wires placed, {report.first_pass} without a failed "
        f"operation; {report.failures} failed operations; {report.cell_s:.0f} s in the cell, "
        f"{report.wall_s:.0f} s on the clock"
    )
    print(f"report: {page}")
