#!/usr/bin/env python3
"""Measure the simulated wire against theory, and beside other simulators.

wire.py [--peers PYTHON] [--figures FILE]; the workspace must be sourced. Sag and buckling against
the elastica; what holds a wire, pulled until it slips, against Coulomb and against what was
ordered; the real-time factor; wires of 1 to 3 m, cut into links as the cell does. PYTHON has MuJoCo
and Newton. Exits with 1 when a target is missed.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict
from itertools import chain as joined
from pathlib import Path

import numpy as np

# The rigs are those of the unit tests.
sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_sim/test/unit"))
sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_work/test"))
import rods
from elastica import buckled_tip_angle, cantilever_drop
from figures import Figure, add_figures_option, report
from fingerprint import fingerprint_elsewhere
from holds import clamp_pull_out, clip_forces, grip_pull_out
from panels import wire
from wire_peers import REPEATS, SAG_LOAD, SHORT_REPEATS, Wire

from remodel_sim.core.wire_mechanics import GRAVITY, Piece, chain, discretise
from remodel_sim.physics.fixtures.panel_scene import PLATE_FRICTION, add_plate_surface
from remodel_sim.physics.robot import Robot
from remodel_sim.physics.wires.cable import SimulatedWire
from remodel_sim.physics.world import World
from remodel_work.edge.cell_file import read_cell
from remodel_work.panel import WireEnd

# Statics.
LOADS = (1.0, 5.0, 21.0)
RATIOS = (0.97, 1.03, 1.06, 1.1, 1.2, 1.5, 2.0)
CELLS = 24

# What holds a wire; of clips retention [N] and diameter of the wire [m].
RATES_HZ = (240.0, 500.0)
GRIPS_N = (10.0, 20.0, 30.0)
FRICTIONS = (0.3, 0.5)
RETENTIONS_N = (10.0, 40.0, 80.0)
CLIPS = ((5.0, 0.003), (10.0, 0.003), (10.0, 0.006), (20.0, 0.006))

# Speed: an arm beside a short wire, which lies in a wave of this amplitude of its curvature.
SHORT_M = 0.384
WAVE_1_M = 4.0
SPEED_TARGETS = {240.0: 5.0, 500.0: 2.5}
REST_S = 0.5
MEASURED_S = 1.5

# Long wires. They are drawn by a spring, so slowly that their drag of 60 N s/m for each kg is 1.5 %
# of their friction; so long after the spring is stretched by friction they slide for certain.
LENGTHS_M = (1.0, 2.0, 3.0)
RATE_HZ = 240.0
SPRING_N_M = 200.0
DRAWN_M_S = 0.0005
DAMPING_N_S_M = 1.0
SLIDES_S = 1.0


def statics_rows() -> Iterator[Figure]:
    """Yield the errors of sag, and of the shape after buckling, against the elastica."""
    cuts = [(load, None, "") for load in LOADS] + [(5.0, CELLS // 2, ", two bodies")]
    for load, cut, words in cuts:
        exact = cantilever_drop(rods.LENGTH, 1.0, load / rods.LENGTH**3)
        found = rods.sag(load, cells=CELLS, **({"cut": cut} if cut else {}))
        what = f"sag error, w L^3 / EI = {load:g}, N = {CELLS}{words}"
        yield Figure(what, _error(found, exact), "%", most=0.3)
    for ratio in RATIOS:
        angle = math.degrees(rods.buckle(ratio, cells=CELLS))
        exact = math.degrees(buckled_tip_angle(ratio))
        yield Figure(f"tip angle error, P / Pcr = {ratio:g}", abs(angle - exact), "deg", most=0.5)


def retention_rows() -> Iterator[Figure]:
    """Yield the errors of what holds a wire; of each kind the worst."""
    for hz in RATES_HZ:
        grips = [grip_pull_out(grip, friction, hz) for grip in GRIPS_N for friction in FRICTIONS]
        clamps = [(clamp_pull_out(f, hz), f) for f in RETENTIONS_N]
        clips = [(clip_forces(f, diameter, hz)[1], f) for f, diameter in CLIPS]
        for what, pairs, most in (
            (f"grip pull-out against 2 mu F, 10 to 30 N, worst of {len(grips)}", grips, 15.0),
            ("clamp pull-out against its retention, 10 to 80 N, worst", clamps, 10.0),
            ("clip pull-out against its retention, 5 to 20 N, worst", clips, 10.0),
        ):
            worst = max(_error(held, expected) for held, expected in pairs)
            yield Figure(f"{what}, {hz:g} Hz", worst, "%", most=most)


def _error(found: float, exact: float) -> float:
    """Return a relative error [%]."""
    return 100 * abs(found / exact - 1)


def determinism_rows() -> Iterator[Figure]:
    """Yield whether two processes leave the same bits."""
    same = fingerprint_elsewhere() == fingerprint_elsewhere()
    yield Figure("same seed and goals in two processes: equal bits", float(same), "", least=1.0)


def speed_rows(mujoco: dict | None) -> Iterator[Figure]:
    """Yield real-time factors, the best of a few runs, and their ratios to MuJoCo's."""
    own = []
    for hz, least in SPEED_TARGETS.items():
        own.append(max(_speed(_beside_an_arm(hz)) for _ in range(SHORT_REPEATS)))
        what = f"real-time factor, arm and a {CELLS}-link wire on the plate, {hz:g} Hz"
        yield Figure(what, own[-1], "x", least=least)
    if mujoco is None:
        return
    beam = "sag error, w L^3 / EI = 5, N = 24"
    yield Figure(f"MuJoCo's cable: {beam}", mujoco["sag_raw"], "%")
    yield Figure(f"MuJoCo's cable: {beam}, clamp half a cell out", mujoco["sag_shifted"], "%")
    for value, (rate, factor) in zip(own, mujoco["speed"].items(), strict=True):
        hertz = f"{float(rate):g} Hz"
        yield Figure(f"MuJoCo's cable: real-time factor, the same scene, {hertz}", factor, "x")
        yield Figure(f"real-time factor over MuJoCo's, {hertz}", value / factor, "", least=1.0)


