#!/usr/bin/env python3
"""Place thick wires of the household board, each alone on it, through slots of a width.

thick_wires.py WIRE... [--section 6] [--slots 0.007] [--seed 1]; the workspace must be sourced. The
wires that its design draws with 10 mm2 get another section [mm2], and its ducts slots so wide [m].
Prints the lines of `laying.py`. Ends with 1 if a wire is not placed.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

from cabinets import imported, in_cell
from laying import Laying, first_ends_of

from remodel_production.core.board.board import board_of
from remodel_production.edge.design_files import catalogue_file, read_catalogue
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth, share_in_ducts
from remodel_skills.cell import Cell
from remodel_states.edge.exported_tables import read_wire_materials
from remodel_supervision.ros.peers.board_message import board_message
from remodel_tasks.core.orders.board_order import board_order
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import AbilityError
from remodel_work.panel import Panel
from remodel_work.ros.panel_message import panel_from

DESIGN = Path("/usr/share/qelectrotech/examples/tableau_domestique.qet")
CELL = "two_arms_cabinet"
THICK_MM2 = 4.0  # thicker ones get the section
# Slots are so far apart at least, by their width [m].
PITCH_M = 0.0055


def thick_panel(section_mm2: float, slots_m: float) -> Panel:
    """Return the board with all its wires, the thick ones of a section, its slots so wide [m]."""
    order = imported(DESIGN)
    wires = tuple(
        replace(wire, section_mm2=section_mm2) if wire.section_mm2 > THICK_MM2 else wire
        for wire in order.wires
    )
    order = replace(order, wires=wires)
    found, _ = in_cell(order, CELL)
    board = board_of(order, read_catalogue(catalogue_file()))
    message = board_message(found.panel, board_order(board, found.use_case, arms=2))
    panel = panel_from(message, read_wire_materials())
    ducts = tuple(
        replace(duct, slot_width=slots_m, slot_pitch=max(duct.slot_pitch, slots_m + PITCH_M))
        for duct in panel.ducts
    )
    return replace(panel, ducts=ducts)


def main() -> int:
    """Place the wires; return 0 if all are placed."""
    parser = argparse.ArgumentParser(description="Place thick wires through slots of a width.")
    parser.add_argument("wires", nargs="+", metavar="WIRE", help="such as L#3")
    parser.add_argument("--section", type=float, default=6.0, help="[mm2]")
    parser.add_argument("--slots", type=float, default=0.007, help="width [m]")
    parser.add_argument("--seed", type=int, default=1, help="of all noise")
    options = parser.parse_args()
    panel = thick_panel(options.section, options.slots)
    missed = 0
    for wire in options.wires:
        plant = SimulatedPlant(panel, design=read_cell(CELL), seed=options.seed)
        cell = Cell(plant)
        try:
            Laying(cell).place(wire, first_ends_of(panel)[wire])
        except AbilityError as error:
            print(f"{wire}: {error.code.name}: {error}")
        (truth,) = ground_truth(plant, [wire])
        missed += not truth.placed
        verdict = "placed" if truth.placed else "not placed"
        print(f"{wire}: {verdict}, {share_in_ducts(plant, wire):.0%} of its route below the rims")
        cell.close()
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
