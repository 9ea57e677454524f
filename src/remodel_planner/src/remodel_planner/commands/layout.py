"""`rosrun remodel_planner layout ORDER`: draw where an order's components and wires are."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from remodel_planner.commands.database_option import add_database_option
from remodel_planner.core.board.board import board_of
from remodel_planner.core.board.drawing import draw_board
from remodel_planner.core.order_problem import order_instance
from remodel_planner.edge.json_file import write_json
from remodel_planner.edge.production_database import ProductionDatabase
from remodel_planner.edge.text_file import write_text
from remodel_planner.errors import PlannerError


def main(arguments: list[str] | None = None) -> int:
    """Write the drawing, and the planning problem if it is asked for; return the exit code."""
    parser = argparse.ArgumentParser(
        prog="layout",
        description="Draw the board of an order: components, ducts or bundles, clips and wires.",
        epilog="Exit code: 0 drawn, 1 no such order or a file cannot be written, 2 wrong usage.",
    )
    parser.add_argument("order", help="name of the order in the production database")
    parser.add_argument("--output", type=Path, required=True, help="file of the drawing (SVG)")
    parser.add_argument(
        "--instance", type=Path, metavar="FILE", help="file of the planning problem (planbench-1)"
    )
    parser.add_argument(
        "--arms", type=int, choices=(1, 2), default=2, help="of the planning problem (default 2)"
    )
    add_database_option(parser)
    options = parser.parse_args(arguments)
    try:
        database = ProductionDatabase(options.database)
        try:
            order = database.order(options.order)
        finally:
            database.close()
        board = board_of(order)
        write_text(options.output, draw_board(board))
        if options.instance is not None:
            write_json(options.instance, order_instance(order, options.arms))
    except PlannerError as error:
        print(f"layout: {error}", file=sys.stderr)
        return 1
    total = sum(board.length_of(wire) for wire in board.order.wires if wire.name in board.ways)
    print(
        f"{order.name}: {len(board.devices)} components and {len(board.ways)} wires, {total:.1f} m"
    )
    print(f"drawing: {options.output}")
    return 0
