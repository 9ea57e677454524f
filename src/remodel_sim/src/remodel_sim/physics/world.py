"""One PyBullet world: its clock, its solver settings, and pictures with the noise of cameras."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from remodel_sim.core.wire_mechanics import GRAVITY
from remodel_work.camera import Picture, View
from remodel_work.edge.bullet import connect
from remodel_work.geometry import Pose

# A wire's link of half a gram between two fingers makes the contact solver converge a thousand
# times too slowly. Wires get this many times their mass, and gravity is as many times weaker:
# weights, and with them all statics and friction, stay true; only a free wire moves more slowly.
# Everything else is bolted down or driven by stiff servos.
MASS_SCALE = 20.0
# A held wire creeps through the grip by 0.3 mm while the hand carries and pushes it, by 0.2 mm with
# 200 iterations, which take twice as long.
SOLVER_ITERATIONS = 80
# The solver stops when an iteration changes no velocity by more than 0.5 mm/s [(m/s)^2]. At four
# times as much the grip loses 15 % of its friction.
SOLVER_RESIDUAL = 3e-7
# Stiff penalty contacts keep a jammed ferrule within 0.35 mm of a wall at few iterations.
CONTACT_STIFFNESS = 1e5
CONTACT_DAMPING = 200.0


class World:
    """A PyBullet world with a fixed time step. Only the thread that made it may use it.

    Attributes:
        bullet: PyBullet's functions, bound to this world.
        time_step: [s].
        steps: number of steps made since the world was built.
    """

    def __init__(self, rate_hz: float, *, gui: bool = False) -> None:
        """Connect; `gui` opens PyBullet's window."""
        self.bullet = connect(gui=gui)
        self.time_step = 1.0 / rate_hz
        self.steps = 0
        self._before_step: list[Callable[[], None]] = []
        self.clear()

    def clear(self) -> None:
        """Remove every body and restart the count of steps."""
        self.bullet.resetSimulation()
        self.bullet.setGravity(0, 0, -GRAVITY / MASS_SCALE)
        self.bullet.setPhysicsEngineParameter(
            fixedTimeStep=self.time_step,
            numSolverIterations=SOLVER_ITERATIONS,
            solverResidualThreshold=SOLVER_RESIDUAL,
            deterministicOverlappingPairs=1,
            enableFileCaching=0,
        )
        self._before_step.clear()
        self.steps = 0

    def add_before_step(self, action: Callable[[], None]) -> None:
        """Call `action` before every step from now on."""
        self._before_step.append(action)

    def remove_before_step(self, action: Callable[[], None]) -> None:
        """Stop calling `action`."""
        self._before_step.remove(action)

    def step(self) -> None:
        """Advance by one time step."""
        for action in tuple(self._before_step):
            action()
        self.bullet.stepSimulation()
        self.steps += 1

    def close(self) -> None:
        """Disconnect."""
        self.bullet.disconnect()


# Rendered pictures


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


def take_picture(
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
