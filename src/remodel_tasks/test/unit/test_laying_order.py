"""The order in which wires are led into ducts, and the ends at which they begin."""

from __future__ import annotations

from remodel_tasks.core.orders.board_order import first_ends, laying_turns
from remodel_tasks.core.problem.problem import End

UPPER, LOWER, CORNER_X = 300, 100, 500


def path(upper_x: int, lower_x: int) -> list[tuple[int, int]]:
    """Return a path from a terminal above the upper duct to one below the lower duct."""
    return [
        (upper_x, UPPER + 60),
        (upper_x, UPPER),
        (CORNER_X, UPPER),
        (CORNER_X, LOWER),
        (lower_x, LOWER),
        (lower_x, LOWER - 60),
    ]


def test_all_wires_begin_on_the_side_whose_shortest_leg_is_longer():
    paths = {"near": path(450, 300), "far": path(0, 400)}
    assert first_ends(paths) == {"near": End.B, "far": End.B}, "50 mm above, 100 mm below"
    assert first_ends({"far": paths["far"]}) == {"far": End.A}


def test_a_wire_that_passes_no_duct_begins_at_end_a_and_has_no_turn():
    paths = {"near": path(450, 300), "direct": [(0, 0), (100, 0)]}
    first = first_ends(paths)
    assert first == {"near": End.B, "direct": End.A}
    assert laying_turns(paths, first) == {"near": 0}


def test_a_wire_that_ends_farther_in_is_led_before_those_whose_loops_it_would_pass():
    paths = {"middle": path(0, 300), "inner": path(10, 200), "outer": path(20, 400)}
    turns = laying_turns(paths, dict.fromkeys(paths, End.A))
    assert sorted(turns, key=turns.__getitem__) == ["inner", "middle", "outer"]


def test_a_wire_is_not_taken_where_a_loop_stands_beside_its_slot():
    paths = {"begins": path(200, 400), "ends": path(210, 300)}
    turns = laying_turns(paths, {"begins": End.A, "ends": End.B})
    assert turns["begins"] < turns["ends"]


def test_wires_in_no_ones_way_have_one_turn():
    other = [(-x, y) for x, y in path(0, 300)]
    assert laying_turns({"one": path(0, 300), "two": other}, {"one": End.A, "two": End.A}) == {
        "one": 0,
        "two": 0,
    }


def test_wires_in_each_others_way_are_led_all_the_same():
    paths = {"down": path(100, 300), "up": path(200, 200), "free": path(50, 50)}
    turns = laying_turns(paths, {"down": End.A, "up": End.B, "free": End.A})
    assert len(set(turns.values())) == len(paths)
