"""Goals that are rejected whatever the ability."""

import pytest

from remodel_states.serving import why_late


@pytest.mark.parametrize(
    ("sent_s", "timeout_s", "is_late"),
    [
        (1000.0, 60.0, False),
        (994.5, 60.0, False),
        (993.9, 60.0, True),
        (996.9, 2.0, True),
        (1005.0, 2.0, False),  # by a clock that is ahead, or after a jump back
        (0.0, 60.0, False),  # by a client that gives no time
    ],
)
def test_a_goal_that_its_client_has_given_up_is_late(sent_s, timeout_s, is_late):
    assert bool(why_late(sent_s, 1000.0, timeout_s)) == is_late


def test_the_reason_states_how_late_and_what_to_do():
    reason = why_late(940.0, 1000.0, 60.0)
    assert reason.startswith("sent 60.0 s ago, so its client has given it up; allowed: 6 s")
    assert "clocks of the two machines differ" in reason
