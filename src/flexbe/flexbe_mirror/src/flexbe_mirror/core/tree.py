"""The states and containers of a behavior, as its structure message lists them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from flexbe_core.engine.events import checksum


class StructureError(ValueError):
    """A structure message that does not describe a whole behavior."""


@dataclass(frozen=True)
class Part:
    """A container or state.

    Attributes:
        path: its path; empty for the root.
        children: labels of its children; none for a state.
        transitions: outcomes in their order -> label or outcome of the container around it.
    """

    path: str
    children: tuple[str, ...]
    transitions: tuple[tuple[str, str], ...]


class Tree:
    """The parts of one behavior.

    Attributes:
        parts: path -> part.
    """

    def __init__(self, parts: Iterable[Part]) -> None:
        """Put the parts together; their order does not matter.

        Raises:
            StructureError: if there is no root, or a child is missing.
        """
        self.parts = {part.path: part for part in parts}
        if "" not in self.parts:
            raise StructureError("the structure has no root, a container with an empty path")
        missing = [
            f"{part.path}/{label}"
            for part in self.parts.values()
            for label in part.children
            if f"{part.path}/{label}" not in self.parts
        ]
        if missing:
            raise StructureError(f"the structure lacks {', '.join(missing)}")

    def first_state(self, path: str = "") -> str:
        """Return the state that is active first in a container; a state stands for itself."""
        while self.parts[path].children:
            path = f"{path}/{self.parts[path].children[0]}"
        return path

    def state_with(self, path_checksum: int) -> str | None:
        """Return the part whose path has this checksum; None if there is none."""
        return next((path for path in self.parts if checksum(path) == path_checksum), None)

    def follow(self, path: str, outcome_index: int) -> str | None:
        """Return the state that is active after a state took an outcome; None after the last.

        Raises:
            IndexError: if the state has no such outcome.
        """
        if not 0 <= outcome_index < len(self.parts[path].transitions):
            raise IndexError(f"{path} has no outcome {outcome_index}")
        target = self.parts[path].transitions[outcome_index][1]
        while path:
            container = path.rpartition("/")[0]
            if target in self.parts[container].children:
                return self.first_state(f"{container}/{target}")
            path = container
            target = dict(self.parts[path].transitions).get(target, target)
        return None
