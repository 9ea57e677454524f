"""The states of a running behavior as the engine publishes them, and what follows an outcome."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property


@dataclass(frozen=True)
class Level:
    """A state, or a container if it has children; the first child is the initial one.

    `outcomes` are in the engine's order, `transitions` say where each leads.
    """

    path: str
    children: tuple[str, ...]
    outcomes: tuple[str, ...]
    transitions: tuple[str, ...]


@dataclass(frozen=True)
class Structure:
    """All levels of a behavior; the path of its root is empty."""

    behavior_id: int
    levels: tuple[Level, ...]

    @cached_property
    def by_path(self) -> Mapping[str, Level]:
        """Return the levels by path."""
        return {level.path: level for level in self.levels}

    def following(self, path: str, outcome: str) -> str | None:
        """Return the state that is active after one was left; empty at the end of the behavior.

        None if it is not known, as in a container whose children run at the same time.
        """
        while path:
            level = self.by_path.get(path)
            above = path.rpartition("/")[0]
            container = self.by_path.get(above)
            if level is None or container is None or outcome not in level.outcomes:
                return None
            index = level.outcomes.index(outcome)
            target = level.transitions[index] if index < len(level.transitions) else ""
            if target in container.children:
                return self._first_in(f"{above}/{target}")
            if target not in container.outcomes:
                return None
            path, outcome = above, target
        return ""

    def _first_in(self, path: str) -> str:
        """Return the state that is entered first when a path is."""
        level = self.by_path.get(path)
        while level is not None and level.children:
            path = f"{path}/{level.children[0]}"
            level = self.by_path.get(path)
        return path
