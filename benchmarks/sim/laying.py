#!/usr/bin/env python3
"""How much faster than real time two robots place wires on a board in which others lie.

laying.py WIRE... [--laid 30] [--seed 1]; the workspace must be sourced. Each wire of the household
board is placed from its feed to its second clamp, without ROS. A line is printed for each ability:
simulated time over the CPU time of this process, and what the cell measured; after the last one the
same of the whole wire, and whether it is placed, by the physics. With --laid, so many other wires
lie along their routes in the ducts before. Ends with 1 at the first wire that is not placed.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

import numpy as np

from remodel_sim.core.wire_mechanics import as_nodes, discretise
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills.abilities.ability import Goal
from remodel_skills.abilities.inserting import FixGoal, InsertGoal, fix_cable, insert_cable
from remodel_skills.abilities.inspection import LocateGoal, locate_gearbox_component
from remodel_skills.abilities.lay_wire import LayGoal, lay_wire
from remodel_skills.abilities.picking import DetectGoal, PickGoal, detect_cable, pick_cable
from remodel_skills.cell import Cell
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.edge.exported_tables import read_wire_materials
from remodel_tasks.core.orders.board_order import first_ends
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array
from remodel_work.panel import BOARD, Panel, PanelWire, WireEnd
from remodel_work.ros.panel_message import read_panel
from remodel_work.routes import ParkedWire, PlacedWires

HOUSEHOLD = Path(__file__).parents[2] / "src/remodel_sim/config/household.yaml"
CELL, GUIDE, HOLDER = "two_arms_cabinet", "robot_1", "robot_2"
FORCE_LIMIT_N, PULL_TEST_N = 14.0, 5.0  # as the use case cabinet
# Laid wires are so far from each other, so many in a layer, above so much of the plate [m].
PITCH_M, LANES, FLOOR_M = 0.0042, 7, 0.0005
# A wire runs straight so far before its opening, and points along it are so far apart [m].
BEFORE_M, FINE_M = 0.005, 0.001

G = TypeVar("G", bound=Goal)
T = TypeVar("T")


class Laying:
    """Places wires in one cell."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell

    def place(self, wire_id: str, first: WireEnd) -> None:
        """Place a wire, its first end first; raises what an ability raises."""
        wire = self.cell.plant.panel.wire(wire_id)
        a, b = (wire.goes_to(end) for end in (first, first.other))
        self.cell.feed(wire_id, "")
        began_s, began_cpu_s = self._cell_s(), time.process_time()
        self._do(GUIDE, detect_cable, DetectGoal(wire_id))
        at_a, at_b = (
            self._do(GUIDE, locate_gearbox_component, LocateGoal(*key)).socket_pose
            for key in (a, b)
        )
        self._do(HOLDER, pick_cable, PickGoal(HOLDER, wire_id, first.other, 0.0))
        self._do(GUIDE, insert_cable, InsertGoal(GUIDE, wire_id, first, *a, at_a, FORCE_LIMIT_N))
        self._do(GUIDE, fix_cable, FixGoal(GUIDE, wire_id, *a, PULL_TEST_N))
        guide, holder = self.cell.contexts[GUIDE], self.cell.contexts[HOLDER]
        steps = lay_wire(holder, guide, LayGoal(HOLDER, GUIDE, wire_id))
        self._timed("LayWire", lambda: self.cell.run(steps, HOLDER, GUIDE))
        insert = InsertGoal(HOLDER, wire_id, first.other, *b, at_b, FORCE_LIMIT_N)
        self._do(HOLDER, insert_cable, insert)
        self._do(HOLDER, fix_cable, FixGoal(HOLDER, wire_id, *b, PULL_TEST_N))
        whole = (self._cell_s() - began_s) / (time.process_time() - began_cpu_s)
        print(f"{whole:6.2f} x  {wire_id}", flush=True)

    def _do(self, robot: str, ability: Callable[[RobotContext, G], Steps[T]], goal: G) -> T:
        context = self.cell.contexts[robot]
        goal.check(context.panel, context.belief, context.parameters)
        name = type(goal).__name__.removesuffix("Goal")
        return self._timed(name, lambda: self.cell.run(ability(context, goal), robot))

    def _timed(self, name: str, deed: Callable[[], T]) -> T:
        began_s, began_cpu_s = self._cell_s(), time.process_time()
        found = deed()
        factor = (self._cell_s() - began_s) / (time.process_time() - began_cpu_s)
        print(f"{factor:6.2f} x  {name}: {getattr(found, 'message', found)}", flush=True)
        return found

    def _cell_s(self) -> float:
        """Return the cell's time since its world was built [s]."""
        world = self.cell.plant.world
        return world.steps * world.time_step


