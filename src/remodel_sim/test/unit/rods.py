"""Experiments on a wire that is clamped at one end, for tests and benchmarks."""

import dataclasses
import math

import numpy as np
from elastica import buckling_load
from panels import wire

from remodel_sim.core.wire_mechanics import Piece, chain, discretise
from remodel_sim.physics.wires.cable import SimulatedWire
from remodel_sim.physics.world import GRAVITY, World
from remodel_states.edge.exported_tables import read_wire_materials
from remodel_work.panel import WireEnd

LENGTH = 0.30
STIFFNESS = 1e-3
CLAMPED = 0.02
HEIGHT = 1.0
ELASTIC = 1e6  # a yield curvature that is never reached [1/m]
# A rod is at rest when no node has moved by more than this in a quarter of a second [m].
STILL = 2e-7
# The heavy rods move slowly, the longer the more so: 3 m take some 90 s.
WAIT_LIMIT_S = 180.0


class Rod:
    """A rod along x without ferrules, its first link held by the world."""

    def __init__(self, *, cells=24, load=0.0, rate_hz=240.0, cut=None, **properties):
        """Make a rod of `cells` equal links beyond the clamp; `load` is w L^3 / EI.

        It is cut in the middle of the cell number `cut` and bolted together again.
        """
        values = {"yield_curvature": ELASTIC, "bending_stiffness": STIFFNESS, **properties}
        # Without weight, the lighter the rod the sooner it is at rest.
        density = load * values["bending_stiffness"] / (GRAVITY * LENGTH**3) if load else 0.001
        specimen = wire("rod", ("X", "1"), ("Y", "1"), LENGTH, linear_density=density, **values)
        world = World(rate_hz)
        if not load:
            world.bullet.setGravity(0, 0, 0)
        cell = LENGTH / cells
        pieces = [Piece(cell, cell)] * (cells - 1) + [Piece(cell - specimen.radius, cell)]
        if cut is not None:
            pieces[cut : cut + 1] = [Piece(cell / 2, cell), Piece(cell / 2, cell, bolted=True)]
        self._clamp(world, chain(specimen, [Piece(CLAMPED, 0.0), *pieces], world.time_step))

    def _clamp(self, world, model):
        """Lay the model straight, its first link's end at x = 0, and hold that link."""
        self.world, self.cable = world, SimulatedWire(world, model, "BU")
        start = np.array([-model.lengths[0] - model.radius, 0.0, HEIGHT])
        self.cable.lay(start, 0.0, np.zeros(len(model.spans)))
        bullet, link = self.world.bullet, self.cable.ferrule(WireEnd.A)
        position, quaternion = self.cable.link_pose(link)
        hold = bullet.createConstraint(
            *link, -1, -1, bullet.JOINT_FIXED, [0, 0, 0], [0, 0, 0], position.tolist(),
            [0, 0, 0, 1], quaternion.tolist(),
        )  # fmt: skip
        bullet.changeConstraint(hold, maxForce=1e4)

    def come_to_rest(self, force=None):
        """Step until the rod is at rest, under a force at its tip (3,) [N] if one is given."""
        check = round(0.25 / self.world.time_step)
        before = self.cable.nodes()
        for _ in range(math.ceil(WAIT_LIMIT_S / 0.25)):
            for _ in range(check):
                if force is not None:
                    self.push(force)
                self.world.step()
            now = self.cable.nodes()
            if np.abs(now - before).max() < STILL:
                return
            before = now
        raise AssertionError(f"the rod is not at rest after {WAIT_LIMIT_S} s")

    def push(self, force):
        """Apply a force (3,) [N] of constant direction at the tip for the next step."""
        bullet, link = self.world.bullet, self.cable.ferrule(WireEnd.B)
        apex = self.cable.tip(WireEnd.B)[0]
        bullet.applyExternalForce(*link, list(force), apex.tolist(), bullet.WORLD_FRAME)

    @property
    def drop(self):
        """How far the tip is below the clamp [m]."""
        return HEIGHT - float(self.cable.nodes()[-1, 2])

    @property
    def tip_angle(self):
        """The angle between the tip's direction and the clamp's [rad]."""
        out = self.cable.tip(WireEnd.B)[1]
        return math.atan2(math.hypot(out[1], out[2]), out[0])

    def close(self):
        self.world.close()


class CellRod(Rod):
    """A rod along x that is a wire of 2.5 mm2 as the cell makes it, its ferrule a held."""

    def __init__(self, length, load):
        """Make a wire that is `length` beyond its ferrule a [m]; `load` is w L^3 / EI."""
        specimen = cell_wire(length, yield_curvature=ELASTIC)
        density = load * specimen.bending_stiffness / (GRAVITY * length**3)
        specimen = dataclasses.replace(
            specimen, length=length + specimen.ferrule_length, linear_density=density
        )
        world = World(240.0)
        self._clamp(world, discretise(specimen, world.time_step))


def cell_wire(length, **changes):
    """Return a wire of 2.5 mm2 of the table of materials; length from tip to tip [m]."""
    material = dataclasses.asdict(read_wire_materials().find("H07V-K", 2.5))
    return wire("W", ("X", "1"), ("Y", "1"), length, section=2.5, **{**material, **changes})


def sag(load, **options):
    """Return how far the tip of a rod hangs down whose w L^3 / EI is `load` [m]."""
    return drop_at_rest(Rod(load=load, **options))


def drop_at_rest(rod):
    """Return how far the tip of a rod hangs down [m]; ends its world."""
    rod.come_to_rest()
    drop = rod.drop
    rod.close()
    return drop


def buckle(ratio, **options):
    """Return the tip's angle under `ratio` times Euler's load [rad], after a light kick."""
    rod = Rod(**options)
    load = ratio * buckling_load(LENGTH, STIFFNESS)
    for _ in range(round(0.5 / rod.world.time_step)):
        rod.push((-load, 0.0, 1e-3 * load))
        rod.world.step()
    rod.come_to_rest((-load, 0.0, 0.0))
    angle = rod.tip_angle
    rod.close()
    return angle
