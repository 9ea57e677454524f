"""Clips in the world: lips on slides that motors close with a limited force."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

from remodel_sim.core.fixtures import FIXTURE_RGB, LIP_FRICTION, clip_boxes, lips_of
from remodel_sim.core.geometry import Pose
from remodel_sim.core.panel import Clip
from remodel_sim.physics.static_body import boxes_description
from remodel_sim.physics.world import CONTACT_DAMPING, CONTACT_STIFFNESS, World

LIP_MASS_KG = 0.05
# A lip closes no faster than this [m/s].
CLOSING_M_S = 0.05

LIP = """
<link name="lip{i}">
  <inertial><mass value="{mass}"/>
    <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial>
  <visual>{shape}<material name="lip"><color rgba="{r} {g} {b} 1"/></material></visual>
  <collision>{shape}</collision>
</link>
<joint name="slide{i}" type="prismatic">
  <parent link="body"/><child link="lip{i}"/>
  <origin xyz="0 {y:.6f} {z:.6f}"/><axis xyz="0 {side} 0"/>
  <limit lower="0" upper="{travel:.6f}" effort="1000" velocity="1"/>
</joint>"""


def add_clip(world: World, clip: Clip, world_from_clip: Pose) -> int:
    """Add a clip with closed lips; returns the body."""
    bullet = world.bullet
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "clip.urdf"
        path.write_text(_description(clip))
        body = bullet.loadURDF(
            str(path),
            world_from_clip.position.tolist(),
            world_from_clip.quaternion.tolist(),
            useFixedBase=True,
        )
    for link in (-1, 0, 1):
        bullet.changeDynamics(
            body,
            link,
            lateralFriction=LIP_FRICTION,
            restitution=0,
            contactStiffness=CONTACT_STIFFNESS,
            contactDamping=CONTACT_DAMPING,
        )
    bullet.setJointMotorControlArray(
        body,
        [0, 1],
        bullet.VELOCITY_CONTROL,
        targetVelocities=[-CLOSING_M_S] * 2,
        forces=[lips_of(clip).force] * 2,
    )
    return body


def _description(clip: Clip) -> str:
    head = (
        '<robot name="clip"><link name="body"><inertial><mass value="0"/>'
        '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
    )
    lips = lips_of(clip)
    shape = (
        f'<origin xyz="0 0 0" rpy="0 {math.pi / 2} 0"/><geometry>'
        f'<capsule radius="{lips.radius:.6f}" length="{clip.length:.6f}"/></geometry>'
    )
    red, green, blue = FIXTURE_RGB
    slides = [
        LIP.format(
            i=i,
            mass=LIP_MASS_KG,
            shape=shape,
            r=red,
            g=green,
            b=blue,
            y=side * lips.aside,
            z=lips.height,
            side=side,
            travel=lips.travel,
        )
        for i, side in enumerate((-1, 1))
    ]
    return "\n".join([head, *boxes_description(clip_boxes(clip)), "</link>", *slides, "</robot>"])
