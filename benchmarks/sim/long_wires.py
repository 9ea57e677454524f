"""Long wires, cut as the cell cuts them: statics against theory, and speed among finished wires."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator

import numpy as np
import rods
from elastica import buckled_tip_angle, cantilever_drop
from panels import wire
from posts import capstan
from row import Row

from remodel_sim.core.geometry import Array
from remodel_sim.core.workpiece.hanging_loop import HeldEnd
from remodel_sim.core.workpiece.panel import PanelWire, WireEnd
from remodel_sim.core.workpiece.wire_mechanics import discretise
from remodel_sim.edge.cell_file import read_cell
from remodel_sim.physics.fixtures.panel_scene import add_plate_surface
from remodel_sim.physics.live_wire import hanging_cable
from remodel_sim.physics.robot import Robot
from remodel_sim.physics.wires.cable import SimulatedWire
from remodel_sim.physics.wires.parked_wire import add_solid
from remodel_sim.physics.world import World

LENGTHS_M = (1.0, 2.0, 3.0)
LOADS = (1.0, 5.0, 21.0)
RATIOS = (1.03, 1.2, 2.0)
GAP_M = 0.08
HANGING_S = 2.0
HELD_N = 100.0
RATE_HZ = 240.0
LEAST_FACTOR = 1.5
FINISHED = 57
FINISHED_LINKS = 45
WAVE_1_M = 8.0
# The wire lies across the finished ones, and its end is pulled aside and up [m/s].
PULL_M_S = np.array([-0.05, -0.10, 0.0])
REST_S = 1.0
CHUNK_STEPS = 40
CHUNKS = 8


def rows() -> Iterator[Row]:
    """Measure."""
    for length in LENGTHS_M:
        errors = []
        for load in LOADS:
            exact = cantilever_drop(length, 1.0, load / length**3)
            errors.append(100 * abs(rods.sag(load, length=length) / exact - 1))
        yield Row(
            f"sag error, w L^3 / EI = 1, 5, 21, worst, {length:g} m", max(errors), "%", most=0.3
        )
        errors = [
            abs(math.degrees(rods.buckle(ratio, length=length) - buckled_tip_angle(ratio)))
            for ratio in RATIOS
        ]
        what = f"tip angle error, P / Pcr = 1.03, 1.2, 2, worst, {length:g} m"
        yield Row(what, max(errors), "deg", most=0.5)
        what = f"moved within {HANGING_S:g} s after it was laid into its loop, {length:g} m"
        yield Row(what, 1e3 * loop_movement(length), "mm", most=0.5)
        measured, exact = capstan(length)
        what = f"capstan: force ratio by a quarter turn against exp(mu pi / 2), {length:g} m"
        yield Row(what, 100 * abs(measured / exact - 1), "%", most=15.0)
    for length in LENGTHS_M:
        for name, factor in real_time_factors(length).items():
            what = f"real-time factor, {length:g} m {name}, arm, {FINISHED} finished wires"
            yield Row(what, factor, "x", least=LEAST_FACTOR)


def loop_movement(length: float) -> float:
    """Return how far a wire moves that hangs in its loop between two held ends [m]."""
    world = World(RATE_HZ)
    cable = hanging_cable(world, _wire(length), *_ends())
    for end in WireEnd:
        _hold(world, cable, end)
    before = cable.nodes()
    for _ in range(round(HANGING_S * RATE_HZ)):
        world.step()
    moved = float(np.abs(cable.nodes() - before).max())
    world.close()
    return moved


def _ends() -> tuple[HeldEnd, HeldEnd]:
    out = np.array([1.0, 0.0, 0.0])
    a, b = (HeldEnd(np.array([0.2, side * GAP_M / 2, 0.0]), out, 0.0) for side in (-1, 1))
    return a, b


def _hold(world: World, cable: SimulatedWire, end: WireEnd) -> tuple[int, Array, Array]:
    """Hold an end where it is; return the constraint, and the end's pose."""
    bullet, (body, link) = world.bullet, cable.ferrule(end)
    position, quaternion = cable.link_pose((body, link))
    hold = bullet.createConstraint(
        body, link, -1, -1, bullet.JOINT_FIXED, [0, 0, 0], [0, 0, 0], position.tolist(),
        [0, 0, 0, 1], quaternion.tolist(),
    )  # fmt: skip
    bullet.changeConstraint(hold, maxForce=HELD_N)
    return hold, position, quaternion


def _wire(length: float) -> PanelWire:
    return wire("W", ("X", "1"), ("Y", "1"), length)


def real_time_factors(length: float) -> dict[str, float]:
    """Return simulated time over CPU time, at rest on finished wires and pulled across them."""
    world = World(RATE_HZ)
    add_plate_surface(world)
    Robot(world, read_cell().robots[0].home)
    specimen = _wire(length)
    for number in range(FINISHED):
        add_solid(world, _finished(number), specimen)
    model = discretise(specimen, world.time_step)
    cable = SimulatedWire(world, model, "BU")
    wave = WAVE_1_M * np.sin(13.0 * np.cumsum(model.spans))
    cable.lay(np.array([0.9, -0.4, 4 * specimen.radius]), math.pi / 2, wave)
    for _ in range(round(REST_S * RATE_HZ)):
        world.step()
    resting = _best_factor(world, lambda: None)
    bullet = world.bullet
    hold, position, quaternion = _hold(world, cable, WireEnd.A)

    def pull() -> None:
        position[:] += PULL_M_S / RATE_HZ
        bullet.changeConstraint(hold, position.tolist(), quaternion.tolist(), maxForce=HELD_N)

    pulled = _best_factor(world, pull)
    world.close()
    return {"at rest": resting, "pulled": pulled}


def _finished(number: int) -> Array:
    """Return the nodes of one of the wires that lie beside each other, slightly curved."""
    along = np.linspace(-0.5, 0.5, FINISHED_LINKS + 1)
    x = 0.4 + 0.5 * number / FINISHED + 0.003 * np.sin(8.0 * along + number)
    return np.column_stack([x, along, np.full(len(along), 0.0015)])


def _best_factor(world: World, before_step: Callable[[], None]) -> float:
    """Return the factor of the fastest chunk of steps; other load on the machine slows them."""
    best = math.inf
    for _ in range(CHUNKS):
        began = time.process_time()
        for _ in range(CHUNK_STEPS):
            before_step()
            world.step()
        best = min(best, time.process_time() - began)
    return CHUNK_STEPS / RATE_HZ / best
