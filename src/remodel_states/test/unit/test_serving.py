"""Goals that are rejected whatever the ability, and how goals end, without a ROS master."""

import pytest
from remodel_msgs.msg import DiscardCableGoal, ErrorCode

from remodel_states.edge.exported_tables import read_abilities
from remodel_states.serving import RunningGoal, why_late


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


class Handle:
    """Takes the end of a goal as actionlib's handle does."""

    def __init__(self):
        self.result = None

    def get_goal(self):
        return DiscardCableGoal(id="1:W1", timeout=10.0)

    def set_aborted(self, result, text):
        self.result = result


def test_findings_of_an_ability_that_this_one_made_use_of_are_left_out():
    handle = Handle()
    RunningGoal(read_abilities()["DiscardCable"], handle, elapsed=lambda: 2.0).fail(
        ErrorCode.EXTRACTION_STUCK, "stuck at 25 N", {"peak_force": 25.0}
    )
    assert handle.result.error_code == ErrorCode.EXTRACTION_STUCK
    assert handle.result.error_message == "stuck at 25 N"
    assert handle.result.elapsed_time == 2.0
