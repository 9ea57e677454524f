"""A board that several cameras see from above: on scripted devices, in drawn pictures."""

import numpy as np
import pytest
from drawn import along
from panels import example, moved_onto
from scripted_device import ScriptedPlant

from remodel_skills.belief_state import NO_CHANNEL
from remodel_skills.cell import Cell
from remodel_skills.observers import Cameras, Observers
from remodel_skills.primitives.observation.duct_check import inspect_ducts
from remodel_skills.primitives.observation.observing import observe_from_above
from remodel_vision.board.new_points import new_length
from remodel_vision.board.standing import standing_wires
from remodel_vision.panel_pose import register_panel
from remodel_work.camera import are_nearest, best_view
from remodel_work.edge.cell_file import read_cell
from remodel_work.obstacles import panel_obstacles

DESIGN = read_cell("large_cabinet")
# The household's board, with its ducts where the pictures of three cameras meet.
BOARD = moved_onto(example("household"), (1.20, 2.00), 0.0, 0.08)
WIRE = BOARD.wire("W3")
ROUTE = DESIGN.world_from_panel.apply(np.array(WIRE.route))
IN_DUCT_M, OVER_RIM_M = 0.030, 0.066
# A device is found by its shape so near to where the panel has it [m].
REGISTERED_M = 0.0015


@pytest.fixture(scope="module")
def plant():
    return ScriptedPlant(BOARD, DESIGN)


@pytest.fixture
def cell(plant):
    made = Cell(plant)
    made.load(BOARD)
    made.feed(WIRE.id, NO_CHANNEL)
    return made


def led(height):
    level = np.column_stack([ROUTE[:, :2], np.full(len(ROUTE), height)])
    return along(level, 40)


def touch(cell):
    belief = cell.context.belief
    belief.picked_at.update(dict.fromkeys(belief.ends))


def test_the_camera_that_shows_a_place_best_takes_its_picture(cell):
    touch(cell)
    views = DESIGN.overheads
    assert best_view(views, ROUTE[:1]) != best_view(views, ROUTE[2:3])
    for point in ROUTE:
        shown = cell.context.cameras.take_overhead_picture(point[None]).view
        assert shown.is_at(views[best_view(views, point[None])])
        assert shown.sees(point[None], 20.0)
    pictures = cell.context.cameras.take_overhead_pictures(ROUTE)
    assert 1 < len(pictures) < len(views)
    assert len(cell.context.cameras.take_overhead_pictures()) == len(views)


def test_each_picture_is_published_under_its_cameras_name(cell):
    names = []
    observers = Observers(on_observation=lambda name, *_: names.append(name))
    cameras = Cameras(cell.context.device, "wrist", cell.context.belief, observers)
    cameras.take_overhead_pictures()
    assert names == list(DESIGN.overhead_names)


def test_the_whole_board_is_remembered_once_before_the_wire_is_touched(cell):
    above = cell.run(observe_from_above(cell.context))
    belief = cell.context.belief
    assert len(belief.untouched) == len(DESIGN.overheads)
    assert belief.board_before(above.picture.view) is above.picture
    kept = list(belief.untouched)
    again = cell.run(observe_from_above(cell.context))
    assert [each for each in belief.untouched if each not in kept] == [again.picture]


@pytest.mark.parametrize("height", [IN_DUCT_M, OVER_RIM_M])
def test_a_wire_is_inspected_in_the_pictures_of_several_cameras(cell, height):
    cell.context.cameras.take_overhead_pictures()
    cell.plant.wires = [(WIRE, led(height))]
    touch(cell)
    found = cell.run(inspect_ducts(cell.context))
    assert len(found.seen) > 1
    assert found.share == pytest.approx(1.0 if height == IN_DUCT_M else 0.0, abs=0.1)
    views = [lines.picture.view for lines, _ in found.seen]
    for point in ROUTE:
        lines, before = found.seen_at(point)
        assert lines.picture.view.is_at(views[best_view(views, point[None])])
        assert before.view.is_at(lines.picture.view)


def test_a_wire_that_several_cameras_see_counts_once(cell):
    before = cell.context.cameras.take_overhead_pictures()
    nodes = led(OVER_RIM_M)
    cell.plant.wires = [(WIRE, nodes)]
    pairs = list(zip(cell.context.cameras.take_overhead_pictures(), before, strict=True))
    length = np.linalg.norm(np.diff(nodes, axis=0), axis=1).sum()
    seen = new_length(pairs, cell.plant.panel, WIRE.radius, [])
    assert seen == pytest.approx(length, rel=0.15)
    apart = [new_length([pair], cell.plant.panel, WIRE.radius, []) for pair in pairs]
    assert sum(apart) > 1.2 * length, "the pictures overlap"


def test_wires_that_stand_out_are_obstacles_wherever_a_camera_sees_them(cell):
    nodes = led(OVER_RIM_M + 0.02)
    cell.plant.wires = [(WIRE, nodes)]
    panel = cell.plant.panel
    pictures = cell.context.cameras.take_overhead_pictures()
    places = np.array(
        [s.box.centre for s in standing_wires(pictures, panel, panel_obstacles(panel, {})).solids]
    )
    away = np.linalg.norm(nodes[:, None, :2] - places[None, :, :2], axis=2).min(axis=1)
    assert np.mean(away < 0.012) > 0.95


def test_the_picture_that_shows_a_device_best_registers_the_panel_there(cell):
    panel, views = cell.plant.panel, DESIGN.overheads
    drawn = {c: panel.world_from_panel @ c.panel_from_component for c in panel.components}
    best = {c: best_view(views, pose.position[None]) for c, pose in drawn.items()}
    assert len({*best.values()}) > 1
    for number in {*best.values()}:
        found = register_panel(cell.plant.take(views[number]), panel)
        assert found is not None
        for component in (c for c, at in best.items() if at == number):
            place = (found @ component.panel_from_component).position
            assert np.linalg.norm(place - drawn[component].position) < REGISTERED_M


def test_cameras_divide_the_plate_between_them():
    x, y = np.meshgrid(np.linspace(0.2, 1.4, 13), np.linspace(-1, 1, 21))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    shares = [are_nearest(points, DESIGN.overheads, n) for n in range(len(DESIGN.overheads))]
    assert np.sum(shares, axis=0).tolist() == [1] * len(points)
    for view, share in zip(DESIGN.overheads, shares, strict=True):
        assert all(view.sees(point[None], 20.0) for point in points[share])
