#!/usr/bin/env python3
"""The long wires in Newton's VBD cable, on the CPU: newton_peer.py JSON, a list of PeerWires.

Run by an interpreter that has newton (requirements-bench.txt); its last line is a JSON object. The
first segment is the clamp, so sag is compared with a beam that is clamped where its flexible half
ends. Iterations are those of Newton's own cable examples; the time steps are ours.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import json
import math
import sys
import time
from pathlib import Path

import newton
import numpy as np
import warp

sys.path.insert(0, str(Path(__file__).parents[2] / "src" / "remodel_sim" / "test" / "unit"))
from peer_wire import GRAVITY, REPEATS, PeerWire

RATE_HZ = 240.0
ITERATIONS = 5
STRETCH_N = 2e3  # Newton's default of 1e5 N/m for a joint of 20 mm
DAMPING_STEPS = 0.25  # of joints, in time steps, as ours
HEIGHT_M = 4.0  # above the plate
REST_S = 10.0
SETTLED_S = 0.5
MEASURED_S = 1.5


class Cable:
    """A cable, clamped in the air or loose on the table."""

    def __init__(self, wire: PeerWire, *, table: bool) -> None:
        volume = math.pi * wire.radius**2 * (wire.cell + 4 / 3 * wire.radius)
        builder = newton.ModelBuilder(gravity=(0.0, 0.0, -GRAVITY))
        builder.default_shape_cfg.mu = wire.friction
        builder.default_shape_cfg.density = wire.linear_density * wire.cell / volume
        if table:
            builder.add_ground_plane()
        rod = newton.Rod.create_straight(
            start=(0.0, 0.0, wire.radius if table else HEIGHT_M),
            direction=(1.0, 0.0, 0.0),
            length=wire.length,
            segment_count=wire.cells,
            radius=wire.radius,
            bend_rigidity=wire.bending_stiffness,
            twist_rigidity=wire.torsional_stiffness,
            stretch_rigidity=STRETCH_N,
            shear_rigidity=STRETCH_N,
        )
        damping_s = DAMPING_STEPS / RATE_HZ / wire.cell
        bodies, _ = builder.add_rod(
            rod=rod,
            bend_damping=damping_s * wire.bending_stiffness,
            twist_damping=damping_s * wire.torsional_stiffness,
        )
        if not table:
            clamp = bodies[0]
            builder.body_mass[clamp] = builder.body_inv_mass[clamp] = 0.0
            builder.body_inertia[clamp] = warp.mat33(0.0)
            builder.body_inv_inertia[clamp] = warp.mat33(0.0)
        builder.color()
        model = builder.finalize(device="cpu")
        self._pipeline = self._contacts = None
        if table:
            self._pipeline = newton.CollisionPipeline(model, contact_matching="sticky")
            self._contacts = self._pipeline.contacts()
        self._solver = newton.solvers.SolverVBD(
            model, iterations=ITERATIONS, rigid_contact_history=table
        )
        self._control = model.control()
        self._now, self._next = model.state(), model.state()
        self._half = wire.cell / 2

    def step(self, damping: float = 1.0) -> None:
        """Advance by one time step; velocities are multiplied by `damping` before it."""
        if damping != 1.0:
            self._now.body_qd.assign(damping * self._now.body_qd.numpy())
        self._now.clear_forces()
        if self._pipeline is not None:
            self._pipeline.collide(self._now, self._contacts)
        self._solver.step(self._now, self._next, self._control, self._contacts, 1.0 / RATE_HZ)
        self._now, self._next = self._next, self._now

    @property
    def tip(self) -> np.ndarray:
        """The free end (3,) [m], world frame."""
        pose = self._now.body_q.numpy()[-1]
        x, y, z, w = pose[3:]
        axis = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
        return pose[:3] + self._half * axis


def sag_error(wire: PeerWire) -> float:
    """Return the error of the tip's drop [%], for a clamp half a cell further out."""
    loaded = wire.loaded()
    cable = Cable(loaded, table=False)
    for _ in range(round(REST_S * RATE_HZ)):
        cable.step(damping=0.96)  # only the shape at rest counts
    return loaded.sag_errors(HEIGHT_M - float(cable.tip[2]))[1]


def real_time_factor(wire: PeerWire) -> float:
    """Return simulated time over the CPU time of the process."""
    cable = Cable(wire, table=True)
    for _ in range(round(SETTLED_S * RATE_HZ)):
        cable.step()
    steps = round(MEASURED_S * RATE_HZ)
    began = time.process_time()
    for _ in range(steps):
        cable.step()
    return steps / RATE_HZ / (time.process_time() - began)


def main() -> None:
    """Print the figures."""
    warp.config.quiet = True
    wires = [PeerWire(**values) for values in json.loads(sys.argv[1])]
    sag = [sag_error(wire) for wire in wires]
    speed = [max(real_time_factor(wire) for _ in range(REPEATS)) for wire in wires]
    print(json.dumps({"long_sag": sag, "long_speed": speed}))


if __name__ == "__main__":
    main()
