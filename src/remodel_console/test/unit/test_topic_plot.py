"""Plots of topics: which fields are numbers, and what is kept of their values."""

import math
from types import SimpleNamespace

import pytest

from remodel_console.core.plots import (
    WINDOW_S,
    Samples,
    check_field,
    number_fields,
    number_in,
    split_plot,
)
from remodel_console.watched import TopicPlots

MESSAGES = {
    "std_msgs/Header": [("seq", "uint32"), ("stamp", "time"), ("frame_id", "string")],
    "test/Vector": [("x", "float64"), ("y", "float64")],
    "test/Sample": [
        ("header", "std_msgs/Header"),
        ("is_held", "bool"),
        ("position", "float64[]"),
        ("force", "test/Vector"),
        ("corners", "test/Vector[2]"),
        ("picture", "uint8[]"),
    ],
}
NUMBERS = (
    "header.seq",
    "is_held",
    "position[0]",
    "force.x",
    "force.y",
    "corners[0].x",
    "corners[0].y",
    "corners[1].x",
    "corners[1].y",
)


def test_the_numbers_of_a_message_are_offered_without_texts_times_and_pictures():
    assert tuple(number_fields("test/Sample", MESSAGES.__getitem__)) == NUMBERS


@pytest.mark.parametrize("field", ["force.x", "position[12]", "corners[1].y"])
def test_any_element_of_a_list_may_be_chosen(field):
    check_field(field, "test/Sample", NUMBERS)


@pytest.mark.parametrize("field", ["force", "force.z", "position", "header.frame_id", "picture[0]"])
def test_what_is_no_number_is_refused_with_what_is_there(field):
    with pytest.raises(ValueError, match=r"no number '.*'; its numbers: header.seq, .* 1 more"):
        check_field(field, "test/Sample", NUMBERS)


def test_a_plot_names_topic_and_field():
    assert split_plot("/joint_states.position[3]") == ("/joint_states", "position[3]")


@pytest.mark.parametrize("plot", ["", ".", "/a", "/a.", "a.b", "/a b.c", "/a.b;c"])
def test_what_is_no_plot_is_refused_with_the_form(plot):
    with pytest.raises(ValueError, match=r"write /TOPIC\.FIELD"):
        split_plot(plot)


def test_a_number_is_read_and_a_list_may_be_too_short():
    message = SimpleNamespace(force=SimpleNamespace(x=2), is_held=True, position=(1.5, 2.5))
    assert number_in(message, "force.x") == 2.0
    assert number_in(message, "is_held") == 1.0
    assert number_in(message, "position[1]") == 2.5
    with pytest.raises(IndexError):
        number_in(message, "position[2]")


def test_a_fast_topic_keeps_its_peaks_and_few_points():
    samples = Samples()
    for step in range(10_000):  # 100 Hz for 100 s
        samples.add(step / 100, 50.0 if step == 7_012 else math.sin(step))
    points = samples.points(100.0)
    assert len(points) <= 2 * WINDOW_S / 0.2 + 2
    assert max(points, key=lambda point: point[1]) == (-29.88, 50.0)
    assert [time for time, _ in points] == sorted(time for time, _ in points)
    assert -WINDOW_S - 0.2 <= points[0][0] < -WINDOW_S + 0.5


def test_what_is_older_than_a_minute_or_no_number_is_not_shown():
    samples = Samples()
    samples.add(0.0, 1.0)
    samples.add(1.0, math.nan)
    samples.add(2.0, math.inf)
    assert samples.points(3.0) == [(-3.0, 1.0)]
    assert samples.points(61.0) == []


def test_values_are_kept_for_what_is_chosen_and_a_problem_ends_with_the_first_value():
    plots = TopicPlots()
    plots.keep(["/a.x", "/a.y"])
    plots.report("/a.x", "no node publishes /a")
    assert plots.problem("/a.x") == "no node publishes /a"
    plots.add("/a.x", 3.0)
    plots.add("/other.x", 3.0)
    assert plots.problem("/a.x") == ""
    plots.keep(["/a.x"])
    assert [value for _, value in plots.points("/a.x")] == [3.0]
    assert plots.points("/other.x") == []
