"""Put the report of a run together: what the log has of it, and what the cell says was built."""

from __future__ import annotations

from pathlib import Path

import rospy

from remodel_planner.commands.runs.attempt_reporter import AttemptReporter
from remodel_planner.commands.runs.built_in_cell import picture_of_cabinet, wires_in_cell
from remodel_planner.commands.runs.run_follower import RunFollower
from remodel_planner.core.reports.net_list import net_list
from remodel_planner.core.reports.run_report import Report
from remodel_production.core.board.board import Board, board_of
from remodel_production.core.board.panel import panel_of
from remodel_production.core.catalogue import Catalogue
from remodel_production.core.production import Order
from remodel_production.edge.design_files import catalogue_file, read_catalogue
from remodel_production.errors import PlannerError
from remodel_run.progress import Count
from remodel_run.rehearsal import Rehearsal
from remodel_supervision.core.runs.events import Ending, Part
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.core.runs.sums import count_of, sums_of
from remodel_supervision.ros.peers.cell import running_cell
from remodel_tasks.core.decomposition.cell_fit import fitted
from remodel_tasks.core.orders.board_order import board_order, leaving_plate
from remodel_tasks.core.orders.order_requirements import required_by
from remodel_tasks.edge.cell_takes import cell_takes
from remodel_tasks.edge.use_case_files import find_use_case


def order_report(
    stored: Order,
    follower: RunFollower,
    state: RunState,
    folder: Path,
    rehearsal: Rehearsal | None = None,
    preferences: object = None,
) -> Report:
    """Return the report of a run that has ended.

    Args:
        stored: the order.
        follower: of the run.
        state: in which the run ended.
        folder: of the report, with the run's pictures.
        rehearsal: the order's newest; None: it was not rehearsed.
        preferences: document of the order's preferences; None: it has none.
    """
    order = stored.in_cabinet()
    attempts = follower.attempts
    reporter = AttemptReporter(folder / "runs" / str(follower.number))
    reported = [attempt for attempt in attempts if attempt.part is not Part.CLEAR]
    by_name = {wire.name: wire for wire in order.wires}
    catalogue = read_catalogue(catalogue_file())
    board = board_of(order, catalogue)
    lengths = {w.name: board.length_of(w) for w in order.wires if w.name in board.routes}
    before = [n for n, task in state.tasks.items() if count_of(task, state) is Count.DONE_BEFORE]
    is_stopped = state.ended is not None and state.ended.ending is Ending.STOPPED
    triage = _triage(board, catalogue, state.use_case, preferences)
    if is_stopped and not attempts:  # a cell that refuses a panel keeps another one
        found, unread = {}, "nothing was built"
    else:
        found, unread = wires_in_cell(order)
    return Report(
        order,
        state.whole_tasks,
        follower.wall_s,
        attempts=tuple(
            reporter.report(attempt, by_name.get(name), lengths.get(name, 0.0))
            for attempt in reported
            for name in [attempt.execution.wire]
        ),
        overview=reporter.overview(attempts[-1]) if attempts else (),
        stopped=state.ended.because if is_stopped and state.ended else "",
        before=frozenset(before),
        triage=(*triage, *map(str, leaving_plate(stored))),
        sums=sums_of(state),
        nets=() if unread else net_list(order.wires, state.tasks, found),
        unread=unread,
        simulated_s=follower.ros_s if rospy.get_param("/use_sim_time", False) else None,
        finished=picture_of_cabinet() if attempts else (),
        forecast=rehearsal.forecast if rehearsal is not None else None,
    )


def _triage(
    board: Board, catalogue: Catalogue, use_case: str, preferences: object
) -> tuple[str, ...]:
    """Return a line for each wire by hand, and for wires that are done by another method."""
    if not use_case:  # no run began
        return ()
    try:
        methods = find_use_case(use_case)
        takes, panel = cell_takes(methods, running_cell()), panel_of(board, catalogue)
        whole = board_order(board, methods, arms=1, required=required_by(preferences))
        found = fitted(whole, panel, methods, takes)
    except PlannerError as error:  # the run is over, and its report is worth more than this part
        return (str(error),)
    return tuple(map(str, (*found.other_methods, *found.by_hand)))