def _beside_an_arm(rate_hz: float) -> World:
    """Return a world with an arm and a short wire on the plate."""
    world = World(rate_hz)
    add_plate_surface(world)
    Robot(world, read_cell().robots[0].home)
    specimen = wire("W", ("X", "1"), ("Y", "1"), SHORT_M, diameter=0.004)
    cell = SHORT_M / CELLS
    model = chain(specimen, [Piece(cell, cell)] * CELLS, world.time_step)
    cable = SimulatedWire(world, model, "BU")
    wave = WAVE_1_M * np.sin(np.linspace(0.0, 5.0, len(model.spans)))
    cable.lay(np.array([0.3, -0.2, specimen.radius]), np.pi / 2, wave)
    return world


def _speed(world: World) -> float:
    """Return simulated time over the CPU time of the one thread that computes it; end the world."""
    for _ in range(round(REST_S / world.time_step)):
        world.step()
    steps = round(MEASURED_S / world.time_step)
    began = time.process_time()
    for _ in range(steps):
        world.step()
    cpu = time.process_time() - began
    world.close()
    return steps * world.time_step / cpu


def long_rows() -> Iterator[Figure]:
    """Yield sag, drag along the plate, and the real-time factor of wires of 2.5 mm2."""
    for length in LENGTHS_M:
        exact = cantilever_drop(length, 1.0, SAG_LOAD / length**3)
        found = rods.drop_at_rest(rods.CellRod(length, SAG_LOAD))
        yield Figure(_sag_row(length), _error(found, exact), "%", most=0.3)
    for length in LENGTHS_M:
        what = f"drag along the plate against mu m g, 2.5 mm2, {length:g} m"
        yield Figure(what, _error(*drag(length)), "%", most=5.0)
    for length in LENGTHS_M:
        curvature = rods.cell_wire(length).rest_curvature
        worlds = (_on_plate(length, curvature=curvature)[0] for _ in range(REPEATS))
        yield Figure(_speed_row(length), max(map(_speed, worlds)), "x")


