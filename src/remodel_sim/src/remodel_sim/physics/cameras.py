"""Rendered pictures, with the noise of real cameras."""

from __future__ import annotations

import cv2
import numpy as np

from remodel_sim.physics.world import World
from remodel_work.camera import Picture, View
from remodel_work.geometry import Pose

NEAR_M = 0.05
FAR_M = 2.5
# The same for people's pictures, which show all of a large cell.
FAR_FOR_PEOPLE_M = 6.0
LIGHT_DIRECTION = [0.4, -0.3, 1.2]
# An industrial colour camera: lens blur, and noise of 3 grey levels.
BLUR_PX = 0.5
NOISE_LEVELS = 3.0
# A structured-light depth camera at one metre.
DEPTH_NOISE_M = 0.001


def take(
    world: World,
    view: View,
    noise: np.random.Generator,
    *,
    depth: bool = False,
    light: float = 1.0,
    seen_from: Pose | None = None,
) -> Picture:
    """Take a picture as a camera of the cell would: diffuse light, blur and noise.

    Args:
        world: what the camera sees.
        view: of the camera, as the cell believes.
        noise: of the sensor.
        depth: whether it measures depth too.
        light: share of the usual light.
        seen_from: where the camera really is, when it has been bumped; world frame.
    """
    real = view if seen_from is None else View(view.lens, seen_from)
    rgb, metres = _render(world, real, shadow=False)
    blurred = light * cv2.GaussianBlur(rgb, (0, 0), BLUR_PX).astype(np.float32)
    blurred += NOISE_LEVELS * noise.standard_normal(rgb.shape, dtype=np.float32)
    seen = np.clip(np.rint(blurred), 0, 255).astype(np.uint8)
    if not depth:
        return Picture(seen, None, view)
    return Picture(seen, metres + DEPTH_NOISE_M * noise.standard_normal(metres.shape), view)


def photograph(world: World, view: View, *, shadow: bool = True) -> Picture:
    """Take a clean picture, for people; shadows double the time it takes."""
    return Picture(_render(world, view, shadow=shadow, far_m=FAR_FOR_PEOPLE_M)[0], None, view)


def _render(
    world: World, view: View, *, shadow: bool, far_m: float = FAR_M
) -> tuple[np.ndarray, np.ndarray]:
    bullet, lens, pose = world.bullet, view.lens, view.world_from_camera
    forward, up = pose.rotation[:, 2], -pose.rotation[:, 1]
    view_matrix = bullet.computeViewMatrix(
        pose.position.tolist(), (pose.position + forward).tolist(), up.tolist()
    )
    projection = bullet.computeProjectionMatrixFOV(
        np.degrees(lens.field_of_view), lens.width / lens.height, NEAR_M, far_m
    )
    _, _, rgba, buffer, _ = bullet.getCameraImage(
        lens.width,
        lens.height,
        view_matrix,
        projection,
        shadow=int(shadow),
        lightDirection=LIGHT_DIRECTION,
        renderer=bullet.ER_TINY_RENDERER,
        flags=bullet.ER_NO_SEGMENTATION_MASK,
    )
    shape = (lens.height, lens.width)
    rgb = np.asarray(rgba, np.uint8).reshape(*shape, 4)[:, :, :3]
    z = np.asarray(buffer, np.float64).reshape(shape)
    return np.ascontiguousarray(rgb), far_m * NEAR_M / (far_m - (far_m - NEAR_M) * z)
