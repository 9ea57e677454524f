"""Another view observes from elsewhere, and sees past what hides a thing from the usual places."""

import math

import numpy as np
import place_wire as do
import pytest
from panels import panel

from remodel_sim.physics.plant import SimulatedPlant
from remodel_skills.abilities.inspection import LocateGoal, locate_gearbox_component
from remodel_skills.abilities.picking import DetectGoal, detect_cable
from remodel_skills.cell import Cell
from remodel_skills.robot_context import Observers
from remodel_states.core.codes import Code
from remodel_work.component_shape import Box, label_corners
from remodel_work.edge.bullet import add_static
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd

pytestmark = pytest.mark.physics

# A lens that is nearer to another one than this observes from the same place [m].
APART_M = 0.02
GREY = (0.5, 0.5, 0.5)
# Far more than openings may be tilted [rad].
LEAN_RAD = math.radians(4.0)


@pytest.fixture
def places():
    """Where the wrist camera's pictures were taken."""
    return []


@pytest.fixture
def cell(places):
    def note(camera, picture, drawing):
        if camera == "wrist" and drawing is None:
            places.append(picture.view.world_from_camera.position)

    made = Cell(SimulatedPlant(panel(), seed=1), observers=Observers(on_observation=note))
    yield made
    made.close()


def locate(cell, view):
    return do.do(cell, locate_gearbox_component, LocateGoal("X1", "1", view))


def detect(cell, view):
    return do.do(cell, detect_cable, DetectGoal("W1", view))


def taken(places, action):
    places.clear()
    action()
    return np.array(places)


def nearest(first, second):
    return np.linalg.norm(first[:, None] - second[None, :], axis=2).min()


def hang_cross(cell, above, z, arm, width):
    """Hang a cross over a point where it hides what is below from straight above and along x, y."""
    sizes = ((arm, width, 0.002), (width, arm, 0.002))
    boxes = [Box((0.0, 0.0, 0.0), size, GREY, solid=False) for size in sizes]
    x, y = (float(v) for v in above[:2])
    add_static(cell.plant.world.bullet, boxes, Pose.level(x, y, z))


@pytest.mark.slow
def test_each_view_of_a_component_is_taken_from_elsewhere(cell, places):
    usual, other, third, again = (taken(places, lambda v=v: locate(cell, v)) for v in range(4))
    assert len(usual) == len(other) == len(third) == 2
    assert min(nearest(usual, other), nearest(usual, third), nearest(other, third)) > APART_M
    assert nearest(usual, again) < 1e-3, "three views: the fourth is the first again"


@pytest.mark.slow
def test_a_label_hidden_from_the_usual_places_is_located_from_another_view(cell):
    component = cell.context.panel.component("X1")
    world_from_component = cell.plant.world_from_component("X1")
    label = world_from_component.apply(label_corners(component)).mean(axis=0)
    hang_cross(cell, label, 0.13, 0.08, width=0.014)
    with pytest.raises(AbilityError) as caught:
        locate(cell, 0)
    assert caught.value.code in (Code.COMPONENT_NOT_FOUND, Code.COMPONENT_OCCLUDED)
    found = locate(cell, 1)
    away = found.component_pose.position - world_from_component.position
    assert np.linalg.norm(away) < 0.001


def test_a_component_whose_openings_are_tilted_is_reported_and_not_inserted_into(cell):
    lean = np.array([0.0, math.sin(LEAN_RAD / 2), 0.0, math.cos(LEAN_RAD / 2)])
    leaning = cell.plant.world_from_component("X1") @ Pose(np.zeros(3), lean)
    cell.plant._scene.place_component("X1", leaning)
    with pytest.raises(AbilityError, match=r"'X1' leans: .* tilted by -?[345]\.\d deg") as caught:
        locate(cell, 0)
    assert caught.value.code is Code.COMPONENT_DISPLACED


@pytest.mark.slow
def test_each_view_of_a_cable_is_taken_from_elsewhere(cell, places):
    cell.feed("W1", "A")
    assert len(taken(places, lambda: detect(cell, 0))) == 0, "both ends are seen from above"
    first, second = (taken(places, lambda v=v: detect(cell, v)) for v in (1, 2))
    assert len(first) >= 2 and len(second) >= 2
    assert nearest(first, second) > APART_M


def test_ends_hidden_from_above_are_detected_from_another_view(cell):
    cell.feed("W1", "A")
    for end in WireEnd:
        tip = cell.plant.live.cable.tip(end)[0]
        hang_cross(cell, tip, 0.15, 0.10, width=0.04)
    with pytest.raises(AbilityError) as caught:
        detect(cell, 0)
    assert caught.value.code is Code.CABLE_NOT_FOUND
    found = detect(cell, 1)
    for end, seen in zip(WireEnd, found.tips, strict=True):
        assert np.linalg.norm(seen.tip - cell.plant.live.cable.tip(end)[0]) < 0.003
    assert found.length > 0.05
