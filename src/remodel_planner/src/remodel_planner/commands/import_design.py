"""`rosrun remodel_planner import FILE`: read a design file into the production database."""

from __future__ import annotations

import argparse
import re
import sys
from collections import Counter
from pathlib import Path

from remodel_planner.commands.database_option import add_database_option
from remodel_planner.core.production import Order
from remodel_planner.core.qet import Account, import_qet
from remodel_planner.edge.catalogue_file import read_catalogue
from remodel_planner.edge.package_files import catalogue_file
from remodel_planner.edge.production_database import ProductionDatabase
from remodel_planner.errors import DesignError, PlannerError


def main(arguments: list[str] | None = None) -> int:
    """Import, say what was read, guessed and left out, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="import",
        description="Read a QElectroTech project (.qet) into the production database.",
        epilog="Exit code: 0 imported, 1 refused (nothing is stored), 2 wrong usage.",
    )
    parser.add_argument("file", type=Path, help="design file")
    parser.add_argument("--order", help="name of the order; default: the file's name")
    parser.add_argument("--verbose", action="store_true", help="list every guess and omission")
    add_database_option(parser)
    options = parser.parse_args(arguments)
    name = options.order or re.sub(r"\W+", "_", options.file.stem)
    try:
        order, account = _read(options.file, name)
        database = ProductionDatabase(options.database)
        database.add_order(order)
        database.close()
    except PlannerError as error:
        print(f"import: {error}", file=sys.stderr)
        return 1
    _tell(order, account, verbose=options.verbose)
    return 0


def _read(file: Path, name: str) -> tuple[Order, Account]:
    try:
        text = file.read_bytes()
    except OSError as error:
        raise DesignError(f"{file}: cannot be read: {error.strerror}") from error
    try:
        return import_qet(text, name, file.name, read_catalogue(catalogue_file()))
    except DesignError as error:
        raise DesignError(f"{file}: {error}") from error


def _tell(order: Order, account: Account, *, verbose: bool) -> None:
    direct = len(order.wires) - account.wires_joined
    print(f"imported order {order.name}: {order.title}")
    print(f"  {len(order.components)} components, {len(order.wires)} wires to place")
    print(f"  of {account.conductors} conductors in the file")
    print(f"    {direct} are wires between two devices in the cabinet")
    print(f"    {account.joined} meet at folio references and make {account.wires_joined} wires")
    for reason, count in Counter(item.reason for item in account.left_out).most_common():
        print(f"    {count} left out: {reason}")
    print(f"  {len(account.guesses)} guesses" + ("" if verbose else " (--verbose lists them)"))
    if verbose:
        for note in account.notes:
            print(f"    {note}")
