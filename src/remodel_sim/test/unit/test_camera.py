import math

import cv2
import numpy as np
import pytest

from remodel_sim.physics.world import World, take_picture
from remodel_work.camera import Lens, View, looking_at, looking_down

VIEWS = {
    "overhead": View(Lens(1280, 960, math.radians(36)), looking_down(0.5, 0.0, 1.1, 0.0)),
    "wrist": View(Lens(640, 480, math.radians(52)), looking_down(0.5, 0.05, 0.6, 1.0)),
    "oblique": View(
        Lens(640, 480, math.radians(40)),
        looking_at(np.array([1.2, -0.5, 0.9]), np.array([0.5, 0, 0])),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", VIEWS)
def test_rendered_spheres_appear_where_the_model_says(name):
    view = VIEWS[name]
    world = World(240)
    ball = world.bullet.createVisualShape(
        world.bullet.GEOM_SPHERE, radius=0.008, rgbaColor=[1, 0, 0, 1]
    )
    grid = [
        (0.5 + x, y, 0.05) for x in np.linspace(-0.1, 0.1, 4) for y in np.linspace(-0.12, 0.12, 5)
    ]
    for place in grid:
        world.bullet.createMultiBody(0, -1, ball, place)
    picture = take_picture(world, view, np.random.default_rng(0), depth=True)
    red = picture.rgb[:, :, 0].astype(int) - picture.rgb[:, :, 1] > 80
    count, _, stats, centres = cv2.connectedComponentsWithStats(red.astype(np.uint8))
    expected = view.project(np.array(grid))
    errors = []
    for i in range(1, count):
        if stats[i][cv2.CC_STAT_AREA] > 40:
            errors.append(
                centres[i] - expected[np.linalg.norm(expected - centres[i], axis=1).argmin()]
            )
    assert len(errors) == len(grid)
    assert np.abs(np.mean(errors, axis=0)).max() < 0.1
    world.close()
