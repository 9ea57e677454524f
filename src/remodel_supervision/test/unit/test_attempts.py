"""The attempts of a run, read from its events."""

from dataclasses import replace

import pytest

from remodel_supervision.core.runs.event_table import attempts_of
from remodel_supervision.core.runs.events import Interrupted, Part, Settled, TaskBegun, TaskEnded

BEGUN = TaskBegun("W1", 1, Part.WHOLE, "Place Wire W1", chart="", at_s=1.0)
# Both ends are fixed, but the wire lies outside its ducts.
FAILED = TaskEnded("W1", "failed", 2.0, placed=True)


def discarding(outcome):
    begun = replace(BEGUN, part=Part.DISCARD, at_s=3.0)
    return begun, TaskEnded("W1", outcome, 4.0, placed=outcome != "finished")


def test_what_is_fixed_at_both_ends_counts_as_placed_until_it_is_discarded():
    (before,) = attempts_of([BEGUN, FAILED])
    assert before.execution.placed
    after = attempts_of([BEGUN, FAILED, *discarding("finished")])
    assert [each.execution.placed for each in after] == [False, False]


def test_what_another_attempt_placed_stays_placed():
    again = [replace(BEGUN, attempt=2, at_s=5.0), TaskEnded("W1", "finished", 6.0, placed=True)]
    other = [replace(BEGUN, task="W2", at_s=0.0), replace(FAILED, task="W2")]
    events = [*other, BEGUN, FAILED, *discarding("finished"), *again]
    placed = [each.execution.placed for each in attempts_of(events)]
    assert placed == [True, False, False, True]


@pytest.mark.parametrize("outcome", ["failed", "preempted"])
def test_what_was_not_discarded_is_still_placed(outcome):
    attempt, _ = attempts_of([BEGUN, FAILED, *discarding(outcome)])
    assert attempt.execution.placed


def test_what_came_apart_in_a_failed_discarding_does_not_count_as_placed():
    begun, _ = discarding("failed")
    apart = TaskEnded("W1", "failed", 4.0, placed=False, denied=True)
    attempts = attempts_of([BEGUN, FAILED, begun, apart])
    assert [each.execution.placed for each in attempts] == [False, False]


@pytest.mark.parametrize(
    ("is_placed", "settled", "found"),
    [(False, (), False), (True, (), True), (False, (Settled("W1", ("a", "b"), 0),), True)],
)
def test_an_interrupted_attempt_counts_as_placed_when_it_is_found_so(is_placed, settled, found):
    cleared = [replace(BEGUN, part=Part.CLEAR), TaskEnded("W1", "finished", 2.0, is_placed)]
    whole, clear = attempts_of([BEGUN, Interrupted("killed"), *cleared, *settled])
    assert (whole.part, clear.part) == (Part.WHOLE, Part.CLEAR)
    assert (whole.execution.placed, clear.execution.placed) == (found, is_placed)
