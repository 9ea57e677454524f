#!/usr/bin/env python3
"""Wire a board's wires through its ducts with two robots, without ROS, and compare with the truth.

laying.py WIRE... [--first b] [--seed 1] [--cell two_arms_cabinet] [--panel FILE] [--laid 30]
[--pictures DIR]; the workspace must be sourced. Each wire of the household board, or of a panel
that `remodel layout --panel FILE` wrote, is placed from its feed to its second clamp: robot_1
inserts the first end and leads the wire (LayWire), robot_2 holds the other end and inserts it. A
line is printed for each step: wall time, the cell's time since the feed, and what the cell
measured; after the last one, how much faster than real time the wire was placed, where the ends sit
and which share of the route in ducts is below the rims, by the physics. With --laid, so many others
lie in the ducts before. Ends with 1 at the first wire that is not placed.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import cv2
from laid_board import laid_wires

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth, share_in_ducts
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
from remodel_work.panel import Panel, WireEnd
from remodel_work.ros.panel_message import read_panel

HOUSEHOLD = Path(__file__).parents[2] / "src/remodel_sim/config/household.yaml"
GUIDE, HOLDER = "robot_1", "robot_2"
FORCE_LIMIT_N, PULL_TEST_N = 14.0, 5.0  # as the use case cabinet

G = TypeVar("G", bound=Goal)
T = TypeVar("T")


class Laying:
    """Places wires in one cell."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        self._began, self._began_cpu = time.monotonic(), time.process_time()

    def place(self, wire_id: str, first: WireEnd) -> None:
        """Place a wire, its first end first; raises what an ability raises."""
        self._began_cpu = time.process_time()
        wire = self.cell.plant.panel.wire(wire_id)
        a, b = (wire.goes_to(end) for end in (first, first.other))
        self.cell.feed(wire_id, "")
        self._do(GUIDE, detect_cable, DetectGoal(wire_id))
        at_a, at_b = (
            self._do(GUIDE, locate_gearbox_component, LocateGoal(*key)).socket_pose
            for key in (a, b)
        )
        self._do(HOLDER, pick_cable, PickGoal(HOLDER, wire_id, first.other, 0.0))
        self._insert(InsertGoal(GUIDE, wire_id, first, *a, at_a, FORCE_LIMIT_N))
        self._do(GUIDE, fix_cable, FixGoal(GUIDE, wire_id, *a, PULL_TEST_N))
        lay = LayGoal(HOLDER, GUIDE, wire_id)
        contexts = self.cell.contexts
        steps = lay_wire(contexts[HOLDER], contexts[GUIDE], lay)
        self._tell("LayWire", self.cell.run(steps, HOLDER, GUIDE))
        self._insert(InsertGoal(HOLDER, wire_id, first.other, *b, at_b, FORCE_LIMIT_N))
        self._do(HOLDER, fix_cable, FixGoal(HOLDER, wire_id, *b, PULL_TEST_N))

    def speed(self) -> str:
        """Return how much faster than real time the last wire was placed, for a person."""
        cell, cpu = self._cell_s(), time.process_time() - self._began_cpu
        return f"real-time factor {cell / cpu:.2f} by the CPU time of this process"

    def _insert(self, goal: InsertGoal) -> None:
        """Insert an end, as often as the use case tries."""
        try:
            self._do(goal.robot_name, insert_cable, goal)
        except AbilityError as error:
            self._tell("Insert", f"{error.code.name}: {error}")
            self._do(goal.robot_name, insert_cable, goal)

    def _cell_s(self) -> float:
        """Return the cell's time since the wire was fed [s]."""
        world = self.cell.plant.world
        return world.steps * world.time_step

    def _do(self, robot: str, ability: Callable[[RobotContext, G], Steps[T]], goal: G) -> T:
        context = self.cell.contexts[robot]
        goal.check(context.panel, context.belief, context.parameters)
        found = self.cell.run(ability(context, goal), robot)
        self._tell(type(goal).__name__.removesuffix("Goal"), found)
        return found

    def _tell(self, step: str, found: object) -> None:
        message = getattr(found, "message", found)
        wall, cell = time.monotonic() - self._began, self._cell_s()
        _tell(f"{wall:6.1f} s  {cell:6.1f} s  {step}: {message}")


def first_ends_of(panel: Panel) -> dict[str, WireEnd]:
    """Return the end of each wire in ducts that is inserted first, as the use case chooses it."""
    routes = {wire.id: wire.route for wire in panel.wires if wire.ducts}
    paths = {
        name: [(round(1e3 * x), round(1e3 * y)) for x, y, _ in route]
        for name, route in routes.items()
    }
    return {name: WireEnd[end.name] for name, end in first_ends(paths).items()}


def photograph(cell: Cell, folder: Path, wire_id: str) -> None:
    """Write pictures of a wire from aside and from above into a folder."""
    for camera in ("scene", "overhead"):
        picture = cv2.cvtColor(cell.plant.photograph(camera).rgb, cv2.COLOR_RGB2BGR)
        cv2.imwrite(str(folder / f"{wire_id}_{camera}.png"), picture)


def _tell(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main() -> int:
    """Place the wires; return 0 if all are placed."""
    parser = argparse.ArgumentParser(description="Wire a board's wires through its ducts.")
    parser.add_argument("wires", nargs="+", metavar="WIRE", help="such as W3")
    parser.add_argument("--first", choices=("a", "b"), help="end inserted first")
    parser.add_argument("--seed", type=int, default=1, help="of all noise")
    parser.add_argument("--cell", default="two_arms_cabinet", help="name or file")
    parser.add_argument("--panel", type=Path, default=HOUSEHOLD, help="file; default: household")
    parser.add_argument("--laid", type=int, default=0, help="wires in the ducts before the first")
    parser.add_argument("--pictures", type=Path, help="folder for pictures after each wire")
    options = parser.parse_args()
    if options.pictures is not None:
        options.pictures.mkdir(parents=True, exist_ok=True)
    panel = read_panel(options.panel, read_wire_materials())
    plant = SimulatedPlant(panel, design=read_cell(options.cell), seed=options.seed)
    before = laid_wires(panel, options.laid, plant.world.time_step, without=options.wires[0])
    plant.load(panel, before)
    cell = Cell(plant)
    laying = Laying(cell)
    first = first_ends_of(panel)
    placed = 0
    for wire_id in options.wires:
        try:
            laying.place(wire_id, WireEnd(options.first) if options.first else first[wire_id])
        except AbilityError as error:
            _tell(f"{wire_id}: {error.code.name}: {error}")
        (truth,) = ground_truth(cell.plant, [wire_id])
        placed += truth.placed
        depths = ", ".join(f"{end.depth * 1e3:.1f} mm" for end in (truth.a, truth.b))
        in_ducts = share_in_ducts(cell.plant, wire_id)
        _tell(laying.speed())
        _tell(
            f"{wire_id}: {'placed' if truth.placed else 'not placed'}, ends {depths} deep, "
            f"{in_ducts:.0%} of its route in ducts below the rims"
        )
        if options.pictures is not None:
            photograph(cell, options.pictures, wire_id)
        if not truth.placed:
            break
    cell.close()
    return 0 if placed == len(options.wires) else 1


if __name__ == "__main__":
    sys.exit(main())
