"""A board that several cameras see from above: on scripted devices, in drawn pictures."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from drawn import along
from panels import component, example, moved_onto, panel
from scripted_device import ScriptedPlant

from remodel_skills.abilities.inspection import LocateGoal, locate_gearbox_component
from remodel_skills.belief_state import NO_CHANNEL, BeliefState, Feed
from remodel_skills.cell import Cell
from remodel_skills.primitives.observation.checks import inspect_ducts
from remodel_skills.robot_context import Cameras, Observers
from remodel_vision.panel_pose import register_panel
from remodel_vision.standing import new_length, standing_wires
from remodel_work.camera import Picture, are_nearest, best_view
from remodel_work.edge.cell_file import read_cell
from remodel_work.obstacles import panel_obstacles
from remodel_work.panel import WireEnd

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


class Blank:
    """A camera whose pictures are empty."""

    def __init__(self, view):
        self.view = view

    def take(self):
        return Picture(np.zeros((1, 1, 3), np.uint8), np.zeros((1, 1)), self.view)


@pytest.fixture
def blank():
    """The cameras of the cell, whose pictures are empty, their belief and the pictures' names."""
    device = SimpleNamespace(overhead_cameras=tuple(map(Blank, DESIGN.overheads)))
    belief, names = BeliefState(), []
    observers = Observers(on_observation=lambda name, *_: names.append(name))
    return Cameras(device, "wrist", belief, observers), belief, names


def test_the_camera_that_shows_a_place_best_takes_its_picture(blank):
    cameras, _, names = blank
    views, best = DESIGN.overheads, set()
    for point in ROUTE:
        shown = cameras.take_overhead_picture(point[None]).view
        assert shown is cameras.overhead_view(point[None])
        assert shown.margin_px(point[None]) == max(v.margin_px(point[None]) for v in views) > 20.0
        best.add(views.index(shown))
    assert len(names) == len(ROUTE)
    assert [views.index(p.view) for p in cameras.take_overhead_pictures(ROUTE)] == sorted(best)
    assert 1 < len(best) < len(views)


def test_each_picture_is_published_under_its_cameras_name(blank):
    cameras, _, names = blank
    cameras.take_overhead_pictures()
    assert names == list(DESIGN.overhead_names)


def test_the_whole_board_is_remembered_once_before_the_wire_is_touched(blank):
    cameras, belief, names = blank
    belief.feed = Feed(WIRE.id, NO_CHANNEL, 1)
    first = cameras.take_overhead_picture(ROUTE[:1])
    assert sorted(names) == sorted(DESIGN.overhead_names)
    assert belief.board_before(first.view) is first
    kept = list(belief.untouched)
    again = cameras.take_overhead_picture(ROUTE[:1])
    assert [each for each in belief.untouched if each not in kept] == [again]
    belief.picked_at[WireEnd.A] = None
    cameras.take_overhead_picture(ROUTE[:1])
    assert belief.board_before(first.view) is again, "the wire is in the hand"
    assert len(belief.untouched) == len(DESIGN.overheads)
    belief.start_wire(belief.feed, {})
    assert not belief.untouched, "another wire was fed"


@pytest.mark.parametrize("height", [IN_DUCT_M, OVER_RIM_M])
def test_a_wire_is_inspected_in_the_pictures_of_several_cameras(cell, height):
    cell.context.cameras.take_overhead_pictures(ROUTE)
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
    before = cell.context.cameras.take_overhead_pictures(ROUTE)
    nodes = led(OVER_RIM_M)
    cell.plant.wires = [(WIRE, nodes)]
    pairs = list(zip(cell.context.cameras.take_overhead_pictures(ROUTE), before, strict=True))
    length = np.linalg.norm(np.diff(nodes, axis=0), axis=1).sum()
    seen = new_length(pairs, cell.plant.panel, WIRE.radius, [])
    assert seen == pytest.approx(length, rel=0.15)
    apart = [new_length([pair], cell.plant.panel, WIRE.radius, []) for pair in pairs]
    assert sum(apart) > 1.2 * length, "the pictures overlap"


def test_wires_that_stand_out_are_obstacles_wherever_a_camera_sees_them(cell):
    nodes = led(OVER_RIM_M + 0.02)
    cell.plant.wires = [(WIRE, nodes)]
    held = cell.plant.panel
    pictures = cell.context.cameras.take_overhead_pictures(ROUTE)
    places = np.array(
        [s.box.centre for s in standing_wires(pictures, held, panel_obstacles(held, {})).solids]
    )
    away = np.linalg.norm(nodes[:, None, :2] - places[None, :, :2], axis=2).min(axis=1)
    assert np.mean(away < 0.012) > 0.95


@pytest.mark.slow
def test_the_picture_that_shows_a_device_best_registers_the_panel_there(cell):
    held, views = cell.plant.panel, DESIGN.overheads
    drawn = {c: held.world_from_panel @ c.panel_from_component for c in held.components}
    best = {c: best_view(views, pose.position[None]) for c, pose in drawn.items()}
    assert len({*best.values()}) > 1
    for number in {*best.values()}:
        found = register_panel(cell.plant.take(views[number]), held)
        assert found is not None
        for device in (c for c, at in best.items() if at == number):
            place = (found @ device.panel_from_component).position
            assert np.linalg.norm(place - drawn[device].position) < REGISTERED_M


def test_cameras_divide_the_plate_between_them():
    x, y = np.meshgrid(np.linspace(0.2, 1.4, 13), np.linspace(-1, 1, 21))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    shares = [are_nearest(points, DESIGN.overheads, n) for n in range(len(DESIGN.overheads))]
    assert np.sum(shares, axis=0).tolist() == [1] * len(points)
    for view, share in zip(DESIGN.overheads, shares, strict=True):
        assert all(view.sees(point[None], 20.0) for point in points[share])


def test_a_device_longer_than_the_usual_picture_of_the_hand_is_located_by_both_its_ends():
    long = component("LONG", 1, 0.05, 0.10, side=1, terminals=12)
    long = replace(long, size=(0.050, 0.216, 0.045))
    board = panel(channels=(), wires=(), components=(long,))
    cell = Cell(ScriptedPlant(board, DESIGN))
    goal = LocateGoal("LONG", "1")
    found = cell.run(locate_gearbox_component(cell.context, goal))
    drawn = cell.plant.panel.world_from_panel @ long.panel_from_component
    assert np.linalg.norm(found.component_pose.position - drawn.position) < 0.0005
    assert abs(found.component_pose.yaw - drawn.yaw) < 0.005
