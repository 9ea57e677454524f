"""Find a cycle in a graph."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from graphlib import CycleError, TopologicalSorter


def cycle_in(successors: Mapping[str, Iterable[str]]) -> list[str]:
    """Return the nodes of a cycle in their order, the first one again at the end; or nothing."""
    try:
        TopologicalSorter(successors).prepare()
    except CycleError as error:
        return list(reversed(error.args[1]))
    return []
