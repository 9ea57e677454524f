"""Which state mirrors show, and where they arrive when they follow an outcome.

A mirror knows the structure of the behavior and one active state. It follows the outcomes of that
state through the structure, as in stock FlexBE. If it arrives at a state other than the active
one, the engine publishes a sync after the outcome: a concurrency container continues after its
first state has ended, or is ended by another of its states.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexbe_core.engine.concurrency import Concurrency
from flexbe_core.engine.definitions.structure import first_path
from flexbe_core.engine.machine import Machine

if TYPE_CHECKING:
    from flexbe_core.engine.node import Node


def shown(node: Node) -> Node:
    """Return the node of the active state below `node` that mirrors show.

    Without one, return the innermost container that has been reached: it has not begun, or its
    states have all ended and it is held for the operator.
    """
    while True:
        inner = None
        if isinstance(node, Concurrency):
            inner = node.first_running()
        elif isinstance(node, Machine):
            inner = node.current
        if inner is None:
            return node
        node = inner


def shown_path(root: Node) -> str:
    """Return the path that mirrors show; before a container begins, that of its first state."""
    node = shown(root)
    return node.path if node.active else first_path(node.definition, node.path)


def arrival(node: Node, outcome: str) -> str:
    """Return where a mirror arrives that follows an outcome; empty at the end of the behavior."""
    while node.parent is not None:
        container = node.parent.definition
        target = container._transitions[node.label].get(outcome, outcome)
        if target in container._labels:
            return first_path(container._labels[target], f"{node.parent.path}/{target}")
        node, outcome = node.parent, target
    return ""
