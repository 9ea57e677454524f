"""Stand-ins for everything that a state's constructor reaches for outside of its process.

Only for the child process of the doctor: they replace functions of rospy and of the proxies.
"""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import sys
import time
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any
from unittest.mock import MagicMock

import actionlib
import rospy

from flexbe_core.proxy import (
    ProxyActionClient,
    ProxyPublisher,
    ProxyServiceCaller,
    ProxySubscriberCached,
    ProxyTransformListener,
)

_INTERFACES = ("msg", "srv", "action")


class _AnyMessageType(type(MagicMock)):  # type: ignore[misc]
    """Has every constant."""

    def __getattr__(cls, name: str) -> MagicMock:
        if name.startswith("_"):
            raise AttributeError(name)
        return MagicMock(name=f"{cls.__name__}.{name}")


class _StubModule(ModuleType):
    """A module of messages that is not on this computer: every name in it is a message type."""

    def __getattr__(self, name: str) -> type:
        if name.startswith("__"):
            raise AttributeError(name)
        made = _AnyMessageType(name, (MagicMock,), {"__module__": self.__name__})
        setattr(self, name, made)
        return made


class MessageStubs(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Imports message packages that no other finder finds, and remembers them."""

    def __init__(self) -> None:
        """Begin with none."""
        self.stubbed: set[str] = set()

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Return a spec for what looks like a package of messages."""
        top, _, rest = name.partition(".")
        if not (top.endswith(("_msgs", "_msg", "_srvs", "_interfaces")) or rest in _INTERFACES):
            return None
        self.stubbed.add(top)
        return importlib.machinery.ModuleSpec(name, self, is_package=True)

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType:
        """Return a module in which every name is a message type."""
        return _StubModule(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: there is no source."""


def install() -> MessageStubs:
    """Replace everything; there is no ROS master, and nothing waits."""
    rospy.rostime.set_rostime_initialized(True)
    for name in ("Publisher", "Subscriber", "ServiceProxy", "Service", "Timer", "Rate"):
        setattr(rospy, name, MagicMock(name=f"rospy.{name}"))
    for name in ("wait_for_message", "wait_for_service", "sleep", "spin", "init_node"):
        setattr(rospy, name, MagicMock(name=f"rospy.{name}"))
    rospy.get_param = _get_param
    rospy.get_name = lambda: "/flexbe_doctor"
    for name in ("SimpleActionClient", "ActionClient", "SimpleActionServer", "ActionServer"):
        setattr(actionlib, name, MagicMock(name=f"actionlib.{name}"))
    _silence_proxies()
    time.sleep = lambda seconds: None
    finder = MessageStubs()
    sys.meta_path.append(finder)
    return finder


def _silence_proxies() -> None:
    nothing: Callable[..., Any] = lambda *args, **kwargs: None  # noqa: E731
    ProxyActionClient.setupClient = nothing
    ProxyServiceCaller.setupService = nothing
    ProxyPublisher.createPublisher = nothing
    ProxySubscriberCached.subscribe = nothing
    ProxyTransformListener.listener = lambda self: MagicMock(name="TransformListener")


def _get_param(name: str, default: object = None) -> object:
    return MagicMock(name=f"parameter {name}") if default is None else default
