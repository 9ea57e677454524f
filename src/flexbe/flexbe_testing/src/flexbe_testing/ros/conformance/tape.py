"""Remember what an engine publishes until a scenario asks for it."""

from __future__ import annotations

import threading
import time
from collections import defaultdict, deque
from collections.abc import Callable
from typing import Any

from flexbe_testing.core.conformance import topics
from flexbe_testing.ros.conformance.interrupt import Interrupt

# Codes of BEStatus.
_STARTED, _SWITCHING, _ERROR = 0, 6, 11

# What the states of the conformance behaviors log: event and path, or values.
EVENT = "events of the states"
_EVENT_PREFIX = "conformance: "

# A message of ROS, or the text of an event.
Message = Any


class Tape:
    """Messages in the order of their arrival, for each topic; may be added from any thread."""

    def __init__(self, interrupt: Interrupt) -> None:
        """Begin empty; waits end when `interrupt` is set."""
        self._interrupt = interrupt
        self._arrived = threading.Condition()
        self._waiting: dict[str, deque[Message]] = defaultdict(deque)
        self.statuses: list[Message] = []
        self.beats: list[float] = []

    def add(self, message: Message, topic: str) -> None:
        """Take a message."""
        with self._arrived:
            if topic == topics.HEARTBEAT:
                self.beats.append(time.monotonic())
            elif topic == topics.LOG and message.text.startswith(_EVENT_PREFIX):
                self._waiting[EVENT].append(message.text.removeprefix(_EVENT_PREFIX))
            else:
                self._waiting[topic].append(message)
            if topic == topics.STATUS:
                self.statuses.append(message)
            self._arrived.notify_all()

    def next(self, topic: str, limit_s: float) -> Message | None:
        """Return the next message of a topic; None if none arrives in time."""
        return self.find(topic, lambda message: True, limit_s)

    def find(
        self, topic: str, matches: Callable[[Message], bool], limit_s: float
    ) -> Message | None:
        """Return the next message that matches and drop those before it; None if none arrives."""
        end = time.monotonic() + limit_s
        with self._arrived:
            waiting = self._waiting[topic]
            while self._interrupt.wait_for(
                self._arrived, lambda: waiting, max(0.0, end - time.monotonic())
            ):
                message = waiting.popleft()
                if matches(message):
                    return message
        return None

    def wait(self, condition: Callable[[], bool], limit_s: float) -> bool:
        """Wait until a condition on the tape holds; return whether it does."""
        with self._arrived:
            return self._interrupt.wait_for(self._arrived, condition, limit_s)

    def left(self, topic: str) -> list[Message]:
        """Return the messages that have not been taken."""
        with self._arrived:
            return list(self._waiting[topic])

    def clear(self) -> None:
        """Drop all messages."""
        with self._arrived:
            self._waiting.clear()

    @property
    def is_running(self) -> bool:
        """Whether a behavior runs, by the statuses so far."""
        return self._last_code() == _STARTED

    @property
    def is_switching(self) -> bool:
        """Whether one behavior was replaced and the next has not started, by the statuses."""
        return self._last_code() == _SWITCHING

    def _last_code(self) -> int | None:
        """Return the last status code; ERROR refuses a request, and leaves the run as it is."""
        codes = (message.code for message in reversed(self.statuses))
        return next((code for code in codes if code != _ERROR), None)
