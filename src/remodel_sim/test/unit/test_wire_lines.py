"""The order's wire in pictures of the simulator, and the pieces of it put together."""

import math
from dataclasses import replace

import numpy as np
import pytest
from panels import panel

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.wires.parked_wire import draw_parked
from remodel_skills.cell import Cell
from remodel_vision.laid_wire import wire_around, wire_past
from remodel_vision.wire_lines import WireLines, follow
from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd


@pytest.fixture
def fed():
    """A cell whose wire lies in its channel, and points along it, (n, 3), from end a on."""
    made = Cell(SimulatedPlant(panel(), seed=1))
    made.feed("W1", "A")
    nodes = made.plant.live.cable.nodes()
    towards = made.plant.live.cable.tip(WireEnd.A)[0]
    ordered = np.linalg.norm(nodes[0] - towards) < np.linalg.norm(nodes[-1] - towards)
    yield made, nodes if ordered else nodes[::-1]
    made.close()


def place_on(nodes, index):
    """Return a place on a wire, x along it."""
    along = nodes[index + 1] - nodes[index]
    middle = (nodes[index + 1] + nodes[index]) / 2
    return Pose.level(*middle, math.atan2(along[1], along[0]))


@pytest.mark.physics
def test_how_a_wire_passes_a_place_is_seen_from_above(fed):
    cell, nodes = fed
    lines = WireLines(cell.plant.take_overhead_picture(), cell.context.wire)
    on_it = place_on(nodes, len(nodes) // 2)
    for aside in (0.0, 0.004, -0.006):
        place = Pose(on_it.apply(np.array([[0.0, -aside, 0.0]]))[0], on_it.quaternion)
        passing = wire_past(place, 0.012, lines)
        assert passing.aside == pytest.approx(aside, abs=0.001)
        assert passing.height == pytest.approx(on_it.position[2], abs=0.0015)
    beside = Pose(on_it.apply(np.array([[0.0, 0.03, 0.0]]))[0], on_it.quaternion)
    assert wire_past(beside, 0.012, lines) is None


@pytest.mark.physics
def test_a_wire_of_another_colour_is_not_taken_for_it(fed):
    cell, nodes = fed
    other = replace(cell.context.wire, colour="RD")
    lines = WireLines(cell.plant.take_overhead_picture(), other)
    assert wire_past(place_on(nodes, len(nodes) // 2), 0.012, lines) is None


@pytest.mark.physics
def test_where_a_wire_leaves_a_circle_is_seen_from_above(fed):
    cell, nodes = fed
    lines = WireLines(cell.plant.take_overhead_picture(), cell.context.wire)
    middle = len(nodes) // 2
    centre, there = nodes[middle, :2], nodes[middle + 2, :2]
    radius = float(np.linalg.norm(there - centre))
    towards = math.atan2(*(there - centre)[::-1])
    for turned in (0.0, 0.3, -0.4):
        found = wire_around(centre, radius, towards - turned, lines)
        assert found == pytest.approx(turned, abs=math.radians(3))
    assert wire_around(centre + np.array([0.1, 0.0]), radius / 2, 0.0, lines) is None


@pytest.mark.physics
def test_a_wire_is_followed_under_another_one_that_lies_across(fed):
    cell, nodes = fed
    middle = len(nodes) // 2
    along = np.linspace(-0.05, 0.05, 5)[:, None]
    across = nodes[middle] + np.array([0.0, 0.0, 0.006]) + along * np.array([1.0, 0.0, 0.0])
    draw_parked(cell.plant.world, across, replace(cell.context.wire, diameter=0.005, colour="BK"))
    picture = cell.plant.take_overhead_picture()
    lines = WireLines(picture, cell.context.wire)
    tip, out = cell.plant.live.cable.tip(WireEnd.A)
    tail = tip - cell.context.wire.ferrule_length * out
    pixels = picture.view.project(np.array([tail, tail - 0.01 * out]))
    heading = (pixels[1] - pixels[0]) / np.linalg.norm(pixels[1] - pixels[0])
    line = follow(lines.pieces, pixels[0], heading, lines.width, lines.length)
    seen = picture.view.on_plane(line, cell.context.wire.radius)[:, :2]
    beyond = nodes[middle + 1 : -3, :2]
    away = np.linalg.norm(beyond[:, None] - seen[None], axis=2).min(axis=1)
    assert away.max() < 0.003
