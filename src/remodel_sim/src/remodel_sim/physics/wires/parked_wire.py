"""A placed wire, which keeps its shape: what is drawn of it, and its solid.

Live wires lie on it and slide along it, and hands push against it. It yields to them softly, as a
slack wire does, but returns: a hand would push a real wire aside for good.
"""

from __future__ import annotations

import io
import math
import tempfile
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from remodel_sim.core.wire_mechanics import CELL_TARGET_M
from remodel_sim.physics.wires.cable_body import connector_shapes
from remodel_sim.physics.world import World
from remodel_states.core.wires import rgbs_of
from remodel_work.component_shape import FERRULE_RGB, connector_solids
from remodel_work.edge.bullet import MOVING_GROUP, PARKED_GROUP, add_described
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Connector, PanelWire, WireEnd

SIDES = 8
STEP_M = 0.004
# Of wire with EI 1e-3 N m^2, pushed in the middle between rests 60 mm apart: 48 EI / L^3.
STIFFNESS_N_M = 220.0
DAMPING_NS_M = 1.0


def draw_parked(world: World, nodes: Array, wire: PanelWire) -> None:
    """Draw a wire as smooth tubes that touch nothing; nodes (n, 3) [m] go from tip to tip."""
    bullet = world.bullet
    with tempfile.TemporaryDirectory() as folder:
        # Bullet keeps the vertices that it is handed, even once the world is cleared: 1 MB for each
        # wire. What it reads from a file it releases.
        file = Path(folder) / "tube.obj"
        for tubes, rgb in _drawing(nodes.tobytes(), wire):
            file.write_text(tubes)
            shape = bullet.createVisualShape(
                bullet.GEOM_MESH, fileName=str(file), rgbaColor=[*rgb, 1]
            )
            bullet.createMultiBody(0, -1, shape, [0, 0, 0])
    for connector in wire.connectors:
        _draw_connector(world, nodes, wire, connector)


# The world is built for every wire, with all that lie there.
@lru_cache(maxsize=256)
def _drawing(nodes: bytes, wire: PanelWire) -> tuple[tuple[str, Sequence[float]], ...]:
    """Return tubes as Wavefront OBJ files, each with its colour; nodes (n, 3) [m]."""
    line = _smooth(np.frombuffer(nodes).reshape(-1, 3))
    from_a = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
    to_tip = {WireEnd.A: from_a, WireEnd.B: from_a[-1] - from_a}
    inner = np.all([to_tip[end] > wire.rigid_length(end) for end in WireEnd], axis=0)
    stripes = rgbs_of(wire.colour)
    shown = striped(line[inner], len(stripes))
    parts = [(pieces, rgb) for pieces, rgb in zip(shown, stripes, strict=True) if pieces]
    parts += [
        ([line[to_tip[end] <= wire.ferrule_length + STEP_M]], FERRULE_RGB)
        for end in WireEnd
        if wire.connector_at(end) is None
    ]
    return tuple((_tubes(pieces, wire.radius), rgb) for pieces, rgb in parts)


def striped(line: Array, colours: int) -> list[list[Array]]:
    """Return the pieces of a line (n, 3) [m] of each of so many colours, which take turns."""
    if colours == 1:
        return [[line]]
    points = round(CELL_TARGET_M / STEP_M)
    pieces = [line[i : i + points + 1] for i in range(0, len(line) - 1, points)]
    return [pieces[colour::colours] for colour in range(colours)]


def _draw_connector(world: World, nodes: Array, wire: PanelWire, connector: Connector) -> None:
    tip, inner = (nodes[0], nodes[1]) if connector.end is WireEnd.A else (nodes[-1], nodes[-2])
    out = (tip - inner) / np.linalg.norm(tip - inner)
    along = -out if connector.end is WireEnd.A else out
    bullet = world.bullet
    _, shape = connector_shapes(bullet, connector_solids(wire, connector), 0.0)
    middle = tip - out * (connector.length + wire.radius) / 2
    turned = bullet.getQuaternionFromEuler([0.0, *_pitch_yaw(along)])
    bullet.createMultiBody(0, -1, shape, middle.tolist(), turned)


