#!/usr/bin/env python3
"""How much faster than real time a board with laid wires is, of which one is being inserted.

`laid_board.py`, in the sourced workspace, prints its rows within a minute. Nothing is placed: the
wires of the household panel run along their routes in the ducts, seven beside each other, layer
over layer. The live one lies on top of them: end a is in its clamp, a hand grips end b before its
opening, and what the wire has in excess arches in its last duct.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from row import Row

from remodel_sim.core.wire_mechanics import as_nodes, discretise
from remodel_sim.physics.plant import SimulatedPlant
from remodel_states.edge.exported_tables import read_wire_materials
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Array
from remodel_work.panel import BOARD, Panel, PanelWire, WireEnd
from remodel_work.robot.arm import ToolPose
from remodel_work.ros.panel_message import read_panel
from remodel_work.routes import ParkedWire

CONFIG = Path(__file__).parents[2] / "src" / "remodel_sim" / "config"
CELL, HOLDER = "two_arms_cabinet", "robot_2"
LIVE = "W3"
# Wires lie so far from each other, so many in a layer, above so much of the plate [m].
PITCH_M, LANES = 0.0042, 7
FLOOR_M = 0.0005
# The hand grips so far behind the tip, which is so far before its opening [m].
GRASP_M, BEFORE_M = 0.025, 0.005
# So deep is the opening of the live one, about [m].
TERMINAL_M = 0.014
# The last so much of it is straight, and what it has in excess arches over so much before [m].
STRAIGHT_M, ARCH_M = 0.070, 0.160
# Points along a line are so far apart [m].
FINE_M = 0.001
# Its end is drawn back to where it was laid, is gripped, and comes to rest [s], [N].
DRAWN_BACK_S, CLOSING_S, RESTS_S = 0.5, 1.0, 2.0
HOLDING_N = 20.0
LAID = (0, 30)
# The held end is pushed so far in so much time, then waits so long [m, s]; the best of so many.
PUSHED_M, PUSHED_S, WAITED_S, REPEATS = 0.012, 1.0, 1.0, 2


class LaidBoard:
    """A cell with so many laid wires, and a live one held before its second opening.

    Attributes:
        plant: the cell.
        into: (3,) unit vector into the opening.
    """

    def __init__(self, wires: int, *, rate_hz: float = 240.0) -> None:
        panel = read_panel(CONFIG / "household.yaml", read_wire_materials())
        design = read_cell(CELL)
        self.plant = SimulatedPlant(panel, design=design, seed=1, rate_hz=rate_hz)
        live = panel.wire(LIVE)
        step = self.plant.world.time_step
        parked = laid_wires(panel, wires, step, without=LIVE)
        line = _line(panel, live, LANES * math.ceil(wires / LANES) + LANES // 2)
        nodes = as_nodes(_with_excess(line, live), discretise(live, step))
        parked[LIVE] = ParkedWire(nodes, frozenset({WireEnd.A}))
        self.plant.load(panel, parked)
        out = nodes[-1] - nodes[-2]
        self.into = out / np.linalg.norm(out)
        held = nodes[-1] - GRASP_M * self.into
        self._tool = ToolPose(*held.tolist(), math.atan2(self.into[1], self.into[0]))
        homes = {robot.name: robot.home for robot in design.robots}
        self.plant.take_up(LIVE, {**homes, HOLDER: self._tool})
        holder = self._hold(nodes[-1] - live.ferrule_length / 2 * self.into)
        self._run(DRAWN_BACK_S)
        self.plant.robots[HOLDER].drive_fingers(0.0)
        self._run(CLOSING_S)
        self.plant.world.bullet.removeConstraint(holder)
        self._run(RESTS_S)

    def _hold(self, at: Array) -> int:
        """Draw the middle of the ferrule at end b to a place (3,) [m], and hold it there."""
        bullet, link = self.plant.world.bullet, self.plant.live.cable.ferrule(WireEnd.B)
        yaw = math.atan2(self.into[1], self.into[0])
        constraint = bullet.createConstraint(
            *link,
            childBodyUniqueId=-1,
            childLinkIndex=-1,
            jointType=bullet.JOINT_FIXED,
            jointAxis=[0, 0, 0],
            parentFramePosition=[0, 0, 0],
            childFramePosition=at.tolist(),
            parentFrameOrientation=[0, 0, 0, 1],
            childFrameOrientation=bullet.getQuaternionFromEuler([0.0, math.pi / 2, yaw]),
        )
        bullet.changeConstraint(constraint, maxForce=HOLDING_N)
        return int(constraint)

    def _run(self, seconds: float) -> None:
        for _ in range(round(seconds / self.plant.world.time_step)):
            self.plant.step()

    def push(self, distance: float, seconds: float) -> None:
        """Move the hand so far along the opening's axis in a time [m, s]."""
        self._tool = self._tool.moved(self.into, distance)
        robot, steps = self.plant.robots[HOLDER], round(seconds / self.plant.world.time_step)
        robot.drive(robot.arm.joints_for(self._tool), steps)
        self._run(seconds)


