#!/usr/bin/env python3
"""How far robots get with anybody's cabinets, from the design file to placed wires.

cabinets.py [DESIGN ...] [--wires 6] [--seed N] [--most 10] [--pictures DIR] [--figures FILE]; the
workspace must be sourced. Each design, by default Debian's QElectroTech projects and the shipped
list and harness, is imported and laid out; the first of the shipped cells that takes its board is
named, with how many wires are for its robots, and why the others are by hand. Of at most so many
cabinets, so many wires are then rehearsed, each alone on its board, by supervisors, charts, skills
and physics in one process: in turn one in the same row, between facing rows, short, long, thin and
thick, drawn with the seed, which is printed. --wires 0 places none, within a minute.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import argparse
import json
import random
import secrets
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

from remodel_planner.commands.options.problem_files import DesignOrder, design_order
from remodel_production.core.board.board import board_of
from remodel_production.core.imports.formats import format_of, import_design
from remodel_production.core.production import Order
from remodel_production.edge.design_files import (
    catalogue_file,
    design_formats,
    read_catalogue,
    read_mappings,
)
from remodel_production.errors import PlannerError
from remodel_rehearsal.stack import Setting, rehearse_wire
from remodel_run.rehearsal import Trial
from remodel_states.edge.exported_tables import read_wire_materials
from remodel_supervision.ros.peers.board_message import board_message
from remodel_tasks.core.decomposition.cell_fit import misfits
from remodel_tasks.core.orders.board_order import board_order
from remodel_work.panel import Panel, PanelWire
from remodel_work.ros.panel_message import panel_from
from remodel_work.routes import PlacedWires

ROOT = Path(__file__).parents[2]
DESIGNS = (
    *sorted(Path("/usr/share/qelectrotech/examples").glob("*.qet")),
    ROOT / "benchmarks/sim/short_wires.csv",
    ROOT / "src/remodel_tasks/examples/harness.yml",
)
CELLS = ("two_arms_cabinet", "large_cabinet")
FORMBOARD_CELL = "two_arms_formboard"
# What counts as short, long, thin and thick [m, mm over the insulation].
SHORT_M, LONG_M, THIN_M, THICK_M = 0.55, 1.50, 0.0026, 0.0034


@dataclass(frozen=True)
class Cabinet:
    """A design in a cell, and its panel."""

    name: str
    cell: str
    design: Order
    panel: Panel


def imported(file: Path) -> Order:
    """Read a design; raises PlannerError when it is refused."""
    data, catalogue = file.read_bytes(), read_catalogue(catalogue_file())
    form = format_of(data, design_formats(read_mappings(None)))
    return import_design(data, form, file.stem, file.name, catalogue).order.in_cabinet()


def in_cell(order: Order, cell: str) -> tuple[DesignOrder, tuple[str, ...]]:
    """Return the tasks of an order in a cell, and why the cell does not take its board."""
    found = design_order(order, SimpleNamespace(use_case=None, cell=cell, arms=2))
    assert found.takes is not None, "the shipped cells say what they take"
    return found, misfits(found.panel, found.takes)


def panel_in(order: Order, found: DesignOrder) -> Panel:
    """Return the panel that the cell gets of an order."""
    board = board_of(order, read_catalogue(catalogue_file()))
    whole = board_order(board, found.use_case, arms=2)
    message = board_message(found.panel, whole, found.work.wires_by_hand)
    return panel_from(message, read_wire_materials())


def kinds(panel: Panel) -> dict[str, Callable[[PanelWire], bool]]:
    """Return the kinds of wires that are placed; rows of devices lie along the panel's y."""
    row = {each.id: round(each.pose[0], 2) for each in panel.components}

    def is_in_one_row(wire: PanelWire) -> bool:
        return row[wire.a_component] == row[wire.b_component]

    return {
        "same row": is_in_one_row,
        "facing rows": lambda wire: not is_in_one_row(wire),
        "short": lambda wire: wire.length < SHORT_M,
        "long": lambda wire: wire.length > LONG_M,
        "thin": lambda wire: wire.diameter <= THIN_M,
        "thick": lambda wire: wire.diameter >= THICK_M,
    }


