"""How goals end, without a ROS master."""

from remodel_msgs.msg import DiscardCableGoal, ErrorCode

from remodel_states.edge.exported_tables import read_abilities
from remodel_states.serving import RunningGoal


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
