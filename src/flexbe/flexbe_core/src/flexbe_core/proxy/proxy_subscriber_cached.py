"""Receive messages in a state."""

from __future__ import annotations

import traceback
import weakref
from collections import deque
from collections.abc import Callable, Mapping
from typing import ClassVar

import rospy
from genpy import Message

from flexbe_core.core.state import State
from flexbe_core.ros.driver import Waiting

Callback = Callable[[Message], None]


class _Channel:
    """What arrived on one topic, and its callbacks and waiting states."""

    def __init__(self, buffered: bool) -> None:
        self.subscriber: rospy.Subscriber | None = None
        self.last: Message | None = None
        self.buffer: deque[Message] | None = deque() if buffered else None
        self.is_persistent = False
        self.waiting = Waiting()
        self._callbacks: list[Callable[[], Callback | None]] = []

    def add_callback(self, callback: Callback) -> None:
        """Call `callback` for each message; a method of a state only as long as the state lives."""
        if isinstance(getattr(callback, "__self__", None), State):
            self._callbacks.append(weakref.WeakMethod(callback, self._callbacks.remove))
        else:
            self._callbacks.append(lambda: callback)

    def arrived(self, message: Message) -> None:
        """Store a message, call the callbacks, then wake the states that wait for it."""
        if self.buffer is not None:
            self.buffer.append(message)
        self.last = message
        for reference in tuple(self._callbacks):
            callback = reference()
            try:
                if callback is not None:
                    callback(message)
            except Exception:  # noqa: BLE001 - the message is for other states too
                rospy.logerr("callback %r failed:\n%s", callback, traceback.format_exc())
        self.waiting.wake_all()


class ProxySubscriberCached:
    """A handle on the subscriptions of the process; each keeps its last message."""

    _channels: ClassVar[dict[str, _Channel]] = {}

    def __init__(self, topics: Mapping[str, type[Message]] | None = None) -> None:
        for topic, message_type in (topics or {}).items():
            self.subscribe(topic, message_type)

    def subscribe(
        self,
        topic: str,
        msg_type: type[Message],
        callback: Callback | None = None,
        buffered: bool = False,
    ) -> None:
        """Subscribe to a topic, unless the process does already, and add the callback."""
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._channels[topic] = _Channel(buffered)
            channel.subscriber = rospy.Subscriber(
                topic, msg_type, self._callback, callback_args=topic, tcp_nodelay=True
            )
        if callback is not None:
            channel.add_callback(callback)

    def set_callback(self, topic: str, callback: Callback | None) -> None:
        """Call `callback` for each message from now on."""
        if callback is not None:
            self._channels[topic].add_callback(callback)

    def enable_buffer(self, topic: str) -> None:
        """Keep all messages from now on, not only the last."""
        channel = self._channels[topic]
        if channel.buffer is None:
            channel.buffer = deque()

    def disable_buffer(self, topic: str) -> None:
        """Keep only the last message from now on."""
        self._channels[topic].buffer = None

    def is_available(self, topic: str) -> bool:
        """Return whether the topic is subscribed to."""
        return topic in self._channels

    def has_topic(self, topic: str) -> bool:
        """Return whether the topic is subscribed to; stock FlexBE's older name."""
        return self.is_available(topic)

    def has_msg(self, topic: str) -> bool:
        """Return whether there is a message."""
        channel = self._channels.get(topic)
        if channel is None:
            return False
        channel.waiting.add_caller()
        return channel.last is not None

    def get_last_msg(self, topic: str) -> Message | None:
        """Return the last message; None if there is none."""
        channel = self._channels[topic]
        channel.waiting.add_caller()
        return channel.last

    def remove_last_msg(self, topic: str, clear_buffer: bool = False) -> None:
        """Forget the last message, and on request all buffered ones."""
        channel = self._channels[topic]
        if channel.is_persistent:
            return
        channel.last = None
        if clear_buffer and channel.buffer is not None:
            channel.buffer.clear()

    def has_buffered(self, topic: str) -> bool:
        """Return whether there is a buffered message."""
        channel = self._channels[topic]
        channel.waiting.add_caller()
        return bool(channel.buffer)

    def get_from_buffer(self, topic: str) -> Message | None:
        """Remove and return the oldest buffered message; None if there is none."""
        channel = self._channels[topic]
        if channel.buffer is None:
            rospy.logwarn("%s is not buffered; call enable_buffer first", topic)
            return None
        channel.waiting.add_caller()
        return channel.buffer.popleft() if channel.buffer else None

    def make_persistant(self, topic: str) -> None:
        """Never forget the last message."""
        self._channels[topic].is_persistent = True

    def unsubscribe_topic(self, topic: str) -> None:
        """End the subscription, for the whole process."""
        channel = self._channels.pop(topic, None)
        if channel is not None and channel.subscriber is not None:
            channel.subscriber.unregister()

    def shutdown(self) -> None:
        """End all subscriptions of the process."""
        for topic in tuple(self._channels):
            self.unsubscribe_topic(topic)

    def _callback(self, msg: Message, topic: str) -> None:
        channel = self._channels.get(topic)
        if channel is not None:
            channel.arrived(msg)
