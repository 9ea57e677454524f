"""`rosrun remodel_planner use_case_supervisor`: carry out orders, across restarts."""

from __future__ import annotations

import argparse
import os
import socket
import sys
from pathlib import Path

import rosgraph
import rospy

from flexbe_core.ros.master import NoMasterError, join, require_master, spin
from remodel_planner.commands.options.common import add_database_option
from remodel_production.edge.database.cell_ownership import CellOwnership
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.errors import PlannerError
from remodel_states.core.tables import TableError
from remodel_supervision.edge.escalation_hook import EscalationHook
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.ros.event_loop import RosEventLoop
from remodel_supervision.ros.peers.ability_watch import AbilityWatch
from remodel_supervision.ros.peers.cell import Cell, running_cell
from remodel_supervision.ros.peers.engine_link import BehaviorSynthesizer, EngineLink, Inspection
from remodel_supervision.ros.peers.pictures import CellPictures
from remodel_supervision.ros.server.record_server import RecordServer
from remodel_supervision.ros.server.run_server import RunServer
from remodel_supervision.ros.server.work import WorkMaker
from remodel_supervision.supervisors.ports import Peers
from remodel_tasks.edge.fault_file import read_faults
from remodel_tasks.edge.use_case_files import find_use_case


def main(arguments: list[str] | None = None) -> int:
    """Serve until ROS shuts this node down, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="use_case_supervisor",
        description="Carry out orders of the production database: action remodel/run_use_case.",
        epilog="Exit code: 0 ended, 2 wrong usage, no such database or no ROS master, "
        "130 interrupted before it served.",
    )
    parser.add_argument("--cell", default="cell", help="name of this cell (default cell)")
    parser.add_argument(
        "--output", type=Path, default=Path("out/run"), help="folder of charts/ and runs/"
    )
    parser.add_argument(
        "--use-case",
        default="",
        metavar="NAME",
        help="by which orders are done (default: by what their designs are, docs/use-cases.md)",
    )
    parser.add_argument(
        "--unattended", action="store_true", help="no operator is present to answer questions"
    )
    parser.add_argument(
        "--reconnect-timeout",
        type=float,
        default=600.0,
        metavar="S",
        help="how long a process that is lost or silent may take to answer again before the run "
        "stops (default 600)",
    )
    parser.add_argument(
        "--lease",
        type=float,
        default=30.0,
        metavar="S",
        help="after which silence other cells may take over this one's task (default 30)",
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
        " input, 'https://...' as a POST (default: no notification)",
    )
    add_database_option(parser)
    options = parser.parse_args(rospy.myargv()[1:] if arguments is None else arguments)
    for name in ("reconnect-timeout", "lease"):
        value = getattr(options, name.replace("-", "_"))
        if not 0 < value < float("inf"):
            parser.error(f"--{name} must be a number > 0, found {value}")
    try:
        hook = EscalationHook.from_option(options.escalate, rospy.logwarn)
        database = ProductionDatabase(options.database)
        faults = read_faults()
        if options.use_case:
            find_use_case(options.use_case)
        require_master()
    except (PlannerError, NoMasterError, TableError) as error:
        print(f"use_case_supervisor: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    join("use_case_supervisor")
    output = options.output.resolve()
    maker = WorkMaker(
        database,
        faults,
        options.cell,
        options.use_case,
        attended=not options.unattended,
        reconnect_s=options.reconnect_timeout,
        lease_s=options.lease,
        search_s=options.search,
        explore=options.explore,
        cell_design=running_cell,
        escalation=hook,
    )
    loop = RosEventLoop()
    cell = Cell(loop.background)
    peers = Peers(
        cell,
        BehaviorSynthesizer(loop, output / "charts"),
        EngineLink(loop),
        AbilityWatch(),
        inspection=Inspection(loop),
        pictures=CellPictures(cell, output / "runs"),
    )
    ownership = CellOwnership(database, options.cell, _station(), _holder(), lease_s=options.lease)
    servers = (
        RecordServer(database, output / "runs"),
        RunServer(RunLog(database), maker, peers, ownership, loop=loop),
    )
    exit_code = spin()
    del servers
    if hook is not None:
        hook.close()
    database.close()
    return exit_code


def _station() -> str:
    """Return what identifies this station: a supervisor that is restarted on it is the same."""
    machine = Path("/etc/machine-id")
    known = machine.read_text(encoding="ascii").strip() if machine.is_file() else ""
    return f"{known} {socket.gethostname()} {rosgraph.get_master_uri()}"


def _holder() -> str:
    """Return who this supervisor is, for a person."""
    return (
        f"{rospy.get_name()} on {socket.gethostname()}, process {os.getpid()}, ROS master "
        f"{rosgraph.get_master_uri()}"
    )