def laid_wires(
    panel: Panel, wires: int, time_step: float, *, without: str
) -> dict[str, ParkedWire]:
    """Return so many wires along their routes in the ducts, both ends in their clamps."""
    chosen = [wire for wire in panel.wires if wire.ducts and wire.id != without][:wires]
    return {
        wire.id: ParkedWire(
            as_nodes(_line(panel, wire, i), discretise(wire, time_step)), frozenset(WireEnd)
        )
        for i, wire in enumerate(chosen)
    }


def _line(panel: Panel, wire: PanelWire, index: int) -> Array:
    """Return points along a wire's route (n, 3) [m], world frame, in its lane of its layer."""
    layer, lane = divmod(index, LANES)
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
    return _fine([*ends[0], *inner, *reversed(ends[1])])


def _fine(corners: list[Array]) -> Array:
    """Return points FINE_M apart along straight lines from corner to corner."""
    legs = [
        np.linspace(a, b, max(1, round(float(np.linalg.norm(b - a)) / FINE_M)), endpoint=False)
        for a, b in pairwise(corners)
    ]
    return np.vstack([*legs, corners[-1][None]])


def _length_of(line: Array) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def _with_excess(line: Array, wire: PanelWire) -> Array:
    """Return the line with its tip before its opening, and an arch in its last duct."""
    line = line[: -round((TERMINAL_M + BEFORE_M) / FINE_M)]
    straight = round(STRAIGHT_M / FINE_M)
    arched = slice(-straight - round(ARCH_M / FINE_M), -straight)
    shape = np.sin(np.linspace(0.0, np.pi, arched.stop - arched.start)) ** 2
    low, high = 0.0, wire.length
    for _ in range(40):
        height = (low + high) / 2
        longer = line.copy()
        longer[arched, 2] += height * shape
        low, high = (low, height) if _length_of(longer) > wire.length else (height, high)
    return longer


def rows() -> Iterator[Row]:
    """Measure, the best of a few runs: other load on the machine only slows them."""
    for wires in LAID:
        best = max(real_time_factor(wires) for _ in range(REPEATS))
        yield Row(f"real-time factor, an end is inserted over {wires} laid wires", best, "x")


def real_time_factor(wires: int) -> float:
    """Return simulated time over the CPU time of the one thread that computes it."""
    board = LaidBoard(wires)
    began = time.process_time()
    board.push(PUSHED_M, PUSHED_S)
    board.push(0.0, WAITED_S)
    cpu = time.process_time() - began
    board.plant.close()
    return (PUSHED_S + WAITED_S) / cpu


if __name__ == "__main__":
    for row in rows():
        sys.stdout.write(f"{row.what}: {row.value:.2f} {row.unit}\n")
