"""Devices without labels in drawn pictures; benchmarks/vision measures many more."""

import dataclasses
import math

import numpy as np
import pytest
from drawn import picture, standing
from panels import component, panel

from remodel_vision.device_pose import (
    device_edges,
    locate_device,
    search_device,
    stands_there,
)
from remodel_vision.panel_pose import register_panel
from remodel_work.camera import View, looking_down
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD

HEIGHT = 0.204
CELL = read_cell()
# A row of four devices alike with 2 mm between them, and one alone.
ROW = tuple(component(f"D{i}", i, -0.08, 0.05 + 0.047 * i, side=1) for i in range(4))
ALONE = component("X1", 9, 0.08, -0.12, side=-1, terminals=2)
PANEL = panel(components=(*ROW, ALONE), wires=())
PANEL_AT = BOARD @ Pose.level(0.006, -0.007, 0.0, math.radians(1.2))


def stand(panel_at=PANEL_AT, stands=PANEL, **poses):
    """Return where each device stands, and what a panel looks like.

    `poses` has motions from where they should stand.
    """
    where = {
        part.id: panel_at
        @ Pose.level(0.0, 0.0015, 0.0)
        @ part.panel_from_component
        @ poses.get(part.id, Pose.level(0.0003, -0.0003, 0.0, 0.006))
        for part in PANEL.components
    }
    return where, standing(stands, panel_at, where, labels=False)


def from_above(boxes, light=1.0):
    return picture(CELL.overheads[0], boxes, seed=3, light=light)


def look(boxes, part, asides=((0.0, 0.0), (0.0, 0.045)), light=1.0):
    """What a search finds in pictures of the wrist camera over a device, and beside it."""
    near = PANEL_AT @ part.panel_from_component
    found = []
    for seed, aside in enumerate(asides):
        x, y = near.position[:2] + aside
        view = View(CELL.robots[0].camera.lens, looking_down(float(x), float(y), HEIGHT, 0.3))
        found.append(search_device(picture(view, boxes, seed=seed, light=light), PANEL, part, near))
    return found


def errors(found, true, part):
    openings = np.array([terminal.mouth for terminal in part.terminals])
    away = np.linalg.norm(found.apply(openings) - true.apply(openings), axis=1).max()
    return away, abs(found.yaw - true.yaw)


@pytest.mark.parametrize("light", [0.4, pytest.param(1.5, marks=pytest.mark.slow)])
def test_devices_in_a_row_and_alone_are_located(light):
    where, boxes = stand()
    above = from_above(boxes, light)
    registered = register_panel(above, PANEL)
    assert np.linalg.norm(registered.position - PANEL_AT.position) < 0.002
    assert abs(registered.yaw - PANEL_AT.yaw) < math.radians(0.2)
    for part in (ROW[0], ROW[2], ALONE):
        seen = locate_device(part, look(boxes, part, light=light))
        away, turned = errors(seen.world_from_component, where[part.id], part)
        assert seen.reliable
        assert stands_there(above, part, seen.world_from_component)
        assert away < 0.0003 and turned < math.radians(0.3)


def test_a_missing_device_is_not_its_neighbour():
    left = tuple(part for part in PANEL.components if part is not ROW[1])
    _, boxes = stand(stands=dataclasses.replace(PANEL, components=left))
    above, place = from_above(boxes), PANEL_AT @ ROW[1].panel_from_component
    assert look(boxes, ROW[1]) == [None, None]
    assert not stands_there(above, ROW[1], place)


@pytest.mark.parametrize(
    ("part", "moved"),
    [(ALONE, Pose.level(0.0, 0.0, 0.0, math.pi)), (ROW[0], Pose.level(0.0, -0.02, 0.0))],
    ids=["reversed", "20 mm along the rail, near the next device"],
)
def test_a_device_that_does_not_stand_as_it_should_is_refused(part, moved):
    _, boxes = stand(**{part.id: moved})
    views = [view for view in look(boxes, part) if view is not None]
    assert not views or not locate_device(part, views).clear


def test_a_device_that_is_not_down_on_its_rail_is_refused():
    where, boxes = stand(X1=Pose.level(0.0, 0.0, 0.004))
    views = look(boxes, ALONE)
    assert not locate_device(ALONE, views).reliable, "the pictures from two places do not agree"
    assert not stands_there(from_above(boxes), ALONE, PANEL_AT @ ALONE.panel_from_component)
    assert where["X1"].position[2] == pytest.approx(0.004)


def test_a_panel_that_is_another_one_or_too_far_off_is_not_registered():
    _, boxes = stand()
    other = dataclasses.replace(PANEL, size=(0.30, 0.50, 0.003), components=(ALONE,))
    assert register_panel(from_above(boxes), other) is None
    _, boxes = stand(BOARD @ Pose.level(0.03, 0.0, 0.0))
    assert register_panel(from_above(boxes), PANEL) is None


def test_the_edges_of_a_device_are_its_outline_and_a_screw_for_each_clamp():
    edges = device_edges(ALONE)
    top = edges.points[~edges.of_screw]
    half = np.array(ALONE.size[:2]) / 2
    assert np.all(np.isclose(np.abs(top[:, :2]), half).any(axis=1))
    assert np.all(top[:, 2] == ALONE.size[2])
    assert len(np.unique(edges.part)) == 8 + len(ALONE.terminals)
