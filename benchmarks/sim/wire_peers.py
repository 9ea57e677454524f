#!/usr/bin/env python3
"""Wires in other simulators: wire_peers.py mujoco|newton JSON, a list of the long Wires.

Sag against the elastica, and speed; prints a JSON object. Run by an interpreter that has them
(requirements-bench.txt). Both hold the first segment rigid in the clamp, so sag is also compared
with a beam that is clamped where that segment's flexible half ends.

MuJoCo's cable plugin also has a short wire, alone and beside an arm. Its links need the same extra
inertia as ours at these time steps (armature = 4 K dt^2); else they explode. Newton's VBD cable, on
the CPU, has the iterations of Newton's own cable examples; the time steps are ours.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_sim/test/unit"))
from elastica import cantilever_drop

GRAVITY = 9.81
SAG_LOAD = 5.0  # w L^3 / EI
REPEATS, SHORT_REPEATS = 3, 5  # of a measurement of speed; the best counts
HEIGHT_M = 4.0  # of a clamp
SETTLED_S, MEASURED_S = 0.5, 1.5

MODEL = """
<mujoco>
  <extension><plugin plugin="mujoco.elasticity.cable"/></extension>
  <option timestep="{step}" gravity="0 0 -{gravity}"/>
  <worldbody>
    {surroundings}
    <composite type="cable" curve="s" count="{nodes} 1 1" size="{length}" offset="0 0 {height}"
               initial="{initial}">
      <plugin plugin="mujoco.elasticity.cable">
        <config key="twist" value="{shear}"/>
        <config key="bend" value="{young}"/>
        <config key="vmax" value="0"/>
      </plugin>
      <joint kind="main" damping="{damping}" armature="{armature}"/>
      <geom type="capsule" size="{radius}" mass="{mass}" friction="{friction} 0.0001 0.0001"/>
    </composite>
  </worldbody>
