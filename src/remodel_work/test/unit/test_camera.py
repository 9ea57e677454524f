"""A calibrated camera: what its pixels see."""

import math

import numpy as np

from remodel_work.camera import Lens, View, looking_at, looking_down

VIEWS = {
    "overhead": View(Lens(1280, 960, math.radians(36)), looking_down(0.5, 0.0, 1.1, 0.0)),
    "wrist": View(Lens(640, 480, math.radians(52)), looking_down(0.5, 0.05, 0.6, 1.0)),
    "oblique": View(
        Lens(640, 480, math.radians(40)),
        looking_at(np.array([1.2, -0.5, 0.9]), np.array([0.5, 0, 0])),
    ),
}  # fmt: skip


def test_projection_and_back_is_identity():
    view = VIEWS["oblique"]
    points = np.array([[0.45, -0.1, 0.02], [0.6, 0.2, 0.02]])
    np.testing.assert_allclose(view.on_plane(view.project(points), 0.02), points, atol=1e-9)
    depths = view.world_from_camera.inverse().apply(points)[:, 2]
    np.testing.assert_allclose(view.at_depth(view.project(points), depths), points, atol=1e-9)


def test_a_view_knows_whether_it_sees_something():
    view = VIEWS["overhead"]
    assert view.sees(np.array([[0.5, 0.0, 0.0]]), 30)
    assert not view.sees(np.array([[0.5, 2.0, 0.0]]), 30)
