"""A cell whose components carry no labels: its abilities, its cameras and its physics."""

import dataclasses
import math

import numpy as np
import place_wire as do
import pytest
from panels import example

from remodel_sim.physics.plant import SimulatedPlant
from remodel_skills.abilities.inspection import (
    CheckGoal,
    LocateGoal,
    check_connection,
    locate_gearbox_component,
)
from remodel_skills.cell import Cell
from remodel_states.core.codes import Code
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import AbilityError
from remodel_work.panel import WireEnd

pytestmark = pytest.mark.physics

WITHIN_M, WITHIN_RAD = 0.0005, math.radians(0.5)


def unlabelled(name, panel):
    design = dataclasses.replace(read_cell(name), labels=False)
    return Cell(SimulatedPlant(example(panel), design=design, seed=3))


def locate(cell, component):
    terminal = cell.context.panel.component(component).terminals[0].id
    return do.do(cell, locate_gearbox_component, LocateGoal(component, terminal))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "panel", "components"),
    [
        ("cabinet", "household", ["D15", "Q1"]),
        ("one_panda", "panel", ["X1"]),
    ],
)
def test_devices_of_a_panel_that_lies_askew_are_located(name, panel, components):
    cell = unlabelled(name, panel)
    cell.plant.move_panel(0.006, -0.007, math.radians(1.2))
    for component in components:
        cell.plant.move_component(component, 0.0003, 0.0006, 0.004)
        found = locate(cell, component)
        true = cell.plant.world_from_component(component)
        assert np.linalg.norm(found.component_pose.position - true.position) < WITHIN_M
        assert abs(found.component_pose.yaw - true.yaw) < WITHIN_RAD
        assert found.residual < 0.0003
    cell.close()


@pytest.fixture
def cell():
    made = unlabelled("one_panda", "panel")
    yield made
    made.close()


def test_openings_are_checked_without_labels(cell):
    (wire, *_) = cell.context.panel.wires
    component, terminal = wire.goes_to(WireEnd.A)
    goal = CheckGoal(wire.id, WireEnd.A, component, terminal)
    assert not do.do(cell, check_connection, goal).connected


@pytest.mark.slow
def test_a_device_that_is_gone_is_reported(cell):
    # The panel is in its place, and the device under it.
    cell.plant.world.bullet.removeBody(cell.plant._scene.body_of("X1"))
    with pytest.raises(AbilityError) as caught:
        locate(cell, "X1")
    assert caught.value.code is Code.COMPONENT_NOT_FOUND
    assert "outline with the screws of 'X1'" in str(caught.value)


def test_a_panel_that_is_not_in_its_place_is_reported(cell):
    cell.plant.move_panel(0.04, 0.0, 0.0)
    with pytest.raises(AbilityError) as caught:
        locate(cell, "X1")
    assert caught.value.code is Code.COMPONENT_NOT_FOUND
    assert "within 12 mm and 3 deg of its place" in str(caught.value)
