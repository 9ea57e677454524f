"""What a supervisor takes a cell's answers for."""

import pytest
import rospy
from remodel_msgs.msg import ErrorCode
from remodel_msgs.srv import FeedWireResponse

from remodel_supervision.ros.peers.cell import Cell


@pytest.mark.parametrize(
    ("code", "rests"),
    [
        (ErrorCode.NONE, True),
        (ErrorCode.UNKNOWN_NAME, True),  # a cell that takes a request without a wire for a mistake
        (ErrorCode.STALE_OWNER, True),
        (ErrorCode.BUSY, False),
        (ErrorCode.INTERNAL, False),  # such as a request that was not answered in time
    ],
)
def test_a_cell_that_is_busy_or_has_an_error_of_its_own_is_asked_again(monkeypatch, code, rests):
    asked = []

    def call(**request):
        asked.append(request)
        return FeedWireResponse(code == ErrorCode.NONE, "", code)

    monkeypatch.setattr(rospy, "ServiceProxy", lambda name, kind: call)
    assert Cell().take_over(7) is rests
    assert asked == [{"wire_id": "", "owner": 7}]
