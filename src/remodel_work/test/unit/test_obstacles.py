"""What a motion must not touch."""

import math

import numpy as np
import pytest
from panels import panel

from remodel_work.geometry import Pose
from remodel_work.obstacles import (
    component_name,
    panel_obstacles,
)
from remodel_work.panel import BOARD, Duct, Rail

X2 = component_name("X2")


def test_a_panels_obstacles_stand_where_they_were_located_else_as_drawn():
    duct = Duct(id="D", pose=(0.0, 0.0, math.pi / 2), length=0.3, width=0.04, height=0.06)
    rail = Rail(id="R", pose=(0.08, 0.0, math.pi / 2), length=0.3, width=0.035, height=0.0075)
    seen = {"X1": Pose.level(0.41, -0.10, 0.0, 0.2)}
    obstacles = panel_obstacles(panel(ducts=(duct,), rails=(rail,)), seen)
    boxes = {solid.name: solid.box for solid in obstacles.solids}
    assert {"duct 'D'", "rail 'R'", X2} <= set(boxes)
    np.testing.assert_allclose(boxes["component 'X1'"].centre, [0.41, -0.10, 0.0225])
    assert boxes["component 'X1'"].rpy == pytest.approx((0.0, 0.0, 0.2))
    x, y, _ = BOARD.position
    assert obstacles.nearest(np.array([x + 0.08, y + 0.12, 0.05])) == X2
    assert obstacles.nearest(np.array([x - 0.02, y - 0.01, 0.05])) == "duct 'D'"
