"""Wires of 2.5 mm2 as long as designs have them, cut into links as the cell does.

Sag against the elastica, the force that drags a wire along the plate against Coulomb's, and the
real-time factor of a wire alone on the plate.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
import rods
from elastica import cantilever_drop
from peer_wire import REPEATS, SAG_LOAD, PeerWire
from row import Row

from remodel_sim.core.wires.wire_mechanics import GRAVITY, discretise
from remodel_sim.physics.fixtures.panel_scene import PLATE_FRICTION, add_plate_surface
from remodel_sim.physics.wires.cable import SimulatedWire
from remodel_sim.physics.world import World
from remodel_work.panel import WireEnd

LENGTHS_M = (1.0, 2.0, 3.0)
RATE_HZ = 240.0
# The wire is drawn by a spring, so slowly that its drag of 60 N s/m for each kg is 1.5 % of its
# friction.
SPRING_N_M = 200.0
DRAWN_M_S = 0.0005
DAMPING_N_S_M = 1.0
# How long after the spring is as long as friction makes it the wire slides for certain.
SLIDES_S = 1.0
REST_S = 0.5
MEASURED_S = 1.5


def rows() -> Iterator[Row]:
    """Measure."""
    for length in LENGTHS_M:
        exact = cantilever_drop(length, 1.0, SAG_LOAD / length**3)
        error = 100 * abs(rods.drop_at_rest(rods.CellRod(length, SAG_LOAD)) / exact - 1)
        yield Row(sag_row(length), error, "%", most=0.3)
    for length in LENGTHS_M:
        force, coulomb = drag(length)
        error = 100 * abs(force / coulomb - 1)
        what = f"drag along the plate against mu m g, 2.5 mm2, {length:g} m"
        yield Row(what, error, "%", most=5.0)
    for length in LENGTHS_M:
        best = max(real_time_factor(length) for _ in range(REPEATS))
        yield Row(speed_row(length), best, "x")


def peer_rows(peer: str, figures: dict | None) -> Iterator[Row]:
    """Yield another simulator's figures of the same wires, if there are any."""
    if figures is None:
        return
    for length, error in zip(LENGTHS_M, figures["long_sag"], strict=True):
        yield Row(f"{peer}: {sag_row(length)}, clamp half a cell out", error, "%")
    for length, factor in zip(LENGTHS_M, figures["long_speed"], strict=True):
        yield Row(f"{peer}: {speed_row(length)}", factor, "x")


def sag_row(length: float) -> str:
    """Return what the row of a wire's sag is called; length in m."""
    return f"sag error, w L^3 / EI = {SAG_LOAD:g}, 2.5 mm2, {length:g} m"


def speed_row(length: float) -> str:
    """Return what the row of a wire's speed is called; length in m."""
    return f"real-time factor, only a wire of {length:g} m on the plate, {RATE_HZ:g} Hz"


def peer_wires() -> list[PeerWire]:
    """Return the wires as other simulators are to model them: as many cells, without ferrules."""
    wires = []
    for length in LENGTHS_M:
        wire = rods.cell_wire(length)
        model = discretise(wire, 1.0 / RATE_HZ)
        peer = PeerWire(
            length=length,
            cells=len(model.lengths) - 2 - int(np.count_nonzero(model.spans == 0.0)),
            radius=wire.radius,
            linear_density=wire.linear_density,
            bending_stiffness=wire.bending_stiffness,
            torsional_stiffness=wire.torsional_stiffness,
            friction=PLATE_FRICTION * wire.friction,
        )
        wires.append(peer)
    return wires


def drag(length: float) -> tuple[float, float]:
    """Draw a straight wire along the plate by its ferrule a; returns the force and mu m g [N]."""
    world, cable = on_plate(length, curvature=0.0)
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


def real_time_factor(length: float) -> float:
    """Return simulated time over the CPU time of the one thread that computes it."""
    world, _ = on_plate(length, curvature=rods.cell_wire(length).rest_curvature)
    for _ in range(round(REST_S * RATE_HZ)):
        world.step()
    began = time.process_time()
    for _ in range(round(MEASURED_S * RATE_HZ)):
        world.step()
    cpu = time.process_time() - began
    world.close()
    return MEASURED_S / cpu


def on_plate(length: float, *, curvature: float) -> tuple[World, SimulatedWire]:
    """Return a world with a wire at rest on the plate, of this curvature [1/m]; length in m."""
    world = World(RATE_HZ)
    add_plate_surface(world)
    specimen = rods.cell_wire(length)
    model = discretise(specimen, world.time_step)
    cable = SimulatedWire(world, model, "BU")
    tip_a = np.array([0.3, -0.2, specimen.radius])
    cable.lay(tip_a, 0.0, np.full(len(model.spans), curvature))
    return world, cable
