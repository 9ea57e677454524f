"""However changes arrive, the copy is the supervisor's list, or is known not to be."""

from dataclasses import replace
from random import Random

import pytest

from remodel_console.core.use_case import Changes, Failure, Snapshot, Task, TaskCopy
from remodel_run.progress import TaskPhase

SERIES = 17


def task(name, phase=TaskPhase.WAITING, attempts=0):
    return Task(name, "", phase, attempts, first_pass=False, taken_s=0.0, expected_s=0.0)


FAILURE = Failure(1.0, "W1", "slipped", 0, "", "", "retry", because="")


def changes(number, *tasks, series=SERIES, replanned=False, failures=()):
    return Changes(series, number, tasks, failures, replanned=replanned)


START = Snapshot(SERIES, 3, (task("W1"), task("W2"), task("W3")), ())
COPY = TaskCopy().with_snapshot(START)


def attempts(copy):
    return [each.attempts for each in copy.tasks.values()]


def test_changes_continue_a_snapshot():
    assert TaskCopy().needs_snapshot(SERIES)
    assert not COPY.needs_snapshot(SERIES)
    copy = COPY.with_changes(changes(4, task("W2", attempts=1), failures=(FAILURE,)))
    assert (copy.number, attempts(copy), copy.failures) == (4, [0, 1, 0], (FAILURE,))
    assert copy.with_changes(changes(4, task("W2", attempts=9))) is copy


def test_a_gap_is_noticed_and_closed_by_a_snapshot():
    copy = COPY.with_changes(changes(5, task("W2", attempts=5)))
    assert copy.needs_snapshot(SERIES)
    assert attempts(copy) == [0, 0, 0]
    copy = copy.with_snapshot(replace(START, number=4))
    assert not copy.needs_snapshot(SERIES)
    assert (copy.number, attempts(copy)) == (5, [0, 5, 0])


def test_what_arrives_before_the_snapshot_is_not_lost():
    copy = TaskCopy()
    for number in (3, 4, 5):
        copy = copy.with_changes(changes(number, task("W1", attempts=number)))
    copy = copy.with_snapshot(START)
    assert (copy.number, attempts(copy)) == (5, [5, 0, 0])


def test_another_order_of_the_tasks_needs_a_snapshot_that_is_not_older():
    copy = COPY.with_changes(changes(4, task("W1", attempts=1), replanned=True))
    assert copy.needs_snapshot(SERIES)
    assert copy.with_snapshot(START).needs_snapshot(SERIES)
    other = Snapshot(SERIES, 4, tuple(reversed(START.tasks)), ())
    copy = copy.with_snapshot(other)
    assert not copy.needs_snapshot(SERIES)
    assert list(copy.tasks) == ["W3", "W2", "W1"]


def test_a_resumed_run_begins_another_series():
    assert COPY.needs_snapshot(18)
    assert not COPY.needs_snapshot(0)
    copy = COPY.with_changes(changes(1, task("W1", attempts=7), series=18))
    assert attempts(copy) == [0, 0, 0]
    copy = copy.with_snapshot(Snapshot(18, 0, START.tasks, ()))
    assert (copy.number, attempts(copy)) == (1, [7, 0, 0])


def test_tasks_that_have_ended_come_first():
    copy = COPY.with_changes(changes(4, task("W3", TaskPhase.DONE), task("W2", TaskPhase.RUNNING)))
    assert [each.name for each in copy.in_order] == ["W3", "W1", "W2"]


@pytest.mark.parametrize("seed", range(50))
def test_loss_delay_and_snapshots_at_any_moment(seed):
    """A copy that needs no snapshot and has the last number has the supervisor's tasks."""
    random = Random(seed)
    truth, number, copy, in_flight = dict(COPY.tasks), 3, COPY, []
    for _ in range(200):
        name = random.choice(list(truth))
        truth[name] = replace(truth[name], attempts=truth[name].attempts + 1)
        number += 1
        if random.random() < 0.9:  # else it is lost
            copy = copy.with_changes(changes(number, truth[name]))
        if random.random() < 0.2:
            in_flight.append(Snapshot(SERIES, number, tuple(truth.values()), ()))
        if in_flight and random.random() < 0.3:
            copy = copy.with_snapshot(in_flight.pop(0))
        if copy.number == number and not copy.needs_snapshot(SERIES):
            assert dict(copy.tasks) == truth
    copy = copy.with_snapshot(Snapshot(SERIES, number, tuple(truth.values()), ()))
    assert not copy.needs_snapshot(SERIES)
    assert dict(copy.tasks) == truth
