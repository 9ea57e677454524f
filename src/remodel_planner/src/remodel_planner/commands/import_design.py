"""`remodel import FILE`: read a design file into the production database."""

from __future__ import annotations

import argparse
import json
import re
from collections import Counter
from contextlib import closing
from dataclasses import replace
from pathlib import Path

from remodel_planner.commands.options.common import add_database_option, refuses, stages
from remodel_planner.commands.options.documents import add_json_option, print_json, triage_of
from remodel_planner.commands.options.problem_files import (
    DesignOrder,
    add_design_options,
    build_of,
    built,
    design_order,
    print_triage,
)
from remodel_production.core.board.board import board_of, cut_longer, length_findings
from remodel_production.core.board.cabinet import laid_out
from remodel_production.core.catalogue import Catalogue
from remodel_production.core.imports.design_format import ALL, Asked, DesignFormat
from remodel_production.core.imports.formats import WIRE_LIST, format_of, import_design
from remodel_production.core.imports.values import Imported
from remodel_production.core.imports.wire_list import mapping_draft
from remodel_production.core.production import Order
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.edge.design_files import (
    catalogue_file,
    design_formats,
    read_abilities,
    read_catalogue,
    read_design,
    read_mappings,
    read_placement,
)
from remodel_production.errors import DesignError, PlannerError, blamed
from remodel_run import findings
from remodel_run.whole_task import counted
from remodel_tasks.core.decomposition.cell_fit import misfits, summary
from remodel_tasks.core.orders.order_requirements import required_by
from remodel_tasks.edge.cell_takes import known_cells, named_cell
from remodel_tasks.edge.document_files import read_yaml
from remodel_tasks.edge.use_case_files import use_case_names


