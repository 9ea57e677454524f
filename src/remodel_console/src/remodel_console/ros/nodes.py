"""Which nodes publish a topic, and whether they answer: a stopped process stays registered."""

from __future__ import annotations

import http.client
import xmlrpc.client
from collections.abc import Callable, Iterable
from functools import lru_cache

import rosgraph

_CALLER = "/remodel_console"
# [s] Wall time in which a node answers; one that is stopped never does.
_LIMIT_S = 1.0
_ERRORS = (OSError, http.client.HTTPException, xmlrpc.client.Error, rosgraph.MasterError)


class Nodes:
    """The nodes that are registered at the master, as they were inspected last."""

    def __init__(self) -> None:
        """Begin without any."""
        self._publishers: dict[str, list[str]] = {}
        self._services: frozenset[str] = frozenset()
        self._answers: dict[str, bool] = {}

    def look(self) -> None:
        """Ask the master which there are; none if it is not running."""
        self._answers = {}
        try:
            publishers, _, services = rosgraph.Master(_CALLER).getSystemState()
        except _ERRORS:
            publishers, services = [], []
        self._publishers = dict(publishers)
        self._services = frozenset(name for name, _ in services)

    def has_service(self, name: str) -> bool:
        """Return whether a service is registered."""
        return name in self._services

    def topics(self, belongs: Callable[[str], bool]) -> Iterable[str]:
        """Return the topics that are published, of those that belong to what is searched for."""
        return filter(belongs, self._publishers)

    def publishing(self, topic: str) -> list[str]:
        """Return the nodes that publish a topic and answer."""
        return [node for node in self._publishers.get(topic, ()) if self._does_answer(node)]

    def is_silent(self, topic: str) -> bool:
        """Return whether nodes publish a topic, and none of them answers."""
        return bool(self._publishers.get(topic)) and not self.publishing(topic)

    def parameter(self, node: str, name: str) -> object:
        """Return a private parameter of a node; None without it."""
        try:
            return rosgraph.Master(_CALLER).getParam(f"{node}/{name}")
        except _ERRORS:
            return None

    def _does_answer(self, node: str) -> bool:
        if node not in self._answers:
            self._answers[node] = _does_answer(node)
        return self._answers[node]


def _does_answer(node: str) -> bool:
    try:
        uri = rosgraph.Master(_CALLER).lookupNode(node)
        code, _, _ = _proxy(uri).getPid(_CALLER)
    except _ERRORS:
        _proxy.cache_clear()  # what is left of a call that took too long answers no other
        return False
    return bool(code == 1)


@lru_cache(maxsize=64)
def _proxy(uri: str) -> xmlrpc.client.ServerProxy:
    return xmlrpc.client.ServerProxy(uri, transport=_Transport())


class _Transport(xmlrpc.client.Transport):
    """Waits no longer than the limit."""

    def make_connection(self, host: object) -> http.client.HTTPConnection:
        connection = super().make_connection(host)  # type: ignore[arg-type]
        connection.timeout = _LIMIT_S
        return connection
