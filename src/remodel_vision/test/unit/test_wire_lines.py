"""The pieces of a wire in a picture, put together."""

import math
from dataclasses import replace

import numpy as np
import pytest
from drawn import bow, boxes_of, picture, tip_of
from panels import panel

from remodel_states.core.wires import WIRE_RGB
from remodel_vision.laid_wire import WireLines, follow, joined, wire_around, wire_past
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Pose

OVERHEAD = read_cell().overheads[0]
WIRE = panel().wire("W1")
WIDTH = 5.0
RIGHT = np.array([1.0, 0.0])


def straight(start, end):
    return np.linspace(start, end, 60)


def arc(centre, radius, first, last):
    angle = np.linspace(first, last, 80)
    return centre + radius * np.column_stack([np.cos(angle), np.sin(angle)])


def test_the_detector_searches_for_every_colour_of_the_wire():
    lines = WireLines(None, replace(panel().wires[0], colour="WHBU"))
    expected = [255 * np.array(WIRE_RGB[code]) for code in ("WH", "BU")]
    np.testing.assert_allclose(lines.colours, expected)


def test_pieces_that_something_hides_in_between_are_put_together():
    pieces = [straight((20, 100), (80, 100)), straight((220, 100), (130, 100))]
    line = follow(pieces, np.array([15.0, 100.0]), RIGHT, WIDTH, longest=1000)
    np.testing.assert_allclose(line[[0, -1]], [[15, 100], [220, 100]])
    np.testing.assert_allclose(line[:, 1], 100)
    assert np.linalg.norm(np.diff(line, axis=0), axis=1).max() < WIDTH


def test_the_piece_comes_next_to_which_the_wire_bends_least():
    first = straight((20, 100), (100, 100))
    onward = arc(np.array([130.0, 300.0]), 200, -math.pi / 2, -0.2)
    across = straight((120, 40), (120, 95))
    for pieces in ([first, across, onward], [onward[::-1], first[::-1], across[::-1]]):
        line = follow(pieces, np.array([15.0, 100.0]), RIGHT, WIDTH, longest=1000)
        np.testing.assert_allclose(line[-1], onward[-1])


def test_a_wire_is_not_followed_backwards_nor_over_a_wide_gap():
    start = np.array([15.0, 100.0])
    behind = straight((0, 100), (-90, 100))
    far = straight((15 + 30 * WIDTH, 100), (15 + 50 * WIDTH, 100))
    assert len(follow([behind, far], start, RIGHT, WIDTH, longest=1000)) == 1


def test_a_line_is_no_longer_than_the_wire():
    piece = straight((20, 100), (400, 100))
    line = follow([piece], np.array([15.0, 100.0]), RIGHT, WIDTH, longest=200)
    assert 190 < line[-1, 0] - 15 <= 200


def test_lines_from_both_ends_are_joined_where_the_whole_is_as_long_as_the_wire():
    first, last = straight((0, 0), (120, 0)), straight((200, 0), (100, 0))
    line = joined(first, last, WIDTH, longest=200)
    assert np.linalg.norm(np.diff(line, axis=0), axis=1).sum() == pytest.approx(200, abs=2)
    np.testing.assert_allclose(line[[0, -1]], [[0, 0], [200, 0]])
    assert joined(first, last + np.array([0, 40]), WIDTH, longest=200) is None


@pytest.fixture
def fed():
    """A wire in its channel: a picture of it from above, and its nodes (n, 3), from end a on."""
    nodes = bow(WIRE)
    return picture(OVERHEAD, boxes_of(panel()), [(WIRE, nodes)]), nodes


def place_on(nodes, index):
    """Return a place on a wire, x along it."""
    along = nodes[index + 1] - nodes[index]
    middle = (nodes[index + 1] + nodes[index]) / 2
    return Pose.level(*middle, math.atan2(along[1], along[0]))


def test_how_a_wire_passes_a_place_is_seen_from_above(fed):
    seen, nodes = fed
    lines = WireLines(seen, WIRE)
    on_it = place_on(nodes, len(nodes) // 2)
    for aside in (0.0, 0.004, -0.006):
        place = Pose(on_it.apply(np.array([[0.0, -aside, 0.0]]))[0], on_it.quaternion)
        passing = wire_past(place, 0.012, lines)
        assert passing.aside == pytest.approx(aside, abs=0.001)
        assert passing.height == pytest.approx(on_it.position[2], abs=0.0015)
    beside = Pose(on_it.apply(np.array([[0.0, 0.03, 0.0]]))[0], on_it.quaternion)
    assert wire_past(beside, 0.012, lines) is None


def test_a_wire_of_another_colour_is_not_taken_for_it(fed):
    seen, nodes = fed
    other = replace(WIRE, colour="RD")
    lines = WireLines(seen, other)
    assert wire_past(place_on(nodes, len(nodes) // 2), 0.012, lines) is None


def test_where_a_wire_leaves_a_circle_is_seen_from_above(fed):
    seen, nodes = fed
    lines = WireLines(seen, WIRE)
    middle = len(nodes) // 2
    centre, there = nodes[middle, :2], nodes[middle + 2, :2]
    radius = float(np.linalg.norm(there - centre))
    towards = math.atan2(*(there - centre)[::-1])
    for turned in (0.0, 0.3, -0.4):
        found = wire_around(centre, radius, towards - turned, lines)
        assert found == pytest.approx(turned, abs=math.radians(3))
    assert wire_around(centre + np.array([0.1, 0.0]), radius / 2, 0.0, lines) is None


def test_a_wire_is_followed_under_another_one_that_lies_across(fed):
    _, nodes = fed
    middle = len(nodes) // 2
    along = np.linspace(-0.05, 0.05, 5)[:, None]
    across = nodes[middle] + np.array([0.0, 0.0, 0.006]) + along * np.array([1.0, 0.0, 0.0])
    black = replace(WIRE, diameter=0.005, colour="BK", ferrule_length=0.0)
    seen = picture(OVERHEAD, boxes_of(panel()), [(WIRE, nodes), (black, across)])
    lines = WireLines(seen, WIRE)
    tip, out = tip_of(nodes)
    tail = tip - WIRE.ferrule_length * out
    pixels = seen.view.project(np.array([tail, tail - 0.01 * out]))
    heading = (pixels[1] - pixels[0]) / np.linalg.norm(pixels[1] - pixels[0])
    line = follow(lines.pieces, pixels[0], heading, lines.width, lines.length)
    found = OVERHEAD.on_plane(line, WIRE.radius)[:, :2]
    beyond = nodes[middle + 1 : -3, :2]
    away = np.linalg.norm(beyond[:, None] - found[None], axis=2).min(axis=1)
    assert away.max() < 0.003
