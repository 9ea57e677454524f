"""PyBullet: a connection, and bodies that never move by themselves.

It simulates the physics of a cell, and it is the geometry of collision checks. Its own lines, its
build time and "argv[0]=", are not printed.
"""

from __future__ import annotations

import ctypes
import os
import sys
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from remodel_work.component_shape import Box
from remodel_work.geometry import Pose

# Bullet's own groups of what moves, which an arm is not in, and of what does not; and that of
# parked wires. Two bodies touch if the mask of either has the group of the other: fingers, which
# have sheaths for them (robot.py), and what does not move leave parked wires out of theirs. The
# contacts of 19 wires in their ducts, which change nothing, took three quarters of each step.
MOVING_GROUP, STATIC_GROUP = 1, 2
PARKED_GROUP = 8


@contextmanager
def _silenced(descriptor: int) -> Iterator[None]:
    """Drop what C code prints on standard output (1) or standard error (2)."""
    sys.stdout.flush()
    kept, nowhere = os.dup(descriptor), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, descriptor)
    try:
        yield
    finally:
        ctypes.CDLL(None).fflush(None)
        os.dup2(kept, descriptor)
        os.close(kept)
        os.close(nowhere)


with _silenced(2):  # its build time
    import pybullet
    from pybullet_utils.bullet_client import BulletClient


def connect(*, gui: bool = False) -> BulletClient:
    """Return PyBullet's functions, bound to a new world; `gui` opens its window."""
    with _silenced(1):  # "argv[0]="
        return BulletClient(pybullet.GUI if gui else pybullet.DIRECT)


def add_static(bullet: BulletClient, boxes: Iterable[Box], pose: Pose) -> int:
    """Add boxes as one body that never moves by itself; returns the body."""
    return add_described(bullet, boxes_description(boxes), pose)


def add_described(bullet: BulletClient, shapes: Iterable[str], pose: Pose) -> int:
    """Add a body that never moves by itself of URDF shapes; returns the body."""
    head = (
        '<robot name="body"><link name="body"><inertial><mass value="0"/>'
        '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
    )
    # Bullet reads a description line by line, and only so many characters of each.
    text = "\n".join([head, *shapes, "</link></robot>"])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "body.urdf"
        path.write_text(text)
        body = bullet.loadURDF(
            str(path), pose.position.tolist(), pose.quaternion.tolist(), useFixedBase=True
        )
    bullet.setCollisionFilterGroupMask(body, -1, STATIC_GROUP, ~(STATIC_GROUP | PARKED_GROUP))
    return int(body)


def boxes_description(boxes: Iterable[Box]) -> Iterator[str]:
    """Yield the URDF shapes of boxes."""
    for box in boxes:
        shape = '<origin xyz="{:.6f} {:.6f} {:.6f}" rpy="{:.8f} {:.8f} {:.8f}"/>'.format(
            *box.centre, *box.rpy
        ) + '<geometry><box size="{:.6f} {:.6f} {:.6f}"/></geometry>'.format(*box.size)
        name = "rgb_{}_{}_{}".format(*box.rgb)
        colour = '<color rgba="{} {} {} 1"/>'.format(*box.rgb)
        yield f'<visual>{shape}<material name="{name}">{colour}</material></visual>'
        if box.solid:
            yield f"<collision>{shape}</collision>"
