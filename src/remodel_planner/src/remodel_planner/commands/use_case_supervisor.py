"""`rosrun remodel_planner use_case_supervisor`: carry out orders, and lose nothing."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import rospy

from remodel_planner.commands.database_option import add_database_option
from remodel_planner.core.cell_order import USE_CASE
from remodel_planner.edge.escalation_hook import EscalationHook
from remodel_planner.edge.fault_file import read_faults
from remodel_planner.edge.production_database import ProductionDatabase
from remodel_planner.edge.use_case_files import find_use_case
from remodel_planner.errors import PlannerError
from remodel_planner.ros.behavior_synthesizer import BehaviorSynthesizer
from remodel_planner.ros.cell import Cell
from remodel_planner.ros.inspection import Inspection
from remodel_planner.ros.record_server import RecordServer
from remodel_planner.ros.run_server import RunServer
from remodel_planner.ros.task_supervisor import TaskSupervisor
from remodel_planner.ros.use_case_supervisor import Peers
from remodel_planner.ros.work import WorkMaker


def main(arguments: list[str] | None = None) -> int:
    """Serve until ROS shuts this node down, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="use_case_supervisor",
        description="Carry out orders of the production database: action remodel/run_use_case.",
        epilog="Exit code: 0 ended, 2 wrong usage or no such database.",
    )
    parser.add_argument("--cell", default="cell", help="name of this cell (default cell)")
    parser.add_argument(
        "--output", type=Path, default=Path("out/run"), help="folder of charts/ and runs/"
    )
    parser.add_argument(
        "--use-case",
        default=USE_CASE,
        metavar="NAME",
        help=f"by which orders are done (default {USE_CASE}: that of the simulated cell)",
    )
    parser.add_argument(
        "--unattended", action="store_true", help="nobody is there who could answer a question"
    )
    parser.add_argument(
        "--patience",
        type=float,
        default=600.0,
        metavar="S",
        help="how long a lost process may stay away before the run stops (default 600)",
    )
    parser.add_argument(
        "--lease",
        type=float,
        default=30.0,
        metavar="S",
        help="after which silence other cells take this one's task over (default 30)",
    )
    parser.add_argument(
        "--search", type=float, default=0.3, metavar="S", help="for the best order (default 0.3)"
    )
    parser.add_argument(
        "--explore",
        action="store_true",
        help="try other parameters, such as forces, than the use case states, within its bounds,"
        " and learn which are best (default: those of the use case)",
    )
    parser.add_argument(
        "--escalate",
        default="",
        metavar="HOOK",
        help="who is notified of questions: 'command:/path/to/program' gets JSON on its standard"
        " input, 'https://...' as a POST (default nobody)",
    )
    add_database_option(parser)
    options = parser.parse_args(rospy.myargv()[1:] if arguments is None else arguments)
    for name in ("patience", "lease"):
        if not 0 < getattr(options, name) < float("inf"):
            parser.error(f"--{name} must be a number > 0, found {getattr(options, name)}")
    try:
        hook = EscalationHook.from_option(options.escalate, rospy.logwarn)
        database = ProductionDatabase(options.database)
        faults = read_faults()
        find_use_case(options.use_case)
    except PlannerError as error:
        print(f"use_case_supervisor: {error}", file=sys.stderr)
        return 2
    rospy.init_node("use_case_supervisor")
    output = options.output.resolve()
    maker = WorkMaker(
        database,
        faults,
        options.cell,
        output / "charts",
        options.use_case,
        not options.unattended,
        options.patience,
        options.lease,
        options.search,
        options.explore,
        hook,
    )
    peers = Peers(Cell(), BehaviorSynthesizer(), TaskSupervisor(), Inspection())
    servers = (
        RecordServer(database, output / "runs"),
        RunServer(database, maker, peers, options.cell, output / "runs"),
    )
    rospy.spin()
    del servers
    if hook is not None:
        hook.close()
    database.close()
    return 0
