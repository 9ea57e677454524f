"""Colours of wires: one code or several, the same for planner and cell."""

import pytest

from remodel_states.core.wires import (
    DISTINCT_COLOURS,
    WIRE_RGB,
    hex_colours,
    is_colour,
    joined_colours,
    nearest_code,
    rgbs_of,
)


@pytest.mark.parametrize(
    ("codes", "colour"),
    [
        (["BU"], "BU"),
        (["WH", "BU"], "WHBU"),
        (["BU", "WH"], "BUWH"),
        (["GN", "YE"], "GNYE"),
        (["YE", "GN"], "GNYE"),
        (["BK", "BK"], "BK"),
    ],
)
def test_the_colours_of_a_wire_are_joined(codes, colour):
    assert joined_colours(codes) == colour
    assert is_colour(colour)


def test_a_wire_of_two_colours_looks_like_both_the_ground_first():
    assert rgbs_of("WHBU") == (WIRE_RGB["WH"], WIRE_RGB["BU"])
    assert hex_colours("BKRD") == ("#0f0f12", "#cc0f0d")


@pytest.mark.parametrize("colour", ["", "XX", "B", "WHB", "WHXX"])
def test_what_is_no_colour_is_none_and_has_a_grey_swatch(colour):
    assert not is_colour(colour)
    assert "#808080" in hex_colours(colour)


def test_the_nearest_colour_of_each_is_itself_and_of_a_screens_colours_what_a_person_calls_them():
    single = [code for code in DISTINCT_COLOURS if code in WIRE_RGB]
    assert [nearest_code(WIRE_RGB[code]) for code in single] == single
    screen = {(1, 1, 0): "YE", (0, 0, 1): "BU", (0, 1, 1): "TQ", (1, 0.5, 0): "OG"}
    assert {rgb: nearest_code(rgb) for rgb in screen} == screen
