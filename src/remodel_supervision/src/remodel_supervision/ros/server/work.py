"""Make what a run is about: an order from the database, ready for the cell of this node."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace

from remodel_msgs.msg import Panel, Wire

from remodel_production.core.board.board import Board, board_of
from remodel_production.core.board.panel import panel_of
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.edge.design_files import catalogue_file, read_catalogue
from remodel_production.errors import OrderError
from remodel_run.progress import HandWire
from remodel_supervision.core.learning.experience import Experience
from remodel_supervision.edge.escalation_hook import EscalationHook
from remodel_supervision.edge.recorded_lessons import ability_calls
from remodel_supervision.edge.task_leases import TaskLeases
from remodel_supervision.edge.work_planner import WorkPlanner
from remodel_supervision.ros.peers.board_message import board_message
from remodel_supervision.supervisors.ports import Work
from remodel_tasks.core.decomposition.cell_fit import fitted, require_fit
from remodel_tasks.core.orders.board_order import board_order, kind_of
from remodel_tasks.core.orders.order_requirements import (
    OrderRequirements,
    of_plans,
    required_by,
)
from remodel_tasks.core.orders.work_order import Task, WorkOrder
from remodel_tasks.core.problem.preferences import about_wires
from remodel_tasks.core.problem.problem import End
from remodel_tasks.core.task_charts.task_chart import poses
from remodel_tasks.core.use_case.fault import FaultTable
from remodel_tasks.core.use_case.model import UseCase
from remodel_tasks.edge.cell_takes import cell_takes, known_cells
from remodel_tasks.edge.use_case_files import use_case_for


@dataclass
class WorkMaker:
    """Makes work for one cell.

    Attributes:
        database: that has the orders.
        faults: that there are.
        cell: name of the cell.
        use_case: name of the use case by which orders are done whose goal names none; empty: the
            one that is the default for such designs.
        attended: whether there is an operator who can be asked.
        reconnect_s: [s] wall time that a process that is lost or silent gets to answer again.
        lease_s: [s] wall time for which a task is taken.
        search_s: [s] that the search for the best order of tasks gets.
        clock: of these searches [s]; one that is stopped has them do all the work of the time,
            so that their result does not depend on the machine.
        explore: try parameters other than those the use case states, and spare responses that
            hardly ever help, both as recorded runs have taught.
        cell_design: returns the name or file of the cell that runs; empty: that of the use case.
        escalation: is notified of questions; None: they are only shown at the console.
        descriptions: of the tasks made last, for a person, by name.
    """

    database: ProductionDatabase
    faults: FaultTable
    cell: str
    use_case: str
    attended: bool
    reconnect_s: float
    lease_s: float
    search_s: float
    explore: bool = False
    cell_design: Callable[[], str] = str
    escalation: EscalationHook | None = None
    descriptions: Mapping[str, str] = field(default_factory=dict)
    clock: Callable[[], float] = time.monotonic

    def work(self, name: str, use_case: str, tasks: int | Collection[str], owner: int) -> Work:
        """Make the work of an order.

        Args:
            name: of the order.
            use_case: name of the use case; empty: the default.
            tasks: how many, from the first of those that are not by hand; 0 for all. Or the names
                of those that a run began with.
            owner: token of the ownership of the cell.

        Raises:
            PlannerError: if there is no such order, or the cell cannot do it.
        """
        stored = self.database.order(name).in_cabinet()
        catalogue = read_catalogue(catalogue_file())
        board = board_of(stored, catalogue)
        found = use_case_for(kind_of(board), use_case or self.use_case)
        found.recovery.require_known(self.faults)
        preferences = self.database.preferences(name)
        whole = _whole_order(board, found, required_by(preferences))
        laid, takes = panel_of(board, catalogue), cell_takes(found, self.cell_design())
        require_fit(laid, takes, known_cells())
        able = fitted(whole, laid, found, takes)
        panel = board_message(laid, whole, able.wires_by_hand)
        order = _asked(able, panel, found, tasks)
        experience = Experience(found, ability_calls(self.database), explore=self.explore)
        leases = TaskLeases(self.database, name, self.cell, self.lease_s, token=owner)
        self.descriptions = {
            wire.name: f"{wire.a} to {wire.b}, {wire.colour}, {wire.section_mm2:g} mm2"
            for wire in stored.wires
        }
        return Work(
            planner=WorkPlanner(
                order,
                found,
                experience,
                self.search_s,
                documents=_documents(name, preferences, order),
                clock=self.clock,
            ),
            faults=self.faults,
            panel=panel,
            leases=leases,
            attended=self.attended,
            reconnect_s=self.reconnect_s,
            by_hand=tuple(_hand_wires(able, board)),
            notify=self.escalation.notify if self.escalation else lambda event: None,
        )


def _documents(name: str, preferences: object, order: WorkOrder) -> list[tuple[str, object]]:
    """Return what an order's preferences say about the plan of the tasks that are done."""
    if preferences is None:
        return []
    present = {task.name for task in order.tasks}
    return [(f"preferences of order {name}", about_wires(of_plans(preferences), present))]


