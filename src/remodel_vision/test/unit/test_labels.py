"""Labels in drawn pictures; benchmarks/vision measures them over many rendered ones."""

import dataclasses
import math

import cv2
import numpy as np
import pytest
from panels import component, panel

from remodel_vision.labels import find_labels
from remodel_work.camera import Lens, Picture, View, looking_down
from remodel_work.component_shape import marker_cells

LENS = Lens(640, 480, math.radians(52.0))
HEIGHT = 0.204
HOUSING, PLATE = 85, 200


def drawn(*labels):
    """A picture from above of dark housings, each with a label: (marker, column, row, turn)."""
    grey = np.full((480, 640), PLATE, np.float32)
    for marker, column, row, turn in labels:
        cells = np.kron(np.pad(marker_cells(marker), 1, constant_values=255), np.ones((20, 20)))
        tile = np.pad(cells, 60, constant_values=HOUSING).astype(np.float32)
        scale = 11 / 20
        move = cv2.getRotationMatrix2D((139.5, 139.5), turn, scale)
        move[:, 2] += [column - 139.5, row - 139.5]
        cover = cv2.warpAffine(np.ones_like(tile), move, (640, 480))
        grey = grey * (1 - cover) + cv2.warpAffine(tile, move, (640, 480))
    noise = np.random.default_rng(1).normal(0, 3, grey.shape)
    rgb = np.repeat(np.clip(grey + noise, 0, 255).astype(np.uint8)[..., None], 3, axis=2)
    view = View(LENS, looking_down(0.5, 0.0, HEIGHT, math.pi / 2))
    return Picture(cv2.GaussianBlur(rgb, (0, 0), 0.6), None, view)


@pytest.mark.parametrize("turn", [0, 10, 95, 181, -80])
def test_a_label_is_found_not_the_outline_of_its_housing(turn):
    (found,) = find_labels(drawn((3, 300, 240, turn)), panel().components).items()
    marker, corners = found
    assert marker == 3
    np.testing.assert_allclose(corners.mean(axis=0), [300, 240], atol=0.3)
    way = corners[1] - corners[0]
    assert math.degrees(math.atan2(-way[1], way[0])) % 360 == pytest.approx(turn % 360, abs=1)


def test_a_label_that_the_panel_lacks_is_none():
    assert find_labels(drawn((158, 200, 240, 0), (115, 450, 240, 0)), panel().components) == {}


def test_a_label_seen_twice_is_not_reported():
    assert find_labels(drawn((3, 150, 240, 0), (3, 450, 240, 0)), panel().components) == {}


def test_a_label_of_another_size_is_a_stranger():
    large = dataclasses.replace(component("X3", 3, 0.08, -0.12, side=-1), marker_size=0.034)
    assert find_labels(drawn((3, 300, 240, 0)), [large]) == {}