</mujoco>
"""
PLATE = '<geom type="plane" size="4 4 0.1" friction="{friction} 0.0001 0.0001"/>'
# An arm of seven servos out of the wire's way.
ARM = (
    '<body pos="-1 0 1">'
    + "".join(
        f'<body pos="0 0 0.1"><joint type="hinge" axis="{axis}" damping="50" stiffness="500"/>'
        '<geom type="sphere" size="0.05" mass="2.5" contype="0" conaffinity="0"/>'
        for axis in ("0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1")
    )
    + "</body>" * 8
)


@dataclass(frozen=True)
class Wire:
    """A wire of equal cells.

    Attributes:
        length: [m].
        cells: number of its links.
        radius: [m].
        linear_density: [kg/m].
        bending_stiffness: EI [N m^2].
        torsional_stiffness: GJ [N m^2].
        friction: lateral friction coefficient of wire and plate together.
    """

    length: float
    cells: int
    radius: float
    linear_density: float
    bending_stiffness: float
    torsional_stiffness: float
    friction: float

    @property
    def cell(self) -> float:
        """The length of a cell [m]."""
        return self.length / self.cells


SHORT = Wire(0.30, 24, 0.002, 0.020, 1e-3, 0.8e-3, 0.45)


class MujocoCable:
    """A cable in MuJoCo: clamped in the air, or loose in surroundings."""

    rest_s, damping, sag_hz = 30.0, 0.98, 500.0

    def __init__(self, wire: Wire, rate_hz: float, surroundings: str = "") -> None:
        import mujoco

        second_moment = math.pi * wire.radius**4 / 4
        joint, step = wire.bending_stiffness / wire.cell, 1.0 / rate_hz
        text = MODEL.format(
            step=step,
            gravity=GRAVITY,
            surroundings=surroundings.format(friction=wire.friction),
            nodes=wire.cells + 1,
            length=wire.length,
            height=wire.radius if surroundings else HEIGHT_M,
            initial="free" if surroundings else "none",
            young=wire.bending_stiffness / second_moment,
            shear=wire.torsional_stiffness / (2 * second_moment),
            damping=0.25 * joint * step,
            armature=4 * joint * step**2,
            radius=wire.radius,
            mass=wire.linear_density * wire.cell,
            friction=wire.friction,
        )
        self._model = mujoco.MjModel.from_xml_string(text)
        self._data = mujoco.MjData(self._model)
        self._step, self._cell = mujoco.mj_step, wire.cell

    def step(self, damping: float = 1.0) -> None:
        """Advance by one time step; velocities are multiplied by `damping` before it."""
        if damping != 1.0:
            self._data.qvel *= damping
        self._step(self._model, self._data)

    def tip_z(self) -> float:
        """Return the height of the free end [m]."""
        axis = self._data.xmat[-1].reshape(3, 3)[:, 0]
        return float(self._data.xpos[-1][2] + self._cell * axis[2])


class NewtonCable:
    """A cable in Newton: clamped in the air, or loose on the plate."""

    rest_s, damping, sag_hz = 10.0, 0.96, 240.0
    iterations = 5
    stretch_n = 2e3  # Newton's default of 1e5 N/m for a joint of 20 mm
    joint_damping_steps = 0.25  # as ours

    def __init__(self, wire: Wire, rate_hz: float, surroundings: str = "") -> None:
        import newton
        import warp

        warp.config.quiet = True
        volume = math.pi * wire.radius**2 * (wire.cell + 4 / 3 * wire.radius)
        builder = newton.ModelBuilder(gravity=(0.0, 0.0, -GRAVITY))
        builder.default_shape_cfg.mu = wire.friction
        builder.default_shape_cfg.density = wire.linear_density * wire.cell / volume
        if surroundings:
            builder.add_ground_plane()
        rod = newton.Rod.create_straight(
            start=(0.0, 0.0, wire.radius if surroundings else HEIGHT_M),
            direction=(1.0, 0.0, 0.0),
            length=wire.length,
            segment_count=wire.cells,
            radius=wire.radius,
            bend_rigidity=wire.bending_stiffness,
            twist_rigidity=wire.torsional_stiffness,
            stretch_rigidity=self.stretch_n,
            shear_rigidity=self.stretch_n,
        )
        damping_s = self.joint_damping_steps / rate_hz / wire.cell
        bodies, _ = builder.add_rod(
            rod=rod,
            bend_damping=damping_s * wire.bending_stiffness,
            twist_damping=damping_s * wire.torsional_stiffness,
        )
        if not surroundings:
            clamp = bodies[0]
            builder.body_mass[clamp] = builder.body_inv_mass[clamp] = 0.0
            builder.body_inertia[clamp] = builder.body_inv_inertia[clamp] = warp.mat33(0.0)
        builder.color()
        model = builder.finalize(device="cpu")
        self._pipeline = self._contacts = None
        if surroundings:
            self._pipeline = newton.CollisionPipeline(model, contact_matching="sticky")
            self._contacts = self._pipeline.contacts()
        self._solver = newton.solvers.SolverVBD(
            model, iterations=self.iterations, rigid_contact_history=bool(surroundings)
        )
        self._control = model.control()
        self._now, self._next = model.state(), model.state()
        self._step_s, self._half = 1.0 / rate_hz, wire.cell / 2

    def step(self, damping: float = 1.0) -> None:
        """Advance by one time step; velocities are multiplied by `damping` before it."""
        if damping != 1.0:
            self._now.body_qd.assign(damping * self._now.body_qd.numpy())
        self._now.clear_forces()
        if self._pipeline is not None:
            self._pipeline.collide(self._now, self._contacts)
        self._solver.step(self._now, self._next, self._control, self._contacts, self._step_s)
        self._now, self._next = self._next, self._now

    def tip_z(self) -> float:
        """Return the height of the free end [m]."""
        pose = self._now.body_q.numpy()[-1]
        x, y = pose[3:5]
        return float(pose[2] + self._half * (1 - 2 * (x * x + y * y)))


Cable = type[MujocoCable] | type[NewtonCable]


def sag_errors(cable: Cable, wire: Wire) -> tuple[float, float]:
    """Return the error of a wire's drop at rest [%]: clamped there, and half a cell further out."""
    weight = SAG_LOAD * wire.bending_stiffness / wire.length**3
    hanging = cable(replace(wire, linear_density=weight / GRAVITY), cable.sag_hz)
    for _ in range(round(cable.rest_s * cable.sag_hz)):
        hanging.step(cable.damping)  # only the shape at rest counts
    drop = HEIGHT_M - hanging.tip_z()
    raw, shifted = (
        100 * abs(drop / cantilever_drop(beam, wire.bending_stiffness, weight) - 1)
        for beam in (wire.length, wire.length - wire.cell / 2)
    )
    return raw, shifted


def real_time_factor(cable: Cable, wire: Wire, rate_hz: float, surroundings: str) -> float:
    """Return simulated time over CPU time."""
    lying = cable(wire, rate_hz, surroundings)
    for _ in range(round(SETTLED_S * rate_hz)):
        lying.step()
    steps = round(MEASURED_S * rate_hz)
    began = time.process_time()
    for _ in range(steps):
        lying.step()
    return steps / rate_hz / (time.process_time() - began)


def figures(cable: Cable, wires: list[Wire]) -> dict[str, Any]:
    """Return errors and speeds of long wires, and of MuJoCo those of a short one."""
    found: dict[str, Any] = {
        "long_sag": [sag_errors(cable, wire)[1] for wire in wires],
        "long_speed": [
            max(real_time_factor(cable, wire, 240.0, PLATE) for _ in range(REPEATS))
            for wire in wires
        ],
    }
    if cable is MujocoCable:
        found["sag_raw"], found["sag_shifted"] = sag_errors(cable, SHORT)
        on_plate = replace(SHORT, length=0.384)
        found["speed"] = {
            rate: max(
                real_time_factor(cable, on_plate, rate, PLATE + ARM) for _ in range(SHORT_REPEATS)
            )
            for rate in (240.0, 500.0)
        }
    return found


if __name__ == "__main__":
    simulators = {"mujoco": MujocoCable, "newton": NewtonCable}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("simulator", choices=simulators)
    parser.add_argument("wires", type=json.loads, metavar="JSON")
    options = parser.parse_args()
    wires = [Wire(**each) for each in options.wires]
    print(json.dumps(figures(simulators[options.simulator], wires)))
