"""A state machine that ROS can reach."""

from __future__ import annotations

import time
from collections.abc import Callable

import rospy

from flexbe_core.core.state import State
from flexbe_core.core.state_machine import StateMachine
from flexbe_core.engine.definitions import definitions_below
from flexbe_core.proxy.proxy_publisher import ProxyPublisher
from flexbe_core.proxy.proxy_subscriber_cached import ProxySubscriberCached
from flexbe_core.ros.session import run_session

# [s] Wall time between two checks of the condition of `wait`.
_CHECK_EVERY_S = 0.01


class RosStateMachine(StateMachine):
    """A state machine with proxies, and commands from operators."""

    _pub = ProxyPublisher()
    _sub = ProxySubscriberCached()

    def wait(
        self, seconds: float | None = None, condition: Callable[[], bool] | None = None
    ) -> None:
        """Sleep for a while [s, ROS time], then until the condition holds or ROS is shut down."""
        if seconds is not None:
            rospy.sleep(seconds)
        while condition is not None and not condition() and not rospy.is_shutdown():
            time.sleep(_CHECK_EVERY_S)

    def set_parent(self, value: State) -> None:
        """Put the container into another one, whose run takes the commands from now on."""
        super().set_parent(value)
        if any(definition._is_controlled for definition in definitions_below(self)):
            run_session(self).listen()

    def _enable_ros_control(self) -> None:
        """Let operators supervise the container and everything in it."""
        super()._enable_ros_control()
        run_session(self).listen()
        for state in self._supervised_children():
            state._enable_ros_control()

    def _disable_ros_control(self) -> None:
        """Let the container and everything in it run by itself."""
        super()._disable_ros_control()
        for state in self._states:
            state._disable_ros_control()

    def _supervised_children(self) -> list[State]:
        return self._states
