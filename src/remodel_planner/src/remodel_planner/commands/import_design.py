"""`planner import FILE`: read a design file into the production database."""

from __future__ import annotations

import argparse
import re
from collections import Counter
from contextlib import closing
from pathlib import Path

from remodel_planner.commands.options.database_option import add_database_option
from remodel_planner.commands.options.design_orders import (
    add_design_options,
    design_order,
    print_by_hand,
)
from remodel_planner.commands.options.entry import refuses
from remodel_planning.core.decomposition.preparation import prepare
from remodel_planning.edge.yaml_file import read_yaml
from remodel_production.core.board.cabinet import laid_out
from remodel_production.core.catalogue import Catalogue
from remodel_production.core.counted import counted
from remodel_production.core.imports.formats import DesignFormat, format_of, import_design
from remodel_production.core.imports.shared.account import Imported
from remodel_production.core.imports.wire_list import mapping_draft
from remodel_production.core.production import Order
from remodel_production.edge.ability_files import read_abilities
from remodel_production.edge.catalogue_file import read_catalogue
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.edge.design_files import read_design, read_mappings
from remodel_production.edge.package_files import catalogue_file
from remodel_production.errors import DesignError, PlannerError, blamed


@refuses("import", 1)
def main(arguments: list[str] | None = None) -> int:
    """Import, report what was read, assumed and left out, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="planner import",
        description="Read a design file into the production database: a QElectroTech project, a "
        "KBL or WireViz harness, or a from-to list (CSV).",
        epilog="Exit code: 0 imported, 1 refused (nothing is stored), 2 wrong usage.",
    )
    parser.add_argument("file", type=Path, help="design file")
    parser.add_argument("--order", help="name of the order; default: the file's name")
    parser.add_argument(
        "--format",
        type=DesignFormat,
        choices=list(DesignFormat),
        metavar="{" + ",".join(form.value for form in DesignFormat) + "}",
        help="of the file; default: by its content",
    )
    parser.add_argument(
        "--mapping", type=Path, metavar="FILE", help="YAML of what the columns of a CSV file mean"
    )
    parser.add_argument(
        "--print-mapping",
        action="store_true",
        help="print the mapping by which a CSV file is read, to correct it for --mapping; import "
        "nothing",
    )
    parser.add_argument(
        "--preferences", type=Path, metavar="FILE", help="YAML of what a user prefers and requires"
    )
    parser.add_argument("--verbose", action="store_true", help="list every assumption and omission")
    add_design_options(parser)
    add_database_option(parser)
    options = parser.parse_args(arguments)
    name = options.order or re.sub(r"\W+", "_", options.file.stem)
    catalogue = read_catalogue(catalogue_file())
    if options.print_mapping:
        data, mappings = read_design(options.file), read_mappings(options.mapping)
        with blamed(options.file):
            print(mapping_draft(data, catalogue, mappings), end="")
        return 0
    imported = _read(options, name, catalogue)
    order = laid_out(imported.order, catalogue)
    preferences = _preferences(options, order)
    with closing(ProductionDatabase(options.database)) as database:
        database.add_order(order, preferences, read_abilities())
    _report(imported, verbose=options.verbose)
    _report_triage(order, options)
    return 0


def _read(options: argparse.Namespace, name: str, catalogue: Catalogue) -> Imported:
    file: Path = options.file
    mappings = read_mappings(options.mapping)
    data = read_design(file)
    try:
        form = options.format or (
            DesignFormat.WIRE_LIST if options.mapping else format_of(data, mappings)
        )
        return import_design(data, form, name, file.name, catalogue=catalogue, mappings=mappings)
    except DesignError as error:
        raise DesignError(f"{file}: {error}") from error


def _preferences(options: argparse.Namespace, order: Order) -> object:
    """Return the document of the preferences in a file, which fit the order; None for no file."""
    file: Path | None = options.preferences
    if file is None:
        return None
    with blamed(file):
        document = read_yaml(file)
    work, use_case = design_order(order, options)
    prepare(work, use_case, [(str(file), document)])
    return document


def _report_triage(order: Order, options: argparse.Namespace) -> None:
    """Print which wires are by hand, or why nothing of the order can be planned."""
    try:
        work, _ = design_order(order, options)
    except PlannerError as error:
        print(f"  nothing to plan: {error}")
    else:
        print_by_hand(work)


def _report(imported: Imported, *, verbose: bool) -> None:
    order, account = imported.order, imported.account
    inside = len(order.in_cabinet().wires)
    print(f"imported order {order.name}: {order.title}")
    print(
        f"  {counted(len(order.components), 'component')}, {counted(len(order.wires), 'wire')}",
        end="",
    )
    for things, what in (
        (order.cables, "cable"),
        (order.segments, "segment"),
        (order.clips, "clip"),
    ):
        print(f", {counted(len(things), what)}" if things else "", end="")
    print(f"\n  of {account.connections} {account.unit} in the file")
    print(f"    {len(order.wires) - account.wires_joined} are wires")
    if account.joined:
        print(f"    {account.joined} are merged into {counted(account.wires_joined, 'wire')}")
    for reason, count in Counter(item.reason for item in account.left_out).most_common():
        print(f"    {count} left out: {reason}")
    for column in account.unused_columns:
        print(f"  {column}")
    if inside < len(order.wires):
        print(f"  {inside} wires lie in the cabinet, {len(order.wires) - inside} leave it")
    hint = "" if verbose else " (--verbose lists them)"
    print(f"  {len(account.assumptions)} assumptions, {len(account.ignored)} other omissions{hint}")
    if verbose:
        for note in account.notes:
            print(f"    {note}")