def chosen(panel: Panel, count: int, rng: random.Random) -> list[tuple[str, PanelWire]]:
    """Return so many wires in ducts, in turn of each kind that the panel has."""
    left = [wire for wire in panel.wires if wire.ducts]
    found: list[tuple[str, PanelWire]] = []
    while left and len(found) < count:
        before = len(found)
        for kind, is_one in kinds(panel).items():
            of_kind = [wire for wire in left if is_one(wire)]
            if of_kind and len(found) < count:
                wire = rng.choice(of_kind)
                left.remove(wire)
                found.append((kind, wire))
        if len(found) == before:
            break
    return found


def placed(cabinet: Cabinet, wire: PanelWire, seed: int, pictures: Path | None) -> Trial:
    """Place a wire on its empty board; return what came of it."""
    setting = Setting(cabinet.design, cabinet.cell)
    if pictures is not None:
        pictures = pictures / cabinet.name
        pictures.mkdir(parents=True, exist_ok=True)
    return rehearse_wire(setting, wire.id, seed, PlacedWires(), {}, pictures).trial


def words_of(trial: Trial) -> str:
    """Return what came of a wire, for a person."""
    if not trial.failures:
        return "placed" if trial.placed else "reported as placed, and is not"
    what = "; ".join(f"{each.code}: {each.text}" for each in trial.failures)
    return f"{'placed after' if trial.placed else 'not placed:'} {what}"


def board_row(file: Path) -> tuple[dict[str, str], Cabinet | None]:
    """Return what the docs say of a design, and its cabinet if a cell takes it."""
    row = {
        "design": file.name,
        "wires": "",
        "plate": "",
        "cell": "",
        "for robots": "",
        "by hand": "",
    }
    try:
        order = imported(file)
    except PlannerError as error:
        return {**row, "cell": f"refused: {str(error)[:60]}"}, None
    is_harness = not board_of(order, read_catalogue(catalogue_file())).is_cabinet
    for cell in (FORMBOARD_CELL,) if is_harness else CELLS:
        found, why = in_cell(order, cell)
        if not why:
            break
    by_hand = Counter(each.kind or each.reason.split(",")[0] for each in found.work.by_hand)
    wires = len(found.work.tasks) + len(found.work.by_hand)
    row |= {
        "wires": str(wires),
        "plate": f"{found.panel.size[0]:.2f} x {found.panel.size[1]:.2f} m",
        "cell": f"none: {why[0]}" if why else cell,
        "for robots": f"{len(found.work.tasks)} ({len(found.work.tasks) / max(1, wires):.0%})",
        "by hand": "; ".join(f"{count} {kind}" for kind, count in by_hand.most_common(3)),
    }
    if why or is_harness:
        return row, None
    return row, Cabinet(file.stem, cell, order, panel_in(order, found))


def main() -> int:
    """Print a row for each design, and one for each wire that is placed."""
    parser = argparse.ArgumentParser(description="How far robots get with anybody's cabinets.")
    parser.add_argument("designs", nargs="*", type=Path, metavar="DESIGN", help="design files")
    parser.add_argument("--wires", type=int, default=6, help="of each cabinet that are placed")
    parser.add_argument("--most", type=int, default=10, help="cabinets of which wires are placed")
    parser.add_argument("--seed", type=int, default=secrets.randbelow(10000), help="of all chance")
    parser.add_argument("--pictures", type=Path, help="folder for pictures of failures")
    parser.add_argument("--figures", type=Path, help="file to which the rows are written")
    options = parser.parse_args()
    rng = random.Random(options.seed)
    print(f"seed {options.seed}", flush=True)
    rows, cabinets = [], []
    for file in options.designs or DESIGNS:
        row, cabinet = board_row(file)
        print("  ".join(filter(None, row.values())), flush=True)
        rows.append(row)
        if cabinet is not None and any(wire.ducts for wire in cabinet.panel.wires):
            cabinets.append((row, cabinet))
    missed = 0
    for row, cabinet in rng.sample(cabinets, min(options.most, len(cabinets))):
        wires = chosen(cabinet.panel, options.wires, rng)
        trials = []
        for kind, wire in wires:
            trials.append(placed(cabinet, wire, options.seed, options.pictures))
            print(f"{cabinet.name}: {wire.id}, {kind}: {words_of(trials[-1])}", flush=True)
        if trials:
            row["at once"] = f"{sum(trial.at_once for trial in trials)} of {len(trials)}"
            row["placed"] = f"{sum(trial.placed for trial in trials)} of {len(trials)}"
        missed += sum(not trial.placed for trial in trials)
    if options.figures is not None:
        options.figures.write_text("".join(f"{json.dumps(row)}\n" for row in rows))
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
