"""`planner layout ORDER`: draw where an order's components and wires are."""

from __future__ import annotations

import argparse
from contextlib import closing
from pathlib import Path

from remodel_planner.commands.options.database_option import add_database_option
from remodel_planner.commands.options.entry import refuses
from remodel_production.core.board.board import board_of
from remodel_production.core.board.drawing import draw_board
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.edge.text_file import write_text


@refuses("layout", 1)
def main(arguments: list[str] | None = None) -> int:
    """Write the drawing, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="planner layout",
        description="Draw the board of an order: components, ducts or bundles, clips and wires.",
        epilog="Exit code: 0 drawn, 1 no such order or a file cannot be written, 2 wrong usage.",
    )
    parser.add_argument("order", help="name of the order in the production database")
    parser.add_argument("--output", type=Path, required=True, help="file of the drawing (SVG)")
    add_database_option(parser)
    options = parser.parse_args(arguments)
    with closing(ProductionDatabase(options.database)) as database:
        order = database.order(options.order)
    board = board_of(order)
    write_text(options.output, draw_board(board))
    wires = [wire for wire in board.order.wires if wire.name in board.routes]
    total = sum(map(board.length_of, wires))
    print(f"{order.name}: {len(board.devices)} components and {len(wires)} wires, {total:.1f} m")
    print(f"drawing: {options.output}")
    return 0