def add_solid(world: World, nodes: Array, wire: PanelWire) -> None:
    """Make a drawn wire solid to live wires: a capsule for each of its links."""
    body = _add_capsules(world, nodes, wire.radius)
    world.bullet.changeDynamics(
        body,
        -1,
        lateralFriction=wire.friction,
        contactStiffness=STIFFNESS_N_M,
        contactDamping=DAMPING_NS_M,
    )
    world.bullet.setCollisionFilterGroupMask(body, -1, PARKED_GROUP, MOVING_GROUP)


def _add_capsules(world: World, nodes: Array, radius: float) -> int:
    # Bullet draws, in white, the solids of a link that has nothing to draw: it gets a speck.
    speck = '<visual><origin xyz="{:.6f} {:.6f} {:.6f}"/>'.format(*nodes[0])
    parts = [f'{speck}<geometry><box size="1e-6 1e-6 1e-6"/></geometry></visual>']
    for start, end in pairwise(nodes):
        axis = end - start
        length = float(np.linalg.norm(axis))
        pitch, yaw = _pitch_yaw(axis)
        x, y, z = (start + end) / 2
        parts.append(
            f'<collision><origin xyz="{x:.6f} {y:.6f} {z:.6f}" rpy="0 {pitch:.8f} {yaw:.8f}"/>'
            f'<geometry><capsule radius="{radius:.6f}" length="{length:.6f}"/></geometry>'
            "</collision>"
        )
    return add_described(world.bullet, parts, Pose.level(0.0, 0.0, 0.0))


def _pitch_yaw(axis: Array) -> tuple[float, float]:
    """Return the turns that bring z to an axis (3,): about y, then about z [rad]."""
    pitch = math.acos(float(np.clip(axis[2] / np.linalg.norm(axis), -1.0, 1.0)))
    return pitch, math.atan2(axis[1], axis[0])


def _smooth(nodes: Array) -> Array:
    """Return a Catmull-Rom spline through the nodes, about STEP_M apart."""
    padded = np.vstack([2 * nodes[0] - nodes[1], nodes, 2 * nodes[-1] - nodes[-2]])
    pieces = []
    for p0, p1, p2, p3 in zip(padded, padded[1:], padded[2:], padded[3:], strict=False):
        count = max(2, round(float(np.linalg.norm(p2 - p1)) / STEP_M))
        t = np.linspace(0, 1, count, endpoint=False)[:, None]
        pieces.append(
            0.5
            * (
                2 * p1
                + (p2 - p0) * t
                + (2 * p0 - 5 * p1 + 4 * p2 - p3) * t**2
                + (3 * p1 - p0 - 3 * p2 + p3) * t**3
            )
        )
    return np.vstack([*pieces, nodes[-1:]])


def _tubes(lines: Sequence[Array], radius: float) -> str:
    """Return tubes around lines (n, 3) as a Wavefront OBJ file."""
    ends = np.cumsum([SIDES * len(line) for line in lines])
    return "".join(
        _tube(line, radius, first=int(end) - SIDES * len(line) + 1)
        for line, end in zip(lines, ends, strict=True)
    )


def _tube(line: Array, radius: float, first: int) -> str:
    """Return a tube around a line (n, 3) as a part of a Wavefront OBJ file.

    Args:
        line: (n, 3) [m].
        radius: [m].
        first: number of its first vertex in the file, from 1.
    """
    tangents = np.gradient(line, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    side = np.cross(tangents, [0.0, 0.0, 1.0])
    side /= np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-9)
    top = np.cross(side, tangents)
    angles = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)
    normals = (
        np.cos(angles)[None, :, None] * side[:, None] + np.sin(angles)[None, :, None] * top[:, None]
    )
    vertices = (line[:, None] + radius * normals).reshape(-1, 3)
    # Of each side's quadrilateral: two corners on its ring, two on the next.
    a = first + np.arange((len(line) - 1) * SIDES).reshape(-1, SIDES)
    b = np.roll(a, -1, axis=1)
    a, b = a.ravel(), b.ravel()
    faces = np.vstack(
        [np.column_stack(each) for each in ((a, b, a + SIDES), (b, b + SIDES, a + SIDES))]
    )
    text = io.StringIO()
    np.savetxt(text, vertices, fmt="v %.6f %.6f %.6f")
    np.savetxt(text, normals.reshape(-1, 3), fmt="vn %.4f %.4f %.4f")
    np.savetxt(text, np.repeat(faces, 2, axis=1), fmt="f %d//%d %d//%d %d//%d")
    return text.getvalue()