@refuses("import")
def main(arguments: list[str] | None = None) -> int:
    """Import, report what was read, assumed and left out, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel import",
        description="Read a design file into the production database: a QElectroTech project, a "
        "KBL, VEC or WireViz harness, a from-to list (CSV or XLSX), or a file of an importer "
        "plug-in's format.",
        epilog="Exit code: 0 imported, 1 refused (nothing is stored), 2 wrong usage.",
    )
    parser.add_argument("file", type=Path, help="design file")
    parser.add_argument("--order", help="name of the order; default: the file's name")
    parser.add_argument(
        "--format",
        choices=[form.name for form in design_formats(())],
        help="of the file; default: by its content",
    )
    parser.add_argument(
        "--mapping", type=Path, metavar="FILE", help="YAML of what the columns of a list mean"
    )
    parser.add_argument(
        "--placement",
        type=Path,
        metavar="FILE",
        help="YAML of which devices are on the plate, in the door, or outside",
    )
    parser.add_argument(
        "--print-mapping",
        action="store_true",
        help="print the mapping by which a list is read, to correct it for --mapping; import "
        "nothing",
    )
    parser.add_argument(
        "--prepend",
        type=Path,
        metavar="FILE",
        action="append",
        default=[],
        help="WireViz file to read before the harness, such as of templates; may be repeated",
    )
    parser.add_argument(
        "--module",
        metavar="NAME",
        action="append",
        default=[],
        help="part number of a module or of a harness configuration of a KBL or VEC file, whose "
        "wires are imported, with those of no module; may be repeated (default: all modules)",
    )
    parser.add_argument(
        "--variant",
        metavar="CODE",
        action="append",
        default=[],
        help="variant code that the vehicle of a KBL or VEC file has; only wires whose conditions "
        "hold for the codes given are imported; may be repeated (default: all variants)",
    )
    parser.add_argument(
        "--preferences", type=Path, metavar="FILE", help="YAML of what a user prefers and requires"
    )
    parser.add_argument("--verbose", action="store_true", help="list every assumption and omission")
    add_design_options(parser)
    add_database_option(parser)
    add_json_option(parser)
    options = parser.parse_args(arguments)
    if options.cell:
        named_cell(options.cell)
    name = options.order or re.sub(r"\W+", "_", options.file.stem)
    catalogue = read_catalogue(catalogue_file())
    if options.print_mapping:
        data, mappings = read_design(options.file), read_mappings(options.mapping)
        with blamed(options.file):
            draft = mapping_draft(data, catalogue, mappings)
        print(json.dumps(draft.document) if options.json else draft.text.rstrip("\n"))
        return 0
    with stages(4, is_json=options.json) as begin:
        begin(f"reading {options.file.name}")
        imported = _read(options, name, read_placement(options.placement, catalogue))
        begin("laying out the board")
        order = laid_out(imported.order, catalogue)
        preferences = _preferences(options, order)
        begin("storing the order")
        with closing(ProductionDatabase(options.database)) as database:
            database.add_order(order, preferences, read_abilities())
        begin("looking for the wires that robots place")
        lengths = _length_findings(imported, order, catalogue)
        try:
            required = required_by(preferences)
            design: DesignOrder | PlannerError = design_order(order, options, required)
        except PlannerError as error:
            design = error
    if options.json:
        print_json(_findings(imported, lengths, design))
        return 0
    _report(imported, verbose=options.verbose)
    _report_lengths(lengths, verbose=options.verbose)
    _report_triage(design, verbose=options.verbose)
    return 0


def _read(options: argparse.Namespace, name: str, catalogue: Catalogue) -> Imported:
    file: Path = options.file
    formats = design_formats(read_mappings(options.mapping))
    data, parts = read_design(file), ""
    chosen = options.format or (WIRE_LIST if options.mapping else None)
    before = [(each.name, read_design(each)) for each in options.prepend]
    try:
        form = (
            next(form for form in formats if form.name == chosen)
            if chosen
            else format_of(data, formats)
        )
        if before:
            if form.join is None:
                raise _unfit("--prepend", form, [each for each in formats if each.join])
            joined = form.join(before, data)
            data, parts = joined.data, joined.parts
        asked = Asked(tuple(options.module), tuple(options.variant))
        if asked != ALL:
            if form.read_modules is None:
                option = "--module" if options.module else "--variant"
                raise _unfit(option, form, [each for each in formats if each.read_modules])
            read = form.read_modules
            form = replace(form, read=lambda *given: read(*given, asked))
        imported = import_design(data, form, name, file.name, catalogue)
    except DesignError as error:
        raise DesignError(f"{file}: {error}{parts}") from error
    if not before:
        return imported
    account = imported.account
    note = f"the file is read after others{parts}"
    account = replace(account, assumptions=(note, *account.assumptions))
    return Imported(replace(imported.order, notes=account.notes), account)


def _unfit(option: str, form: DesignFormat, fitting: list[DesignFormat]) -> DesignError:
    names = " and ".join(each.name for each in fitting)
    return DesignError(f"{option} is for files of format {names}; this is one of {form.name}")


def _preferences(options: argparse.Namespace, order: Order) -> object:
    """Return the document of the preferences in a file, which fit the order; None for no file."""
    file: Path | None = options.preferences
    if file is None:
        return None
    with blamed(file):
        document = read_yaml(file)
    built(build_of(order, options, frozenset()), [(str(file), document)])
    return document


def _report_lengths(lengths: findings.Lengths, *, verbose: bool) -> None:
    """Print which lengths do not fit the board, or are not what is needed."""
    for lines, what in zip(
        (lengths.too_short, lengths.too_long, lengths.rings, lengths.cut_longer),
        (
            (
                "wire",
                "is shorter than its route",
                "are shorter than their routes",
                " on the board.",
            ),
            (
                "wire",
                "is more than three times as long as its route",
                "are more than three times as long as their routes",
                "; is the unit right?",
            ),
            (
                "bundle",
                "is longer than the others of its ring together",
                "are longer than the others of their rings together",
                ": the connectors cannot stand so.",
            ),
            (
                "wire",
                "is cut longer than needed",
                "are cut longer than needed",
                ", for robots to lay: the ducts take the slack.",
            ),
        ),
        strict=True,
    ):
        if not lines:
            continue
        text = f"  {counted(len(lines), what[0])} {what[1 + (len(lines) > 1)]}{what[-1]}"
        print(text if verbose else f"{text} The worst: {lines[0]}")
        if verbose:
            print("\n".join(f"    {line}" for line in lines))


def _length_findings(imported: Imported, order: Order, catalogue: Catalogue) -> findings.Lengths:
    """Return what is to say of the lengths of wires, and of bundles; lines of each kind."""
    stated = {wire.name for wire in imported.order.wires if wire.length_m is not None}
    board = board_of(order, catalogue)
    cut = cut_longer(board, stated, catalogue.cabinet)
    return findings.Lengths(*length_findings(board, stated), cut)


def _findings(
    imported: Imported, lengths: findings.Lengths, design: DesignOrder | PlannerError
) -> findings.Imported:
    """Return what is printed with --json."""
    order, cell = imported.order, None
    planned = None if isinstance(design, PlannerError) else design
    if planned is not None and planned.takes is not None:
        cell = findings.CellFit(
            planned.takes.cell,
            summary(planned.work, planned.panel, planned.takes, known_cells()),
            tuple(misfits(planned.panel, planned.takes)),
        )
    things = ("components", "wires", "cables", "segments", "clips")
    return findings.Imported(
        order.name,
        order.title,
        {name: len(getattr(order, name)) for name in things},
        wires_in_cabinet=len(order.in_cabinet().wires),
        account=imported.account,
        lengths=lengths,
        use_cases=tuple(use_case_names()),
        triage=triage_of(planned.work) if planned is not None else None,
        nothing_to_plan=str(design) if planned is None else "",
        cell=cell,
    )


def _report_triage(design: DesignOrder | PlannerError, *, verbose: bool) -> None:
    """Print which wires are by hand, or why nothing of the order can be planned."""
    if isinstance(design, PlannerError):
        print(f"  nothing to plan: {design}")
        return
    if design.takes is not None:
        print(f"  {summary(design.work, design.panel, design.takes, known_cells())}")
    print_triage(design.work, "" if verbose else "--verbose")
    if verbose:
        for line in design.work.outside:
            print(f"    {line}")


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
    print(f"\n  of {counted(account.connections, account.unit.removesuffix('s'))} in the file")
    plain = len(order.wires) - account.wires_joined
    print(f"    {plain} {'is a wire' if plain == 1 else 'are wires'}")
    if account.joined:
        print(f"    {account.joined} are merged into {counted(account.wires_joined, 'wire')}")
    for reason, count in Counter(item.reason for item in account.left_out).most_common():
        print(f"    {count} left out: {reason}")
    for column in account.unused_columns:
        print(f"  {column}")
    if inside < len(order.wires):
        lie, leaves = "lies" if inside == 1 else "lie", len(order.wires) - inside
        leave = "leaves" if leaves == 1 else "leave"
        print(f"  {counted(inside, 'wire')} {lie} on the plate, {leaves} {leave} it")
    if account.unknown_colours:
        count = counted(len(account.unknown_colours), "colour")
        print(f"  {count} not known, such as {account.unknown_colours[0]}")
    hint = "" if verbose else " (--verbose lists them)"
    assumptions = counted(len(account.assumptions), "assumption")
    print(f"  {assumptions}, {counted(len(account.ignored), 'other omission')}{hint}")
    if verbose:
        for note in account.notes:
            print(f"    {note}")
