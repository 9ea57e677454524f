#!/usr/bin/env python3
"""The same wires in MuJoCo's cable plugin: mujoco_peer.py JSON, a list of PeerWires, the long ones.

Sag against the elastica, and speed: of a short wire beside an arm, of the long ones alone. Run by
an interpreter that has mujoco (requirements-bench.txt); prints one JSON object. The plugin
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
from dataclasses import replace
from pathlib import Path

import mujoco

sys.path.insert(0, str(Path(__file__).parents[2] / "src" / "remodel_sim" / "test" / "unit"))
from peer_wire import GRAVITY, REPEATS, PeerWire

SAG_WIRE = PeerWire(
    length=0.30,
    cells=24,
    radius=0.002,
    linear_density=0.020,
    bending_stiffness=1e-3,
    torsional_stiffness=0.8e-3,
    friction=0.45,
)
TABLE_WIRE = replace(SAG_WIRE, length=0.384)
HEIGHT_M = 4.0  # of the clamp
REST_S = 30.0
MEASURED_S = 1.5
SHORT_REPEATS = 5

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


def build(wire: PeerWire, rate_hz: float, surroundings: str = "") -> mujoco.MjModel:
    """Return a model of a cable: clamped in the air, or loose if there are surroundings."""
    second_moment = math.pi * wire.radius**4 / 4
    joint, step = wire.bending_stiffness / wire.cell, 1.0 / rate_hz
    return mujoco.MjModel.from_xml_string(
        MODEL.format(
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
    )


def sag_errors(wire: PeerWire, rate_hz: float) -> tuple[float, float]:
    """Return the error of the tip's drop [%]: as it is, and for a clamp half a cell further out."""
    loaded = wire.loaded()
    model = build(loaded, rate_hz)
    data = mujoco.MjData(model)
    for _ in range(round(REST_S * rate_hz)):
        data.qvel *= 0.98  # only the shape at rest counts
        mujoco.mj_step(model, data)
    tip = data.xpos[-1] + wire.cell * data.xmat[-1].reshape(3, 3)[:, 0]
    return loaded.sag_errors(HEIGHT_M - float(tip[2]))


def real_time_factor(wire: PeerWire, rate_hz: float, surroundings: str) -> float:
    """Return simulated time over the CPU time of the one thread that computes it."""
    model = build(wire, rate_hz, surroundings)
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
    raw, shifted = sag_errors(SAG_WIRE, 500.0)
    speed = {str(rate): real_time_factor(TABLE_WIRE, rate, PLATE + ARM) for rate in (240.0, 500.0)}
    wires = [PeerWire(**values) for values in json.loads(sys.argv[1])]
    figures = {
        "sag_raw": raw,
        "sag_shifted": shifted,
        "speed": speed,
        "long_sag": [sag_errors(wire, 500.0)[1] for wire in wires],
        "long_speed": [
            max(real_time_factor(wire, 240.0, PLATE) for _ in range(REPEATS)) for wire in wires
        ],
    }
    print(json.dumps(figures))


if __name__ == "__main__":
    main()
