"""Labels in drawn and rendered pictures; benchmarks/vision measures them over many more."""

import dataclasses
import math

import cv2
import numpy as np
import pytest
from panels import component, panel

from remodel_sim.physics.cameras import take
from remodel_sim.physics.fixtures.panel_scene import PanelScene
from remodel_sim.physics.world import World
from remodel_vision.label_pose import LabelView, locate_component
from remodel_vision.labels import find_labels, search_label
from remodel_work.camera import Lens, Picture, View, looking_down
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Pose

LENS = Lens(640, 480, math.radians(52.0))
HEIGHT = 0.204


@pytest.fixture
def looks():
    """A function: a component's pose to views of it from two places, and how it stands there."""
    world = World(240.0)
    part = component("X1", 1, 0.0, 0.0, side=1)
    noise = np.random.default_rng(4)
    table = read_cell().table

    def look(pose, blur=0.0):
        world.clear()
        PanelScene(world, table, panel(components=(part,), wires=()), {"X1": pose})
        found = []
        for aside in (0.0, 0.07):
            view = View(LENS, looking_down(0.50, aside, HEIGHT, 0.3))
            picture = take(world, view, noise)
            if blur:
                picture = Picture(cv2.GaussianBlur(picture.rgb, (0, 0), blur), None, view)
            found.append(LabelView(picture, find_labels(picture, [part])[1]))
        return found

    yield part, look
    world.close()


def test_a_label_that_a_wire_crosses_is_found_where_it_is_expected(looks):
    part, look = looks
    true = Pose.level(0.503, -0.004, 0.0, 0.07)
    first, _ = look(true)
    covered = first.picture.rgb.copy()
    start, end = np.rint(first.corners[[0, 2]] + [[-20, 10], [20, -5]]).astype(int).tolist()
    cv2.line(covered, start, end, (170, 40, 40), 7)
    picture = Picture(covered, None, first.picture.view)
    assert find_labels(picture, [part]) == {}
    near = Pose.level(0.50, 0.0, 0.0, 0.0)
    seen = locate_component(part, [LabelView(picture, search_label(picture, part, near))])
    assert error(seen.world_from_component, true)[0] < 0.0003
    stranger = dataclasses.replace(part, marker_id=17)
    assert search_label(picture, stranger, near) is None


def error(seen, true):
    turn = (np.trace(seen.rotation.T @ true.rotation) - 1) / 2
    away = seen.apply(np.array([0.025, 0, 0.022])) - true.apply(np.array([0.025, 0, 0.022]))
    return np.linalg.norm(away), math.degrees(math.acos(min(1.0, turn)))


@pytest.mark.parametrize("blur", [0.0, 1.5])
@pytest.mark.parametrize("count", [1, 2])
def test_an_upright_component_is_located(looks, blur, count):
    part, look = looks
    true = Pose.level(0.503, -0.004, 0.0, 0.07)
    seen = locate_component(part, look(true, blur)[:count])
    away, turned = error(seen.world_from_component, true)
    assert seen.upright
    assert away < 0.0002
    assert turned < 0.2


def test_a_component_askew_is_located_from_two_places(looks):
    part, look = looks
    tilt = np.array([0.03, -0.02, 0.0, 1.0])
    true = Pose.level(0.503, -0.004, 0.003, 0.07) @ Pose(np.zeros(3), tilt / np.linalg.norm(tilt))
    seen = locate_component(part, look(true))
    away, turned = error(seen.world_from_component, true)
    assert not seen.upright
    assert away < 0.0004
    assert turned < 0.8


def test_a_wire_over_the_label_does_not_move_it(looks):
    part, look = looks
    true = Pose.level(0.503, -0.004, 0.0, 0.07)
    first, _ = look(true)
    middle = first.corners.mean(axis=0)
    covered = first.picture.rgb.copy()
    start, end = np.rint(middle + np.array([[-60, -25], [60, -12]])).astype(int).tolist()
    cv2.line(covered, start, end, (170, 40, 40), 9)
    picture = Picture(covered, None, first.picture.view)
    seen = locate_component(part, [LabelView(picture, first.corners)])
    away, turned = error(seen.world_from_component, true)
    assert away < 0.0003
    assert turned < 0.4


def test_a_label_that_is_wholly_covered_is_not_seen_clearly(looks):
    part, look = looks
    first, _ = look(Pose.level(0.503, -0.004, 0.0, 0.07))
    stripes = np.tile(np.uint8([[0], [255]]), (240, 640))
    picture = Picture(np.repeat(stripes[..., None], 3, axis=2), None, first.picture.view)
    assert not locate_component(part, [LabelView(picture, first.corners)]).clear


TILTED = np.array([math.sin(math.radians(2)), -math.sin(math.radians(1)), 0.0, 0.9994])
ASKEW = Pose.level(0.503, -0.004, 0.002, 0.07) @ Pose(np.zeros(3), TILTED / np.linalg.norm(TILTED))


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


def test_covered_labels_askew_are_refused_or_located_right(looks):
    part, look = looks
    views = look(ASKEW)
    accepted = 0
    for cover in COVERS:
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
    assert accepted >= len(COVERS) / 2


def test_an_uncovered_label_is_reliable_from_two_places_and_leans_from_one(looks):
    part, look = looks
    views = look(ASKEW)
    assert locate_component(part, views).reliable
    alone = locate_component(part, views[:1])
    assert alone.clear and not alone.reliable
    upright = look(Pose.level(0.503, -0.004, 0.0, 0.07))
    assert locate_component(part, upright[:1]).reliable
