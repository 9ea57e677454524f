"""Which nodes publish a topic, and whether they answer: what was killed stays registered."""

from __future__ import annotations

import http.client
import xmlrpc.client
from collections.abc import Iterator
from enum import Enum
from functools import lru_cache

import rosgraph

_CALLER = "/remodel_console"
# [s] Wall time in which a node answers; one that is stopped never does.
_LIMIT_S = 1.0
_ERRORS = (OSError, http.client.HTTPException, xmlrpc.client.Error, rosgraph.MasterError)


class NodeAnswer(Enum):
    """What a node answers: none comes from a process that is stopped, and it is gone if killed."""

    YES = 1
    NONE = 2
    GONE = 3


class Nodes:
    """The nodes that are registered at the master, as of the last call of `look`."""

    def __init__(self) -> None:
        """Begin without any."""
        self._publishers: dict[str, list[str]] = {}
        self._services: frozenset[str] = frozenset()
        self._answers: dict[str, NodeAnswer] = {}

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

    def topics(self, prefix: str, suffix: str) -> list[str]:
        """Return the published topics that begin and end so."""
        names = self._publishers
        return [name for name in names if name.startswith(prefix) and name.endswith(suffix)]

    def publishing(self, topic: str) -> list[str]:
        """Return the nodes that publish a topic and answer."""
        return [node for node, answer in self._asked(topic) if answer is NodeAnswer.YES]

    def is_silent(self, topic: str) -> bool:
        """Return whether nodes that publish a topic live, and none of them answers."""
        answers = {answer for _, answer in self._asked(topic)}
        return NodeAnswer.NONE in answers and NodeAnswer.YES not in answers

    def parameter(self, node: str, name: str) -> object:
        """Return a private parameter of a node; None without it."""
        try:
            return rosgraph.Master(_CALLER).getParam(f"{node}/{name}")
        except _ERRORS:
            return None

    def _asked(self, topic: str) -> Iterator[tuple[str, NodeAnswer]]:
        for node in self._publishers.get(topic, ()):
            if node not in self._answers:
                self._answers[node] = _ask(node)
            yield node, self._answers[node]


def _ask(node: str) -> NodeAnswer:
    try:
        uri = rosgraph.Master(_CALLER).lookupNode(node)
        _proxy(uri).getPid(_CALLER)
    except TimeoutError:
        _proxy.cache_clear()  # what is left of a call that took too long answers no other
        return NodeAnswer.NONE
    except _ERRORS:
        _proxy.cache_clear()
        return NodeAnswer.GONE
    return NodeAnswer.YES


@lru_cache(maxsize=64)
def _proxy(uri: str) -> xmlrpc.client.ServerProxy:
    return xmlrpc.client.ServerProxy(uri, transport=_Transport())


class _Transport(xmlrpc.client.Transport):
    """Waits no longer than the limit."""

    def make_connection(self, host: object) -> http.client.HTTPConnection:
        connection = super().make_connection(host)  # type: ignore[arg-type]
        connection.timeout = _LIMIT_S
        return connection
