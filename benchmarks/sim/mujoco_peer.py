#!/usr/bin/env python3
"""The same wire in MuJoCo's cable plugin: sag against the elastica, and speed beside an arm.

Run by an interpreter that has mujoco (requirements-bench.txt); prints one JSON object. The plugin
holds the first segment rigid in the clamp; so its sag is also compared with a beam that is clamped
where that segment's flexible half ends. Its links need the same extra inertia as ours at these time
steps (armature = 4 K dt^2); else they explode.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import json
import math
import sys
import time
from pathlib import Path

import mujoco

sys.path.insert(0, str(Path(__file__).parents[2] / "src" / "remodel_sim" / "test" / "unit"))
from elastica import cantilever_drop

GRAVITY = 9.81
STIFFNESS = 1e-3  # EI [N m^2]
TORSION_RATIO = 0.8
RADIUS = 0.002
DENSITY_KG_M = 0.020
CELLS = 24
SAG_LENGTH_M = 0.30
SAG_LOAD = 5.0
TABLE_LENGTH_M = 0.384
REST_S = 30.0
MEASURED_S = 1.5
REPEATS = 5

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
      <geom type="capsule" size="{radius}" mass="{mass}" friction="0.45 0.0001 0.0001"/>
    </composite>
  </worldbody>
</mujoco>
"""
# A plate, and an arm of seven servos out of the wire's way.
CELL = (
    '<geom type="plane" size="2 2 0.1" friction="0.45 0.0001 0.0001"/><body pos="-1 0 1">'
    + "".join(
        f'<body pos="0 0 0.1"><joint type="hinge" axis="{axis}" damping="50" stiffness="500"/>'
        '<geom type="sphere" size="0.05" mass="2.5" contype="0" conaffinity="0"/>'
        for axis in ("0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1")
    )
    + "</body>" * 8
)


def build(length: float, density: float, rate_hz: float, *, table: bool) -> mujoco.MjModel:
    """Return a model of a cable, clamped in the air or loose on the table; density in kg/m."""
    second_moment = math.pi * RADIUS**4 / 4
    young = STIFFNESS / second_moment
    joint, step = STIFFNESS / (length / CELLS), 1.0 / rate_hz
    return mujoco.MjModel.from_xml_string(
        MODEL.format(
            step=step,
            gravity=GRAVITY,
            surroundings=CELL if table else "",
            nodes=CELLS + 1,
            length=length,
            height=RADIUS if table else 1.0,
            initial="free" if table else "none",
            young=young,
            shear=TORSION_RATIO * young / 2,  # the polar second moment is twice the other
            damping=0.25 * joint * step,
            armature=4 * joint * step**2,
            radius=RADIUS,
            mass=density * length / CELLS,
        )
    )


def sag_errors(rate_hz: float) -> tuple[float, float]:
    """Return the error of the tip's drop [%]: as it is, and for a clamp half a cell further out."""
    length, cell = SAG_LENGTH_M, SAG_LENGTH_M / CELLS
    weight = SAG_LOAD * STIFFNESS / length**3
    model = build(length, weight / GRAVITY, rate_hz, table=False)
    data = mujoco.MjData(model)
    for _ in range(round(REST_S * rate_hz)):
        data.qvel *= 0.98  # only the shape at rest counts
        mujoco.mj_step(model, data)
    tip = data.xpos[-1] + cell * data.xmat[-1].reshape(3, 3)[:, 0]
    drop = 1.0 - float(tip[2])
    beams = (length, length - cell / 2)
    raw, shifted = (100 * abs(drop / cantilever_drop(b, STIFFNESS, weight) - 1) for b in beams)
    return raw, shifted


def real_time_factor(rate_hz: float) -> float:
    """Return simulated time over the CPU time of the one thread that computes it."""
    model = build(TABLE_LENGTH_M, DENSITY_KG_M, rate_hz, table=True)
    data = mujoco.MjData(model)
    for _ in range(round(rate_hz / 2)):
        mujoco.mj_step(model, data)
    steps = round(MEASURED_S * rate_hz)
    began = time.process_time()
    for _ in range(steps):
        mujoco.mj_step(model, data)
    return steps / rate_hz / (time.process_time() - began)


def main() -> None:
    """Print the figures."""
    raw, shifted = sag_errors(500.0)
    speed = {
        str(rate): max(real_time_factor(rate) for _ in range(REPEATS)) for rate in (240.0, 500.0)
    }
    print(json.dumps({"sag_raw": raw, "sag_shifted": shifted, "speed": speed}))


if __name__ == "__main__":
    main()
