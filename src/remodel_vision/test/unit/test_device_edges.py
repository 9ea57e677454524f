"""The edges by which a device without a label is found."""

import numpy as np
from panels import component

from remodel_vision.device_pose import (
    device_edges,
)

ALONE = component("X1", 9, 0.08, -0.12, side=-1, terminals=2)


def test_the_edges_of_a_device_are_its_outline_and_a_screw_for_each_clamp():
    edges = device_edges(ALONE)
    top = edges.points[~edges.of_screw]
    half = np.array(ALONE.size[:2]) / 2
    assert np.all(np.isclose(np.abs(top[:, :2]), half).any(axis=1))
    assert np.all(top[:, 2] == ALONE.size[2])
    assert len(np.unique(edges.part)) == 8 + len(ALONE.terminals)
