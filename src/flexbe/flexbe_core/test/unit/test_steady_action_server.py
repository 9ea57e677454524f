"""An action server whose node ends while goals arrive."""

import actionlib
import pytest
import rospy

from flexbe_core.ros.master import SteadyActionServer


@pytest.mark.parametrize("callback", ["internal_goal_callback", "internal_cancel_callback"])
def test_what_arrives_while_ros_closes_the_topics_is_dropped_without_an_error(
    callback, monkeypatch
):
    def answer(_server, _message):
        raise rospy.ROSException("topic was closed during publish()")

    monkeypatch.setattr(actionlib.ActionServer, callback, answer)
    server = object.__new__(SteadyActionServer)
    monkeypatch.setattr(rospy.core, "is_shutdown_requested", lambda: True)
    getattr(server, callback)(None)
    monkeypatch.setattr(rospy.core, "is_shutdown_requested", lambda: False)
    with pytest.raises(rospy.ROSException, match="closed"):
        getattr(server, callback)(None)
