"""How much faster than real time the cell's physics is: the arm, and one wire on the plate."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
from panels import wire
from row import Row

from remodel_sim.core.wires.wire_mechanics import Piece, chain
from remodel_sim.physics.fixtures.panel_scene import add_plate_surface
from remodel_sim.physics.robot import Robot
from remodel_sim.physics.wires.cable import SimulatedWire
from remodel_sim.physics.world import World
from remodel_work.edge.cell_file import read_cell

CELLS = 24
LENGTH_M = 0.384
WAVE_1_M = 4.0  # amplitude of the curvature of the wave in which the wire lies
TARGETS = {240.0: 5.0, 500.0: 2.5}
REST_S = 0.5
MEASURED_S = 1.5
REPEATS = 5


def rows() -> Iterator[Row]:
    """Measure, the best of a few runs: other load on the machine only slows them."""
    for rate_hz, least in TARGETS.items():
        best = max(real_time_factor(rate_hz) for _ in range(REPEATS))
        what = f"real-time factor, arm and a {CELLS}-link wire on the plate, {rate_hz:g} Hz"
        yield Row(what, best, "x", least=least)


def real_time_factor(rate_hz: float) -> float:
    """Return simulated time over the CPU time of the one thread that computes it."""
    world = World(rate_hz)
    add_plate_surface(world)
    Robot(world, read_cell().robots[0].home)
    specimen = wire("W", ("X", "1"), ("Y", "1"), LENGTH_M, diameter=0.004)
    cell = LENGTH_M / CELLS
    model = chain(specimen, [Piece(cell, cell)] * CELLS, world.time_step)
    cable = SimulatedWire(world, model, "BU")
    wave = WAVE_1_M * np.sin(np.linspace(0.0, 5.0, len(model.spans)))
    cable.lay(np.array([0.3, -0.2, specimen.radius]), np.pi / 2, wave)
    for _ in range(round(REST_S * rate_hz)):
        world.step()
    steps = round(MEASURED_S * rate_hz)
    began = time.process_time()
    for _ in range(steps):
        world.step()
    cpu = time.process_time() - began
    world.close()
    return steps / rate_hz / cpu
