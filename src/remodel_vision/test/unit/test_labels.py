"""Labels in drawn pictures; benchmarks/vision measures them over many rendered ones."""

import dataclasses
import math
from functools import cache

import cv2
import numpy as np
import pytest
from drawn import picture, standing
from panels import component, panel

from remodel_vision.label_pose import LabelView, locate_component
from remodel_vision.labels import find_labels, search_label
from remodel_work.camera import Lens, Picture, View, looking_down
from remodel_work.component_shape import marker_cells
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD

LENS = Lens(640, 480, math.radians(52.0))
HEIGHT = 0.204
UPRIGHT = Pose.level(0.503, -0.004, 0.0, 0.07)
TILTED = np.array([math.sin(math.radians(2)), -math.sin(math.radians(1)), 0.0, 0.9994])
ASKEW = Pose.level(0.503, -0.004, 0.002, 0.07) @ Pose(np.zeros(3), TILTED / np.linalg.norm(TILTED))
HOUSING, PLATE = 85, 200


def housings(*labels):
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
    (found,) = find_labels(housings((3, 300, 240, turn)), panel().components).items()
    marker, corners = found
    assert marker == 3
    np.testing.assert_allclose(corners.mean(axis=0), [300, 240], atol=0.3)
    way = corners[1] - corners[0]
    assert math.degrees(math.atan2(-way[1], way[0])) % 360 == pytest.approx(turn % 360, abs=1)


def test_a_label_that_the_panel_lacks_is_none():
    assert find_labels(housings((158, 200, 240, 0), (115, 450, 240, 0)), panel().components) == {}


def test_a_label_seen_twice_is_not_reported():
    assert find_labels(housings((3, 150, 240, 0), (3, 450, 240, 0)), panel().components) == {}


def test_a_label_of_another_size_is_a_stranger():
    large = dataclasses.replace(component("X3", 3, 0.08, -0.12, side=-1), marker_size=0.034)
    assert find_labels(housings((3, 300, 240, 0)), [large]) == {}


@pytest.fixture(scope="module")
def looks():
    """A function: a component's pose to views of it from two places, and how it stands there."""
    part = component("X1", 1, 0.0, 0.0, side=1)

    @cache
    def look(pose, blur=0.0):
        boxes = standing(panel(components=(part,)), BOARD, {"X1": pose})
        found = []
        for seed, aside in enumerate((0.0, 0.07)):
            view = View(LENS, looking_down(0.50, aside, HEIGHT, 0.3))
            seen = picture(view, boxes, seed=seed).rgb
            if blur:
                seen = cv2.GaussianBlur(seen, (0, 0), blur)
            seen = Picture(seen, None, view)
            found.append(LabelView(seen, find_labels(seen, [part])[1]))
        return found

    return part, look


def test_a_label_that_a_wire_crosses_is_found_where_it_is_expected(looks):
    part, look = looks
    true = UPRIGHT
    first, _ = look(true)
    covered = first.picture.rgb.copy()
    start, end = np.rint(first.corners[[0, 2]] + [[-20, 10], [20, -5]]).astype(int).tolist()
    cv2.line(covered, start, end, (170, 40, 40), 7)
    crossed = Picture(covered, None, first.picture.view)
    assert find_labels(crossed, [part]) == {}
    near = Pose.level(0.50, 0.0, 0.0, 0.0)
    seen = locate_component(part, [LabelView(crossed, search_label(crossed, part, near))])
    assert error(seen.world_from_component, true)[0] < 0.0003
    stranger = dataclasses.replace(part, marker_id=17)
    assert search_label(crossed, stranger, near) is None


def error(seen, true):
    turn = (np.trace(seen.rotation.T @ true.rotation) - 1) / 2
    away = seen.apply(np.array([0.025, 0, 0.022])) - true.apply(np.array([0.025, 0, 0.022]))
    return np.linalg.norm(away), math.degrees(math.acos(min(1.0, turn)))


@pytest.mark.parametrize("blur", [0.0, 1.5])
@pytest.mark.parametrize("count", [1, 2])
def test_an_upright_component_is_located(looks, blur, count):
    part, look = looks
    true = UPRIGHT
    seen = locate_component(part, look(true, blur)[:count])
    away, turned = error(seen.world_from_component, true)
    assert seen.world_from_component.rotation[2, 2] == 1.0  # upright
    assert away < 0.0002
    assert turned < 0.2


