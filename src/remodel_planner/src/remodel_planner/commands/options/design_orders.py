"""Orders of the production database as tasks of a use case, common to the commands that plan."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from remodel_production.core.board.panel import Panel
    from remodel_production.core.production import Order
    from remodel_states.core.cell import CellLimits
    from remodel_tasks.core.orders.order_requirements import OrderRequirements
    from remodel_tasks.core.orders.work_order import WorkOrder
    from remodel_tasks.core.use_case.model import UseCase

# Tasks by hand that fill a terminal's window, but leave the lines above them on it.
_MOST_LISTED = 20


@dataclass(frozen=True)
class DesignOrder:
    """An imported order as tasks.

    Attributes:
        work: the robots' tasks, and the others by hand.
        use_case: by which they are done.
        panel: of the board.
        takes: what the cell can wire; None: that is not known.
    """

    work: WorkOrder
    use_case: UseCase
    panel: Panel
    takes: CellLimits | None


def add_design_options(parser: argparse.ArgumentParser) -> None:
    """Add --use-case, --cell and --arms."""
    parser.add_argument(
        "--use-case",
        metavar="NAME",
        help="by which an order of the database is done (default: by what its design is, "
        "docs/use-cases.md)",
    )
    parser.add_argument(
        "--cell",
        metavar="NAME",
        default="",
        help="that places an order of the database, or its file: wires that it does not take are "
        "by hand (default: the cell of the use case)",
    )
    parser.add_argument(
        "--arms",
        type=int,
        choices=(1, 2),
        default=2,
        help="that place an order of the database (default 2)",
    )


def design_order(
    stored: Order, options: argparse.Namespace, required: OrderRequirements | None = None
) -> DesignOrder:
    """Return an imported order as tasks.

    Args:
        stored: the order.
        options: those of add_design_options.
        required: of single tasks.

    Raises:
        PlannerError: if the use case takes no designs, or there is no such cell.
    """
    # They take longer to load than most problems to plan, and the commands of files need none.
    from remodel_production.core.board.board import board_of
    from remodel_production.core.board.panel import panel_of
    from remodel_production.edge.design_files import catalogue_file, read_catalogue
    from remodel_tasks.core.decomposition.cell_fit import fitted
    from remodel_tasks.core.orders.board_order import board_order, kind_of
    from remodel_tasks.core.orders.order_requirements import NOTHING_REQUIRED
    from remodel_tasks.edge.cell_takes import cell_takes
    from remodel_tasks.edge.use_case_files import use_case_for

    catalogue = read_catalogue(catalogue_file())
    board = board_of(stored, catalogue)
    use_case = use_case_for(kind_of(board), options.use_case or "")
    takes, panel = cell_takes(use_case, options.cell), panel_of(board, catalogue)
    whole = board_order(board, use_case, options.arms, required or NOTHING_REQUIRED)
    return DesignOrder(fitted(whole, panel, use_case, takes), use_case, panel, takes)


def print_triage(order: WorkOrder, listed_by: str = "") -> None:
    """Print how many tasks are for the robot, by which other methods, and which are by hand.

    Nothing is printed if all tasks are single wires for the robot, by the preferred methods.

    Args:
        order: with all its tasks.
        listed_by: what prints all that are by hand, if only the first ones are to be printed.
    """
    cables, outside = order.cables, order.outside
    if not order.by_hand and not order.other_methods and not cables and not outside:
        return
    print(f"  tasks for the robot: {len(order.whole_tasks)}, by hand: {len(order.by_hand)}")
    if cables:
        cores = sum(map(len, cables.values()))
        are = "1 is a cable" if len(cables) == 1 else f"{len(cables)} are cables"
        print(f"    {are} of {cores} cores, placed one after another by one arm")
    if outside:
        such = f"such as {outside[0]}"
        what = f"{len(outside)} wires leave the plate and are no tasks of the robots, {such}"
        if len(outside) == 1:
            what = f"1 wire leaves the plate and is no task of the robots: {outside[0]}"
        print(f"    {what}")
    shown = order.by_hand[:_MOST_LISTED] if listed_by else order.by_hand
    for line in (*order.other_methods, *shown):
        print(f"    {line}")
    if len(shown) < len(order.by_hand):
        print(f"    and {len(order.by_hand) - len(shown)} more by hand ({listed_by} lists them)")
