"""Commands from operators, passed to the runs of this process, and breakpoints.

There is one subscription per topic and process, whatever runs in it.

rospy subscribes to a parameter the first time it is read with a cache, but asks the master each
time for one that is not set. So the cache is read here once it is subscribed.
"""

from __future__ import annotations

import functools
import threading
import weakref
from collections.abc import Callable, Collection
from typing import Any, Protocol

import rospy
from genpy import Message
from rospy.impl.paramserver import get_param_server_cache

from flexbe_core.engine.supervision import (
    Attach,
    Command,
    ForceOutcome,
    Lock,
    Pause,
    Preempt,
    Repeat,
    Resume,
    SetAutonomy,
    ShowStructure,
    Sync,
    Unlock,
)
from flexbe_core.proxy.proxy_subscriber_cached import ProxySubscriberCached
from flexbe_core.ros import topics
from flexbe_core.ros.topics import BREAKPOINTS_PARAMETER

_COMMANDS: dict[str, Callable[[Any], Command]] = {
    topics.PREEMPT: lambda message: Preempt(),
    topics.PREEMPT_OF_DELIVERABLE: lambda message: Preempt(),
    topics.AUTONOMY: lambda message: SetAutonomy(message.data),
    topics.ATTACH: lambda message: Attach(message.data),
    topics.SYNC: lambda message: Sync(),
    topics.REQUEST_STRUCTURE: lambda message: ShowStructure(),
    topics.TRANSITION: lambda message: ForceOutcome(message.target, message.outcome),
    topics.LOCK: lambda message: Lock(message.data),
    topics.UNLOCK: lambda message: Unlock(message.data),
    topics.PAUSE: lambda message: Pause() if message.data else Resume(),
    topics.REPEAT: lambda message: Repeat(),
}


# Commands that end a run. A machine that is executed by hand, without supervision, needs no more,
# and each subscription costs calls to the master.
STOPS = (topics.PREEMPT, topics.PREEMPT_OF_DELIVERABLE)

# Stay in force until another command changes them. The others apply to the state active now.
_LASTING = Preempt | SetAutonomy | Attach | Lock | Unlock | Pause | Resume


class Listener(Protocol):
    """A run that can be commanded."""

    def post(self, command: Command) -> None:
        """Take a command; may be called from any thread."""


class CommandHub:
    """Passes each command to all listeners.

    Attributes:
        preempts: how many have arrived.
    """

    def __init__(self) -> None:
        self.preempts = 0
        self._lock = threading.Lock()
        self._listeners: weakref.WeakSet[Listener] = weakref.WeakSet()
        self._held: list[Command] | None = None
        self._subscribed: set[str] = set()

    def subscribe(self, names: Collection[str] = topics.COMMANDS) -> None:
        """Subscribe to commands, by default to all.

        That calls the master for each topic, so better before a run.
        """
        for topic in names:
            if topic not in self._subscribed:
                self._subscribed.add(topic)
                on_message = functools.partial(self._on_message, topic)
                ProxySubscriberCached().subscribe(topic, topics.COMMANDS[topic], on_message)

    def hold(self) -> None:
        """Keep lasting commands from now on for the next listener: a run is being prepared."""
        with self._lock:
            self._held = []

    def drop(self) -> None:
        """Forget what was kept, and keep nothing more: nothing is being prepared."""
        with self._lock:
            self._held = None

    def listen(self, listener: Listener) -> None:
        """Pass commands to `listener` as long as it lives, or until ignore is called.

        It gets first, in their order, the commands that were kept for it.
        """
        with self._lock:
            for command in self._held or ():
                listener.post(command)
            self._held = None
            self._listeners.add(listener)

    def ignore(self, listener: Listener) -> None:
        """Pass no more commands to `listener`."""
        with self._lock:
            self._listeners.discard(listener)

    def post(self, command: Command) -> None:
        """Pass a command to all listeners; may be called from any thread."""
        with self._lock:
            self.preempts += isinstance(command, Preempt)
            if self._held is not None and isinstance(command, _LASTING):
                self._held.append(command)
            for listener in tuple(self._listeners):
                listener.post(command)

    def _on_message(self, topic: str, message: Message) -> None:
        self.post(_COMMANDS[topic](message))


# Subscriptions belong to the process, as all proxies' do.
HUB = CommandHub()


@functools.cache
def subscribe() -> None:
    """Subscribe to changes of the parameter; the first call is a call to the master."""
    rospy.get_param_cached(BREAKPOINTS_PARAMETER, [])


def current() -> frozenset[str]:
    """Return the paths of the states that are breakpoints."""
    try:
        paths = get_param_server_cache().get(BREAKPOINTS_PARAMETER)
    except KeyError:
        return frozenset()
    return frozenset(map(str, paths)) if isinstance(paths, list) else frozenset()
