"""Devices without labels in rendered pictures; benchmarks/vision/devices.py measures many more."""

import dataclasses
import math

import numpy as np
import pytest
from panels import component, panel

from remodel_sim.physics.cameras import take
from remodel_sim.physics.fixtures.panel_scene import PanelScene
from remodel_sim.physics.world import World
from remodel_vision.device_pose import (
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


@pytest.fixture(scope="module")
def world():
    made = World(240.0)
    yield made
    made.close()


def stand(world, panel_at=PANEL_AT, stands=PANEL, **poses):
    """Build a panel; returns where each device stands. `poses` has motions from where it should."""
    where = {
        part.id: panel_at
        @ Pose.level(0.0, 0.0015, 0.0)
        @ part.panel_from_component
        @ poses.get(part.id, Pose.level(0.0003, -0.0003, 0.0, 0.006))
        for part in PANEL.components
    }
    world.clear()
    PanelScene(world, CELL.table, stands, where, world_from_panel=panel_at, labels=False)
    return where


def from_above(world, light=1.0):
    return take(world, CELL.overhead, np.random.default_rng(3), depth=True, light=light)


def look(world, part, asides=((0.0, 0.0), (0.0, 0.045)), light=1.0):
    """What a search finds in pictures of the wrist camera over a device, and beside it."""
    near, noise = PANEL_AT @ part.panel_from_component, np.random.default_rng(4)
    found = []
    for aside in asides:
        x, y = near.position[:2] + aside
        view = View(CELL.robots[0].camera.lens, looking_down(float(x), float(y), HEIGHT, 0.3))
        found.append(search_device(take(world, view, noise, light=light), PANEL, part, near))
    return found


def errors(found, true, part):
    openings = np.array([terminal.mouth for terminal in part.terminals])
    away = np.linalg.norm(found.apply(openings) - true.apply(openings), axis=1).max()
    return away, abs(found.yaw - true.yaw)


@pytest.mark.parametrize("light", [0.4, 1.5])
def test_devices_in_a_row_and_alone_are_located(world, light):
    where = stand(world)
    above = from_above(world, light)
    registered = register_panel(above, PANEL)
    assert np.linalg.norm(registered.position - PANEL_AT.position) < 0.002
    assert abs(registered.yaw - PANEL_AT.yaw) < math.radians(0.2)
    for part in (ROW[0], ROW[2], ALONE):
        seen = locate_device(part, look(world, part, light=light))
        away, turned = errors(seen.world_from_component, where[part.id], part)
        assert seen.reliable
        assert stands_there(above, part, seen.world_from_component)
        assert away < 0.0003 and turned < math.radians(0.3)


def test_a_missing_device_is_not_its_neighbour(world):
    left = tuple(part for part in PANEL.components if part is not ROW[1])
    stand(world, stands=dataclasses.replace(PANEL, components=left))
    above, place = from_above(world), PANEL_AT @ ROW[1].panel_from_component
    assert look(world, ROW[1]) == [None, None]
    assert not stands_there(above, ROW[1], place)


def test_a_device_turned_round_is_refused(world):
    stand(world, X1=Pose.level(0.0, 0.0, 0.0, math.pi))
    views = [view for view in look(world, ALONE) if view is not None]
    assert not views or not locate_device(ALONE, views).clear


def test_a_device_that_is_not_down_on_its_rail_is_refused(world):
    where = stand(world, X1=Pose.level(0.0, 0.0, 0.004))
    views = look(world, ALONE)
    assert not locate_device(ALONE, views).reliable, "the pictures from two places do not agree"
    assert not stands_there(from_above(world), ALONE, PANEL_AT @ ALONE.panel_from_component)
    assert where["X1"].position[2] == pytest.approx(0.004)


def test_a_device_further_along_than_it_can_be_told_from_the_next_is_refused(world):
    stand(world, D0=Pose.level(0.0, -0.02, 0.0))
    views = [view for view in look(world, ROW[0]) if view is not None]
    assert not views or not locate_device(ROW[0], views).clear


def test_a_panel_that_is_another_one_or_too_far_off_is_not_registered(world):
    stand(world)
    other = dataclasses.replace(PANEL, size=(0.30, 0.50, 0.003), components=(ALONE,))
    assert register_panel(from_above(world), other) is None
    stand(world, BOARD @ Pose.level(0.03, 0.0, 0.0))
    assert register_panel(from_above(world), PANEL) is None