def peer_rows(peer: str, figures: dict | None) -> Iterator[Figure]:
    """Yield another simulator's figures of the same long wires, if there are any."""
    if figures is None:
        return
    for length, error in zip(LENGTHS_M, figures["long_sag"], strict=True):
        yield Figure(f"{peer}: {_sag_row(length)}, clamp half a cell out", error, "%")
    for length, factor in zip(LENGTHS_M, figures["long_speed"], strict=True):
        yield Figure(f"{peer}: {_speed_row(length)}", factor, "x")


def _sag_row(length: float) -> str:
    return f"sag error, w L^3 / EI = {SAG_LOAD:g}, 2.5 mm2, {length:g} m"


def _speed_row(length: float) -> str:
    return f"real-time factor, only a wire of {length:g} m on the plate, {RATE_HZ:g} Hz"


def peer_wires() -> list[Wire]:
    """Return the wires as other simulators are to model them: as many cells, without ferrules."""
    wires = []
    for length in LENGTHS_M:
        specimen = rods.cell_wire(length)
        model = discretise(specimen, 1.0 / RATE_HZ)
        peer = Wire(
            length=length,
            cells=len(model.lengths) - 2 - int(np.count_nonzero(model.spans == 0.0)),
            radius=specimen.radius,
            linear_density=specimen.linear_density,
            bending_stiffness=specimen.bending_stiffness,
            torsional_stiffness=specimen.torsional_stiffness,
            friction=PLATE_FRICTION * specimen.friction,
        )
        wires.append(peer)
    return wires


def drag(length: float) -> tuple[float, float]:
    """Draw a straight wire along the plate by its ferrule a; returns the force and mu m g [N]."""
    world, cable = _on_plate(length, curvature=0.0)
    bullet, link = world.bullet, cable.ferrule(WireEnd.A)
    coulomb = PLATE_FRICTION * cable.model.friction * cable.model.masses.sum() * GRAVITY
    start, _ = cable.link_pose(link)
    reach = coulomb / SPRING_N_M / DRAWN_M_S + SLIDES_S
    forces, before = [], float(start[0])
    for step in range(round(2 * reach * RATE_HZ)):
        place, _ = cable.link_pose(link)
        stretch = place[0] - start[0] + DRAWN_M_S * step / RATE_HZ
        speed = (place[0] - before) * RATE_HZ
        force = SPRING_N_M * stretch + DAMPING_N_S_M * (speed + DRAWN_M_S)
        before = float(place[0])
        forces.append(force)
        bullet.applyExternalForce(*link, [-force, 0, 0], place.tolist(), bullet.WORLD_FRAME)
        world.step()
    world.close()
    return float(np.mean(forces[round(reach * RATE_HZ) :])), float(coulomb)


def _on_plate(length: float, *, curvature: float) -> tuple[World, SimulatedWire]:
    """Return a world with a wire at rest on the plate, of this curvature [1/m]; length in m."""
    world = World(RATE_HZ)
    add_plate_surface(world)
    specimen = rods.cell_wire(length)
    model = discretise(specimen, world.time_step)
    cable = SimulatedWire(world, model, "BU")
    tip_a = np.array([0.3, -0.2, specimen.radius])
    cable.lay(tip_a, 0.0, np.full(len(model.spans), curvature))
    return world, cable


def figures_of(python: str | None, name: str) -> dict | None:
    """Return what another simulator finds; None without a Python that has it."""
    if python is None:
        return None
    wires = json.dumps([asdict(wire) for wire in peer_wires()])
    line = [python, str(Path(__file__).with_name("wire_peers.py")), name, wires]
    text = subprocess.check_output(line, text=True)
    return json.loads(text.splitlines()[-1])  # Newton's compiler prints too


def main() -> int:
    """Print the table; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--peers", metavar="PYTHON", help="a Python that has mujoco and newton")
    add_figures_option(parser)
    options = parser.parse_args()
    mujoco, newton = (figures_of(options.peers, name) for name in ("mujoco", "newton"))
    figures = joined(
        statics_rows(),
        retention_rows(),
        determinism_rows(),
        speed_rows(mujoco),
        long_rows(),
        peer_rows("MuJoCo's cable", mujoco),
        peer_rows("Newton's VBD cable", newton),
    )
    return 0 if report(figures, options.figures) else 1


if __name__ == "__main__":
    sys.exit(main())
