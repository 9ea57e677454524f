"""Follow a behavior from outside, by its structure and the outcomes that were published."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Part:
    """A state or container of a published structure.

    Attributes:
        path: its path; empty for the root.
        children: the labels of its states, the initial one first.
        outcomes: its outcomes.
        transitions: label or outcome of the container around it, for each outcome.
    """

    path: str
    children: tuple[str, ...]
    outcomes: tuple[str, ...]
    transitions: tuple[str, ...]


def initial(parts: Mapping[str, Part], path: str = "") -> str:
    """Return the path of the state with which a container begins; the path itself if a state."""
    part = parts[path]
    return initial(parts, f"{path}/{part.children[0]}") if part.children else path


def successor(parts: Mapping[str, Part], path: str, index: int) -> str | None:
    """Return the state that follows a state's outcome; None if the behavior ends.

    Raises:
        ValueError: if the structure does not contain what follows.
    """
    part, container = parts[path], path.rpartition("/")[0]
    target = part.transitions[index]
    if target in parts[container].children:
        return initial(parts, f"{container}/{target}")
    if target not in parts[container].outcomes:
        raise ValueError(f"outcome {index} of {path} leads to {target!r}, which is not there")
    if not container:
        return None
    return successor(parts, container, parts[container].outcomes.index(target))
