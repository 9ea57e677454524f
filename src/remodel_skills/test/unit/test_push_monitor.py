"""When a wire gives way at the bottom; forces as the cell has felt them [N]."""

import pytest
from scripted_device import PARAMETERS

from remodel_skills.primitives.pushing import PushMonitor

FREE = (0.6, 0.7, 0.7)
HANGING = (9.1, 19.7, 7.7, 5.0)


def gives_way_after(before, near, buckles=True):
    """Return how many forces near the bottom show that it gives way; None if it does not."""
    monitor = PushMonitor(buckles, PARAMETERS.wire)
    for force in before:
        monitor = monitor.then(force, near_bottom=False)
    assert not monitor.gave_way
    for count, force in enumerate(near, 1):
        monitor = monitor.then(force, near_bottom=True)
        if monitor.gave_way:
            return count
    return None


@pytest.mark.parametrize(
    ("before", "near", "count"),
    [
        (FREE, (2.6, 4.7, 6.4, 7.6, 8.1), None),  # the bottom, met under force control
        (FREE, (5.6, 6.4, 6.0, 5.6, 5.5), 4),  # a wire that buckles there
        (FREE, (2.1, 1.4, 1.2), None),  # one that rubs
        (FREE, (5.6, 6.4, 7.0), None),  # one that still resists
        (HANGING, (5.6, 5.4, 4.4, 2.3), None),  # one that is bent before the opening
    ],
)
def test_a_wire_gives_way_where_the_force_at_the_bottom_was_great_and_falls(before, near, count):
    assert gives_way_after(before, near) == count


def test_what_does_not_buckle_never_gives_way():
    assert gives_way_after(FREE, (12.0, 11.0, 5.0), buckles=False) is None
