"""What is tried against failures, and which of it helps."""

from remodel_rehearsal.core.changes import changes_within, to_check, with_changes
from remodel_rehearsal.core.forecast import forecast
from remodel_run.rehearsal import Failure, Trial
from remodel_tasks.core.use_case.bounds import Bounds

JAMMED = Failure("InsertCable", "INSERTION_JAMMED", "stopped 4 mm deep")


def trials(wire, good, bad):
    return [
        Trial(wire, seed, True, 1, () if seed < good else (JAMMED,)) for seed in range(good + bad)
    ]


def test_forces_at_both_bounds_are_tried_but_not_the_one_that_failed():
    changes = changes_within({"force_limit": Bounds(14.0, 8.0, 20.0, 7)})
    assert [each.force_n for each in changes if each.force_n] == [8.0, 20.0]
    assert [each.force_n for each in changes_within({})] == [0.0, 0.0]


def test_the_most_doubtful_wires_are_to_check_first():
    names = ("W1", "W2", "W3", "W4", "W5")
    of = {"W1": (9, 1), "W2": (2, 8), "W3": (10, 0), "W4": (6, 4), "W5": (5, 5)}
    found = forecast(names, [t for name, counts in of.items() for t in trials(name, *counts)])
    assert to_check(found) == ("W2", "W5", "W4")


def test_a_wire_that_never_fails_is_not_to_check():
    assert to_check(forecast(("W1",), trials("W1", 3, 0))) == ()


def test_the_best_change_comes_first():
    found = forecast(("W1", "W2"), trials("W1", 1, 3) + trials("W2", 4, 0))
    tried = {("W1", "longer"): trials("W1", 1, 3), ("W1", "20 N"): trials("W1", 4, 0)}
    first, second = with_changes(found, tried).wires
    assert [each.text for each in first.changes] == ["20 N", "longer"]
    assert first.changes[0].at_once.mean > first.at_once.mean == first.changes[1].at_once.mean
    assert second.changes == ()
