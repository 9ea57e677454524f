#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Record what the wrist feels while an end is pushed: record_pushes.py [FILE].

Three insertions of one wire in the simulated cell: into its opening, into one that a plug blocks,
and beside it. FILE gets, of each, how deep the tip would be if the wire were rigid, and the force
along the opening; by default it is the recording that the scripted device of the tests plays.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Generator
from pathlib import Path

import numpy as np
from insertion_map import PANEL
from wire_task import ROBOT

from remodel_sim.physics.plant import SimulatedPlant
from remodel_skills.abilities.inserting import InsertGoal, insert_cable
from remodel_skills.cell import Cell
from remodel_skills.robot_context import RobotContext
from remodel_states.edge.exported_tables import read_wire_materials
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd
from remodel_work.ros.panel_message import read_panel

FILE = Path(__file__).parents[2] / "src/remodel_skills/test/unit/recorded_pushes.json"
BESIDE_M = 0.005
FORCE_LIMIT_N = 8.0
# From here before the opening on [m]; points are kept so far apart [m], or so many newtons.
FROM_M, APART_M, APART_N = -0.002, 1e-4, 0.2


def record(name: str, aside_m: float = 0.0, *, blocked: bool = False) -> dict[str, object]:
    """Push end a of the panel's first wire; return what was felt."""
    panel = read_panel(PANEL, read_wire_materials())
    wire = panel.wires[0]
    terminal = wire.goes_to(WireEnd.A)
    cell = Cell(SimulatedPlant(panel, seed=1))
    if blocked:
        cell.plant.block_socket(*terminal)
    opening = panel.panel_from_socket(*terminal).position
    cell.feed(wire.id, panel.channel_in_front_of(opening).id)
    given = cell.plant.world_from_socket(*terminal) @ Pose.level(0.0, aside_m, 0.0)
    goal = InsertGoal(ROBOT, wire.id, WireEnd.A, *terminal, given, FORCE_LIMIT_N)
    felt: list[tuple[float, float]] = []
    ended = "SEATED"
    try:
        cell.run(_felt(insert_cable(cell.context, goal), cell.context, given, felt))
    except AbilityError as error:
        ended = error.code.name
    cell.close()
    print(f"{name}: {ended}, {len(felt)} points, {max(force for _, force in felt):.1f} N")
    depths, forces = zip(*felt, strict=True)
    return {"name": name, "ended": ended, "depths_m": depths, "forces_n": forces}


def _felt(
    steps: Generator[None, None, object],
    context: RobotContext,
    socket: Pose,
    felt: list[tuple[float, float]],
) -> Generator[None, None, object]:
    """Note depth and force while the tip goes on into the opening."""
    along = socket.rotation[:, 0]
    deepest = FROM_M
    try:
        while True:
            next(steps)
            grip = context.belief.grip
            if grip is not None and context.belief.engaged is not None:
                arm = context.device.arm
                depth = float((arm.tool.position - socket.position) @ along) + grip.distance
                force = float((np.array(arm.force) - context.empty_force) @ along)
                most = felt[-1][1] if felt else 0.0
                if depth > deepest and (depth > deepest + APART_M or force > most + APART_N):
                    deepest = depth
                    felt.append((round(depth, 6), round(force, 2)))
            yield
    except StopIteration as end:
        return end.value


def main() -> None:
    """Record all and write them."""
    file = Path(sys.argv[1]) if len(sys.argv) > 1 else FILE
    pushes = [
        record("into its opening"),
        record("into a blocked opening", blocked=True),
        record("beside its opening", aside_m=BESIDE_M),
    ]
    file.write_text(json.dumps(pushes) + "\n")
    print(f"written: {file}")


if __name__ == "__main__":
    main()
