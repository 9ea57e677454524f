"""The pieces of a wire in a picture, put together."""

import math
from dataclasses import replace

import numpy as np
import pytest
from panels import panel

from remodel_states.core.wires.wire_colours import WIRE_RGB
from remodel_vision.wire_lines import WireLines, follow, joined

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
