"""`remodel layout ORDER`: draw where an order's components and wires are, or write its panel."""

from __future__ import annotations

import argparse
from contextlib import closing
from pathlib import Path

from remodel_planner.commands.options.common import add_database_option, refuses
from remodel_production.core.board.board import board_of
from remodel_production.core.board.drawing import draw_board
from remodel_production.core.board.panel import panel_of
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.edge.design_files import catalogue_file, read_catalogue
from remodel_run.whole_task import counted
from remodel_supervision.ros.peers.board_message import board_message, panel_text
from remodel_tasks.core.decomposition.cell_fit import fitted
from remodel_tasks.core.orders.board_order import board_order, kind_of
from remodel_tasks.edge.cell_takes import cell_takes
from remodel_tasks.edge.document_files import write_text
from remodel_tasks.edge.use_case_files import use_case_for


@refuses("layout")
def main(arguments: list[str] | None = None) -> int:
    """Write the drawing, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel layout",
        description="Draw the board of an order: components, ducts or bundles, clips and wires; or "
        "write it as the panel that a cell builds.",
        epilog="Exit code: 0 written, 1 no such order or a file cannot be written, 2 wrong usage.",
    )
    parser.add_argument("order", help="name of the order in the production database")
    parser.add_argument("--output", type=Path, help="file of the drawing (SVG)")
    parser.add_argument(
        "--panel", type=Path, help="file of the panel (YAML), for `cell.launch panel:=FILE`"
    )
    parser.add_argument(
        "--cell",
        metavar="NAME",
        default="",
        help="that builds the panel, or its file: the panel has no wire that it does not take "
        "(default: the cell of the use case)",
    )
    add_database_option(parser)
    options = parser.parse_args(arguments)
    if not (options.output or options.panel):
        parser.error("give --output FILE, --panel FILE, or both")
    with closing(ProductionDatabase(options.database)) as database:
        order = database.order(options.order)
    catalogue = read_catalogue(catalogue_file())
    board = board_of(order, catalogue)
    if options.output:
        write_text(options.output, draw_board(board, catalogue))
    if options.panel:
        use_case = use_case_for(kind_of(board))
        panel, whole = panel_of(board, catalogue), board_order(board, use_case, arms=1)
        able = fitted(whole, panel, use_case, cell_takes(use_case, options.cell))
        message = board_message(panel, whole, able.wires_by_hand)
        write_text(options.panel, panel_text(message))
    wires = [wire for wire in board.order.wires if wire.name in board.routes]
    total = sum(map(board.length_of, wires))
    things = f"{counted(len(board.devices), 'component')} and {counted(len(wires), 'wire')}"
    print(f"{order.name}: {things}, {total:.1f} m")
    if options.output:
        print(f"drawing: {options.output}")
    if options.panel:
        print(f"panel: {options.panel}")
    return 0
