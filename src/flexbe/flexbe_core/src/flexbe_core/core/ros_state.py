"""A state that ROS can reach."""

from __future__ import annotations

from flexbe_core.core.state import State
from flexbe_core.engine.definitions import Rate
from flexbe_core.engine.user_data import UserData
from flexbe_core.proxy.proxy_publisher import ProxyPublisher
from flexbe_core.proxy.proxy_subscriber_cached import ProxySubscriberCached
from flexbe_core.ros import command_hub
from flexbe_core.ros.session import own_session, run_session


class RosState(State):
    """A state with a polling rate, proxies, and commands from operators.

    In a behavior the engine runs it. `execute` of an instance is one whole execution, events and
    commands included, for callers who run a single state by hand.
    """

    _pub = ProxyPublisher()
    _sub = ProxySubscriberCached()

    def __init__(self, *args: object, **kwargs: object) -> None:
        super().__init__(*args, **kwargs)
        self.execute = self.__execute_by_hand

    def set_rate(self, rate: float) -> None:
        """Poll the state at `rate` [Hz] while it returns None."""
        self._rate = Rate.from_hz(rate)

    @property
    def sleep_duration(self) -> float:
        """How long [s] until the state wants to be executed again; negative if it is late."""
        return own_session(self).remaining_s()

    def sleep(self) -> None:
        """Wait until the state wants to be executed again."""
        own_session(self).sleep()

    @property
    def is_breakpoint(self) -> bool:
        """Return whether every transition of the state asks the operator."""
        return self.path in command_hub.current()

    def set_parent(self, value: State) -> None:
        """Put the state into a container, whose run takes the commands for it from now on."""
        super().set_parent(value)
        if self._is_controlled:
            run_session(self).listen()

    def _enable_ros_control(self) -> None:
        """Let operators supervise the state."""
        super()._enable_ros_control()
        run_session(self).listen()

    def __execute_by_hand(self, userdata: UserData) -> str | None:
        is_preempted = getattr(type(self), "preempt", False)
        return own_session(self).execute(userdata, is_preempted)