def test_a_component_askew_is_located_from_two_places(looks):
    part, look = looks
    seen = locate_component(part, look(ASKEW))
    away, turned = error(seen.world_from_component, ASKEW)
    assert seen.reliable and seen.world_from_component.rotation[2, 2] < 1.0
    assert away < 0.0004
    assert turned < 0.8


def test_a_wire_over_the_label_does_not_move_it(looks):
    part, look = looks
    true = UPRIGHT
    first, _ = look(true)
    middle = first.corners.mean(axis=0)
    covered = first.picture.rgb.copy()
    start, end = np.rint(middle + np.array([[-60, -25], [60, -12]])).astype(int).tolist()
    cv2.line(covered, start, end, (170, 40, 40), 9)
    crossed = Picture(covered, None, first.picture.view)
    seen = locate_component(part, [LabelView(crossed, first.corners)])
    away, turned = error(seen.world_from_component, true)
    assert away < 0.0003
    assert turned < 0.4


def test_a_label_that_is_wholly_covered_is_not_seen_clearly(looks):
    part, look = looks
    first, _ = look(UPRIGHT)
    stripes = np.tile(np.uint8([[0], [255]]), (240, 640))
    crossed = Picture(np.repeat(stripes[..., None], 3, axis=2), None, first.picture.view)
    assert not locate_component(part, [LabelView(crossed, first.corners)]).clear


def taped(aside, way, rgb):
    """What sticks a strip over 15 % of a label, drawn into a picture at its corners."""

    def cover(picture, corners):
        flat = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
        along = np.array([math.cos(way), math.sin(way)])
        across = np.array([-along[1], along[0]])
        middle = 0.5 + aside * across
        corner = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        strip = [middle + 0.9 * a * along + 0.075 * b * across for a, b in corner]
        to_picture = cv2.getPerspectiveTransform(flat, corners.astype(np.float32))
        seen = cv2.perspectiveTransform(np.array([strip], np.float32), to_picture)[0]
        return cv2.fillConvexPoly(picture.rgb.copy(), np.rint(seen * 16).astype(int), rgb, 16, 4)

    return cover


def glare(column, row, levels, size):
    """What adds a bright spot to a picture; places and size are shares of the label's side."""

    def cover(picture, corners):
        to_picture = cv2.getPerspectiveTransform(
            np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32), corners.astype(np.float32)
        )
        middle = cv2.perspectiveTransform(np.array([[[column, row]]], np.float32), to_picture)[0, 0]
        spread = size * math.sqrt(abs(cv2.contourArea(corners.astype(np.float32))))
        y, x = np.mgrid[: picture.rgb.shape[0], : picture.rgb.shape[1]]
        spot = np.exp(-((x - middle[0]) ** 2 + (y - middle[1]) ** 2) / (2 * spread**2))
        return np.clip(picture.rgb + levels * spot[..., None], 0, 255).astype(np.uint8)

    return cover


COVERS = [
    taped(0.42, 0.0, (240, 240, 240)),
    taped(-0.42, math.pi / 2, (80, 80, 80)),
    taped(0.1, 0.6, (200, 170, 115)),
    taped(-0.3, 1.9, (140, 140, 140)),
    glare(0.2, 0.3, 250, 0.2),
    glare(0.8, 0.8, 150, 0.3),
    glare(0.5, 0.0, 380, 0.15),
    glare(0.0, 0.5, 120, 0.35),
]


@pytest.mark.parametrize(
    "covers", [COVERS[::2], pytest.param(COVERS[1::2], marks=pytest.mark.slow)]
)
def test_covered_labels_askew_are_refused_or_located_right(looks, covers):
    part, look = looks
    views = look(ASKEW)
    accepted = 0
    for cover in covers:
        seen = locate_component(
            part,
            [
                LabelView(Picture(cover(v.picture, v.corners), None, v.picture.view), v.corners)
                for v in views
            ],
        )
        if seen.reliable:
            accepted += 1
            away, turned = error(seen.world_from_component, ASKEW)
            assert away < 0.003 and turned < 3.0
    assert accepted >= len(covers) / 2


def test_a_component_is_reliable_from_one_place_only_if_it_stands_upright(looks):
    part, look = looks
    alone = locate_component(part, look(ASKEW)[:1])
    assert alone.clear and not alone.reliable
    upright = look(UPRIGHT)
    assert locate_component(part, upright[:1]).reliable