def _hand_wires(order: WorkOrder, board: Board) -> Iterator[HandWire]:
    """Yield what a person needs to place the wires that are by hand."""
    wires = {wire.name: wire for wire in board.order.wires}
    for each in order.by_hand:
        for name in each.wires:
            wire = wires[name]
            yield HandWire(
                name,
                wire.number,
                str(wire.a),
                str(wire.b),
                wire.colour,
                section_mm2=wire.section_mm2,
                length_m=board.length_of(wire) if name in board.routes else wire.length_m or 0.0,
                reason=each.reason,
            )


def _whole_order(board: Board, use_case: UseCase, required: OrderRequirements) -> WorkOrder:
    """Return the order of all tasks on a board, in the board's frame.

    Raises:
        OrderError: if there is none, or they are no wires.
    """
    order = board_order(board, use_case, arms=1, required=required)
    if not order.tasks:
        raise OrderError(f"order {order.name}: no wire has both its ends in the cabinet")
    # Leases are kept for wires.
    others = {task.name for task in order.tasks} - {wire.name for wire in board.order.wires}
    if others:
        raise OrderError(
            f"order {order.name} cannot be run by use case {use_case.name}: its tasks, such as "
            f"{min(others)}, are no wires of the design; run it by a use case of wires "
            "(designs: {tasks: wires}), or plan it with `remodel plan`"
        )
    return order


def _asked(
    order: WorkOrder, panel: Panel, use_case: UseCase, asked: int | Collection[str]
) -> WorkOrder:
    """Return the tasks that are asked for, in the panel's frame.

    Args:
        order: with all tasks of robots, in the board's frame.
        panel: to build.
        use_case: by which the tasks are done.
        asked: how many are asked for, from the first (0: all), or their names.

    Raises:
        OrderError: if there is none, or one of the names is of none.
    """
    if not order.tasks:
        raise OrderError(
            f"order {order.name}: no task is for the robot: all {len(order.by_hand)} are by hand, "
            f"such as {order.by_hand[0]}"
        )
    if isinstance(asked, int):
        tasks = order.tasks[: asked or None]
    else:
        tasks = tuple(task for task in order.tasks if task.name in asked)
        if lost := {*asked} - {task.name for task in tasks}:
            raise OrderError(
                f"order {order.name}: {min(lost)}, which a run began with, is no task for the "
                "robot now"
            )
    wires = {wire.id: wire for wire in panel.wires}
    return order.with_tasks([_on_panel(task, wires[task.name], use_case) for task in tasks])


def _on_panel(task: Task, wire: Wire, use_case: UseCase) -> Task:
    """Return a task whose path is that of its wire on the panel, in the panel's frame.

    Of a task whose first end the planner chooses, the path stays in the frame of its board.
    """
    if task.first is None:
        return task
    points = [(round(1e3 * p.x, 3), round(1e3 * p.y, 3)) for p in wire.route]
    path = poses(points if task.first is End.A else points[::-1], use_case.cell.carry_height_m)
    return replace(task, values=(*task.values, ("path", path)))