def laid_wires(panel: Panel, wires: int, time_step: float, *, without: str) -> PlacedWires:
    """Return so many wires along their routes in the ducts, both ends in their clamps."""
    chosen = [wire for wire in panel.wires if wire.ducts and wire.id != without][:wires]
    return PlacedWires(
        {
            wire.id: ParkedWire(
                as_nodes(line(panel, wire, place), discretise(wire, time_step)), frozenset(WireEnd)
            )
            for place, wire in enumerate(chosen)
        }
    )


def line(panel: Panel, wire: PanelWire, place: int) -> Array:
    """Return points along a wire's route (n, 3) [m], world frame, in its lane of its layer."""
    layer, lane = divmod(place, LANES)
    aside = (lane - LANES // 2) * PITCH_M
    height = FLOOR_M + wire.radius + layer * PITCH_M
    route = [BOARD.apply(np.array(point)) for point in wire.route]
    inner = [np.array([x + aside, y + aside, height]) for x, y, _ in route[1:-1]]
    ends = []
    for end, at in ((WireEnd.A, route[0]), (WireEnd.B, route[-1])):
        component_id, terminal_id = wire.goes_to(end)
        component = panel.component(component_id)
        terminal = component.terminal(terminal_id)
        socket = panel.world_from_panel @ component.panel_from_component
        axis = (socket @ terminal.component_from_socket).rotation[:, 0]
        ends.append([at + (terminal.depth - 2e-4) * axis, at - BEFORE_M * axis])
    corners = [*ends[0], *inner, *reversed(ends[1])]
    legs = [
        np.linspace(a, b, max(1, round(float(np.linalg.norm(b - a)) / FINE_M)), endpoint=False)
        for a, b in pairwise(corners)
    ]
    return np.vstack([*legs, corners[-1][None]])


def first_ends_of(panel: Panel) -> dict[str, WireEnd]:
    """Return the end of each wire in ducts that is inserted first, as the use case chooses it."""
    paths = {
        wire.id: [(round(1e3 * x), round(1e3 * y)) for x, y, _ in wire.route]
        for wire in panel.wires
        if wire.ducts
    }
    return {name: WireEnd[end.name] for name, end in first_ends(paths).items()}


def main() -> int:
    """Place the wires; return 0 if all are placed."""
    parser = argparse.ArgumentParser(description="How much faster than real time wires are placed.")
    parser.add_argument("wires", nargs="+", metavar="WIRE", help="such as W3")
    parser.add_argument("--laid", type=int, default=0, help="wires in the ducts before the first")
    parser.add_argument("--seed", type=int, default=1, help="of all noise")
    options = parser.parse_args()
    panel = read_panel(HOUSEHOLD, read_wire_materials())
    plant = SimulatedPlant(panel, design=read_cell(CELL), seed=options.seed)
    step = plant.world.time_step
    plant.load(panel, laid_wires(panel, options.laid, step, without=options.wires[0]).parked)
    cell = Cell(plant)
    laying, first = Laying(cell), first_ends_of(panel)
    is_placed = True
    for wire_id in options.wires:
        try:
            laying.place(wire_id, first[wire_id])
        except AbilityError as error:
            print(f"{wire_id}: {error.code.name}: {error}", flush=True)
        (truth,) = ground_truth(plant, [wire_id])
        is_placed = truth.placed
        print(f"{wire_id}: {'placed' if is_placed else 'not placed'}", flush=True)
        if not is_placed:
            break
    cell.close()
    return 0 if is_placed else 1


if __name__ == "__main__":
    sys.exit(main())
