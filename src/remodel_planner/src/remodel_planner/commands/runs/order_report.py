"""Put the report of a run together, and write it: what the log has of it, and what the cell built.

An attempt is shown by the charts with the path taken, and the pictures of it.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import rospy
from remodel_msgs.srv import GetGroundTruth

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.export.draw import chart_to_dot
from flexbe_synthesizer.edge.files import dot_picture
from remodel_planner.commands.runs.run_follower import RunFollower
from remodel_planner.core.net_list import FoundEnd, FoundWire, net_list
from remodel_planner.core.run_report import (
    AttemptReport,
    Drawing,
    Picture,
    Report,
    attempt_result,
    render_html,
    report_data,
)
from remodel_production.core.board.board import Board, board_of
from remodel_production.core.board.panel import panel_of
from remodel_production.core.catalogue import Catalogue
from remodel_production.core.production import Order, TerminalRef, Wire
from remodel_production.edge.design_files import catalogue_file, package_folder, read_catalogue
from remodel_production.errors import LostError, PlannerError
from remodel_run.progress import Count
from remodel_run.rehearsal import Rehearsal
from remodel_states.edge.exported_tables import read_abilities
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.attempts import Attempt
from remodel_supervision.core.runs.entries import seen_by
from remodel_supervision.core.runs.events import Ending, Part
from remodel_supervision.core.runs.replay import Trace, trace
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.core.runs.sums import count_of, sums_of
from remodel_supervision.edge.known_behaviors import nested_charts
from remodel_supervision.errors import RefusedError
from remodel_supervision.ros.peers.cell import Cell, running_cell
from remodel_supervision.ros.peers.pictures import jpeg
from remodel_tasks.core.decomposition.cell_fit import fitted
from remodel_tasks.core.orders.board_order import board_order, leaving_plate
from remodel_tasks.core.orders.order_requirements import required_by
from remodel_tasks.edge.cell_takes import cell_takes
from remodel_tasks.edge.fault_file import read_error_names
from remodel_tasks.edge.use_case_files import find_use_case

# The camera that sees the whole cabinet from above.
_CAMERA = "overhead"


def wires_in_cell(order: Order) -> tuple[Mapping[str, FoundWire], str]:
    """Return the wires of which the cell has a piece, by name, or why it did not say.

    Only a simulated cell has the service `cell/ground_truth`.
    """
    try:
        truths = rospy.ServiceProxy("cell/ground_truth", GetGroundTruth)().wires
    except rospy.ServiceException as error:
        return {}, f"the cell gave no ground truth, as no real cell does ({error})"
    terminals = {
        f"{component.name}/{terminal.name}": TerminalRef(component.name, terminal.name)
        for component in order.components
        for terminal in component.terminals
    }

    def found(at: str, fixed: bool) -> FoundEnd:
        ref = terminals.get(at) or TerminalRef(*at.partition("/")[::2])
        return FoundEnd(ref if at else None, fixed)

    return {
        truth.wire_id: FoundWire(
            found(truth.a_at, truth.a_fixed),
            found(truth.b_at, truth.b_fixed),
            duct_length_m=truth.duct_length,
            in_ducts=truth.in_ducts,
        )
        for truth in truths
    }, ""


def picture_of_cabinet() -> tuple[Picture, ...]:
    """Return a picture of the cabinet as it is now; none if the cell takes none."""
    try:
        image = Cell().picture(_CAMERA)
    except (RefusedError, LostError):
        return ()
    return (Picture.of_jpeg("The cabinet at the end, from above", jpeg(image)),)


class AttemptReporter:
    """Makes the reports of attempts at tasks."""

    def __init__(self, pictures: Path) -> None:
        """Take the folder of the run's pictures; those that are not there are left out."""
        self._pictures = pictures
        self._nested = nested_charts()
        self._error_names = read_error_names()

    def report(self, attempt: Attempt, wire: Wire | None, length_m: float) -> AttemptReport:
        """Return the report of one attempt."""
        operations = attempt.execution.operations
        chart = parse_chart(attempt.chart, "record")
        taken = trace(chart, operations, self._nested, self._error_names)
        return AttemptReport(
            wire,
            length_m,
            attempt.execution,
            attempt_result(attempt),
            tuple(_drawings(taken)),
            pictures=tuple(self._picture(name, operations) for name in self._there(attempt)),
        )

    def overview(self, attempt: Attempt) -> tuple[Picture, ...]:
        """Return the picture of the whole cell after an attempt."""
        last = [name for name in self._there(attempt) if name.endswith("_scene.jpg")]
        return tuple(self._read("The cell at the end", name) for name in last)

    def _there(self, attempt: Attempt) -> list[str]:
        return [name for name in attempt.pictures if (self._pictures / name).is_file()]

    def _picture(self, name: str, operations: tuple[Operation, ...]) -> Picture:
        camera, stamp_s = seen_by(name)
        if camera == "scene":
            return self._read("The panel afterwards", name)
        return self._read(_caption(stamp_s, camera, operations), name)

    def _read(self, caption: str, name: str) -> Picture:
        return Picture.of_jpeg(caption, (self._pictures / name).read_bytes())


def _drawings(taken: Trace) -> list[Drawing]:
    caption = f"{taken.chart.name} {taken.path}".strip()
    svg = dot_picture(chart_to_dot(taken.chart, taken.steps), ".svg").decode()
    drawings = [Drawing(caption, svg[svg.index("<svg") :])]
    for child in taken.children:
        drawings += _drawings(child)
    return drawings


def _caption(stamp_s: float, camera: str, operations: tuple[Operation, ...]) -> str:
    """Return which ability made a picture, by the time at which it was made."""
    for operation in operations:
        if operation.ended_s - operation.elapsed_s <= stamp_s <= operation.ended_s:
            return f"{operation.state_path.lstrip('/')}: {camera} camera"
    return f"{camera} camera"


def write_report(report: Report, folder: Path) -> Path:
    """Write report.html and report.json into a folder and return the page's path."""
    folder.mkdir(parents=True, exist_ok=True)
    page = folder / "report.html"
    template = package_folder("remodel_planner") / "templates/report.html.j2"
    colours = {row.name: row.colour for row in read_abilities().values() if row.colour}
    page.write_text(
        render_html(template.read_text(encoding="utf-8"), report, colours), encoding="utf-8"
    )
    data = json.dumps(report_data(report), indent=2, ensure_ascii=False)
    (folder / "report.json").write_text(data + "\n", encoding="utf-8")
    return page


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
