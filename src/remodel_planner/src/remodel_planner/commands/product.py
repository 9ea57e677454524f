"""`remodel product SERIAL`: export what was done to a product."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from remodel_planner.commands.options.common import add_database_option, refuses
from remodel_planner.core.product_record import (
    ProductEntry,
    as_csv,
    as_json,
    product_entries,
)
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_supervision.edge.run_log import RunLog
from remodel_tasks.edge.document_files import write_text


@refuses("product")
def main(arguments: list[str] | None = None) -> int:
    """Write the record of a product, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel product",
        description="Export what was done to a product: each operation with its run, attempt, "
        "goal, parameters, measurements and result, and each answer of an operator. "
        "docs/production-database.md explains the columns.",
        epilog="Exit code: 0 exported, 1 no such product or database, 2 wrong usage.",
    )
    parser.add_argument("serial", metavar="SERIAL", help='serial number, such as "house-0002"')
    parser.add_argument("--format", choices=("csv", "json"), default="csv")
    parser.add_argument("--output", type=Path, metavar="FILE", help="default: standard output")
    add_database_option(parser)
    options = parser.parse_args(arguments)
    with closing(ProductionDatabase(options.database)) as database:
        entries = tuple(_entries(database, options.serial))
    text = as_csv(entries) if options.format == "csv" else as_json(options.serial, entries)
    if options.output is None:
        sys.stdout.write(text)
    else:
        write_text(options.output, text)
    return 0


def _entries(database: ProductionDatabase, serial: str) -> Iterator[ProductEntry]:
    log = RunLog(database)
    for head in log.runs_of(serial):
        events = ((kept.at, kept.event) for kept in log.events(head.number, charts=False))
        order = database.order(head.order)
        yield from product_entries(serial, head.number, head.cell, order, events=events)
