"""The space that an arm occupies: capsules around its links, its hand and what is bolted to it.

Capsules hold the whole of what they stand for, so a gap between capsules is never wider than the
real one. The numbers were measured on the meshes; test_arm_volume.py measures them again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from remodel_work.geometry import Array
from remodel_work.robot.arm import FRANKA_PANDA, KUKA_IIWA, Arm, Kinematics
from remodel_work.robot.fingers import Fingers
from remodel_work.robot.portal import Portal

# Radii around the axes [m]: of the foot, the column below the shoulder, the upper and the fore
# link, the wrist, and the flange.
LINK_RADII_M = {
    FRANKA_PANDA.name: (0.18, 0.14, 0.12, 0.135, 0.09, 0.092),
    KUKA_IIWA.name: (0.18, 0.14, 0.12, 0.12, 0.09, 0.092),
}
FOOT_M = 0.10
# The hand's body, across its fingers, hangs so far below the flange and reaches so far to either
# side; then the fingers, each around an axis so far beyond its open pad; then the wrist camera, on
# the side of positive y.
HAND_M = 0.030
HAND_HALF_WIDTH_M = 0.100
HAND_RADIUS_M = 0.050
FINGERS_M = 0.060
BEYOND_PAD_M = 0.015
FINGERS_RADIUS_M = 0.022
CAMERA_AT_M = (0.112, 0.040)
CAMERA_RADIUS_M = 0.035
# A portal's ram, above the flange.
RAM_M = 0.9
RAM_RADIUS_M = 0.040
# Shorter axes than its square root are points [m^2].
TINY_M2 = 1e-12


@dataclass(frozen=True, eq=False)
class Volume:
    """Capsules.

    Attributes:
        starts, ends: of their axes, (n, 3) each [m], world frame.
        radii: (n,) [m].
    """

    starts: Array
    ends: Array
    radii: Array


def volume_of(arm: Kinematics, postures: Array) -> Volume:
    """Return the space that a robot occupies in downward postures, (m, joints), all of them."""
    postures = np.atleast_2d(postures)
    if isinstance(arm, Portal):
        return _portal_volume(arm, postures)
    assert isinstance(arm, Arm), "an arm or a portal"
    return _arm_volume(arm, postures)


def _portal_volume(portal: Portal, postures: Array) -> Volume:
    """Return the space of the ram and the hand."""
    places = portal.world_from_base.apply(postures[:, :3])
    yaw = portal.base[3] + postures[:, 3]
    flange = places[:, 2] + portal.fingers.tool_m

    def hand(along_y: float, below: float) -> Array:
        """Map places of the hand's plane to the world; its y is to the right of x."""
        x, y = along_y * np.sin(yaw), -along_y * np.cos(yaw)
        return np.stack([places[:, 0] + x, places[:, 1] + y, flange - below], axis=1)

    ram = (hand(0.0, 0.0), hand(0.0, -RAM_M), RAM_RADIUS_M)
    return _volume([ram, *_hand_capsules(hand, portal.fingers)], len(postures))


Capsule = tuple[Array, Array, float]


def _hand_capsules(hand: Callable[[float, float], Array], fingers: Fingers) -> list[Capsule]:
    """Return the capsules of a hand; `hand` maps its places along y and below the flange [m]."""
    low, side = fingers.tool_m, fingers.opening / 2 + BEYOND_PAD_M
    across = HAND_HALF_WIDTH_M
    return [
        (hand(-across, HAND_M), hand(across, HAND_M), HAND_RADIUS_M),
        (hand(-side, FINGERS_M), hand(-side, low), FINGERS_RADIUS_M),
        (hand(side, FINGERS_M), hand(side, low), FINGERS_RADIUS_M),
        (hand(CAMERA_AT_M[0], CAMERA_AT_M[1]), hand(*CAMERA_AT_M), CAMERA_RADIUS_M),
    ]


def _volume(capsules: list[Capsule], postures: int) -> Volume:
    return Volume(
        np.concatenate([start for start, _, _ in capsules]),
        np.concatenate([end for _, end, _ in capsules]),
        np.repeat([radius for *_, radius in capsules], postures),
    )


def _arm_volume(arm: Arm, postures: Array) -> Volume:
    q1, q2, _, q4, _, _, q7 = postures[:, -7:].T
    model = arm.model
    heading, lean, fore = arm.base[3] + q1, q2, q2 - q4
    x, y, z = arm.first_joint_at(postures)

    def at(out: Array | float, up: Array | float, side: Array | float = 0.0) -> Array:
        """Map places in the arm's plane, and to the side of it, to the world, (m, 3) [m]."""
        c, s = np.cos(heading), np.sin(heading)
        return np.stack([x + c * out - s * side, y + s * out + c * side, z + up + 0 * c], axis=1)

    (along, across), (fore_along, back) = model.upper, model.fore
    shoulder = model.shoulder_height
    knee = along * np.sin(lean), shoulder + along * np.cos(lean)
    elbow = knee[0] + across * np.cos(lean), knee[1] - across * np.sin(lean)
    shin = elbow[0] - back * np.cos(fore), elbow[1] + back * np.sin(fore)
    wrist = shin[0] + fore_along * np.sin(fore), shin[1] + fore_along * np.cos(fore)
    out, flange = wrist[0] + model.wrist_offset, wrist[1] - model.flange
    # The hand's y axis, in the arm's plane and to the side of it: it points down, so y is to the
    # right of x.
    yaw = model.yaw_zero - q7
    y_out, y_side = np.sin(yaw), -np.cos(yaw)

    def hand(along_y: float, below: float) -> Array:
        return at(out + along_y * y_out, flange - below, along_y * y_side)

    foot, column, upper, lower, bulk, end = LINK_RADII_M[model.name]
    capsules = [
        (at(0.0 * q1, 0.0), at(0.0 * q1, FOOT_M), foot),
        (at(0.0 * q1, 0.0), at(0.0 * q1, shoulder), column),
        (at(0.0 * q1, shoulder), at(*knee), upper),
        (at(*knee), at(*elbow), upper),
        (at(*shin), at(*wrist), lower),
        (at(*wrist), at(out, wrist[1]), bulk),
        (at(out, wrist[1]), at(out, flange), end),
        *_hand_capsules(hand, arm.fingers),
    ]
    return _volume(capsules, len(q1))


def gap_between(first: Volume, second: Volume) -> float:
    """Return the least distance between two volumes [m]; negative where they overlap."""
    return float(gaps_between(first, second).min())


def gaps_between(first: Volume, second: Volume) -> Array:
    """Return the distances between the capsules of two volumes, (n, m) [m].

    Ericson, Real-Time Collision Detection (2005), 5.1.9, for all pairs of axes at once.
    """
    p, q = first.starts[:, None], second.starts[None, :]
    u, v = first.ends[:, None] - p, second.ends[None, :] - q
    w = p - q
    uu = np.maximum((u * u).sum(axis=2), TINY_M2)
    vv = np.maximum((v * v).sum(axis=2), TINY_M2)
    uv, uw, vw = (u * v).sum(axis=2), (u * w).sum(axis=2), (v * w).sum(axis=2)
    determinant = np.maximum(uu * vv - uv * uv, TINY_M2 * TINY_M2)
    s = np.clip((uv * vw - uw * vv) / determinant, 0.0, 1.0)
    t = np.clip((uv * s + vw) / vv, 0.0, 1.0)
    s = np.clip((uv * t - uw) / uu, 0.0, 1.0)
    apart = np.linalg.norm(w + s[..., None] * u - t[..., None] * v, axis=2)
    return np.asarray(apart - first.radii[:, None] - second.radii[None, :])
