"""When a push has met its end; forces as the cell has felt them [N]."""

import pytest

from remodel_sim.core.robot.push_monitor import PushMonitor

FREE = (0.6, 0.7, 0.7)
HANGING = (9.1, 19.7, 7.7, 5.0)


def stops_after(before, near, limit=8.0, buckles=True):
    """Return how many forces near the bottom a push takes to stop; None if it goes on."""
    monitor = PushMonitor(limit, buckles)
    for force in before:
        monitor = monitor.then(force, near_bottom=False)
    assert not monitor.stopped
    for count, force in enumerate(near, 1):
        monitor = monitor.then(force, near_bottom=True)
        if monitor.stopped:
            return count
    return None


@pytest.mark.parametrize(
    ("before", "near", "limit", "count"),
    [
        (FREE, (0.7, 9.4), 8.0, 2),  # the bottom
        (FREE, (5.6, 6.4, 6.0, 5.6, 5.5), 8.0, 4),  # a wire that buckles there
        (FREE, (2.1, 1.4, 1.2), 8.0, None),  # one that rubs
        (FREE, (5.6, 6.4, 7.0), 8.0, None),  # one that still resists
        (HANGING, (5.6, 5.4, 4.4, 2.3), 20.0, None),  # one that is bent before the opening
    ],
)
def test_a_push_ends_at_its_limit_or_when_the_wire_gives_way_at_the_bottom(
    before, near, limit, count
):
    assert stops_after(before, near, limit) == count


def test_what_does_not_buckle_is_pushed_to_the_limit():
    assert stops_after(FREE, (12.0, 11.0, 30.0), 30.0, buckles=False) == 3


def test_the_peak_is_reported_whether_it_was_before_the_bottom_or_at_it():
    monitor = PushMonitor(8.0, True).then(3.0, near_bottom=False).then(1.0, near_bottom=True)
    assert (monitor.peak, monitor.now, monitor.stopped) == (3.0, 1.0, False)
