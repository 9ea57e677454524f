"""A calibrated camera: what its pixels see."""

import math

import numpy as np

from remodel_work.camera import Lens, View, looking_at, looking_down

OVERHEAD = View(Lens(1280, 960, math.radians(36)), looking_down(0.5, 0.0, 1.1, 0.0))
ASKANCE = looking_at(np.array([1.2, -0.5, 0.9]), np.array([0.5, 0, 0]))
OBLIQUE = View(Lens(640, 480, math.radians(40)), ASKANCE)


def test_projection_and_back_is_identity():
    points = np.array([[0.45, -0.1, 0.02], [0.6, 0.2, 0.02]])
    pixels = OBLIQUE.project(points)
    np.testing.assert_allclose(OBLIQUE.on_plane(pixels, 0.02), points, atol=1e-9)
    depths = OBLIQUE.world_from_camera.inverse().apply(points)[:, 2]
    np.testing.assert_allclose(OBLIQUE.at_depth(pixels, depths), points, atol=1e-9)


def test_a_view_knows_whether_it_sees_something():
    assert OVERHEAD.sees(np.array([[0.5, 0.0, 0.0]]), 30)
    assert not OVERHEAD.sees(np.array([[0.5, 2.0, 0.0]]), 30)
