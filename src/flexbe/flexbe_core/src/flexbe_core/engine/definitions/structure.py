"""The structure of a behavior as mirrors get it: its containers and states, from the outside in."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from flexbe_core.engine.definitions.definition import Definition, Kind


@dataclass(frozen=True, slots=True)
class Part:
    """A container or state.

    Attributes:
        path: its path; empty for the root.
        children: labels of a container's children.
        outcomes: what it declares.
        transitions: where each outcome leads; empty for the root.
        autonomy: level that each outcome needs; empty for the root.
    """

    path: str
    children: tuple[str, ...]
    outcomes: tuple[str, ...]
    transitions: tuple[str, ...]
    autonomy: tuple[int, ...]


def structure_of(root: Definition) -> tuple[Part, ...]:
    """Return all parts of a definition; each container comes before its children."""
    return tuple(_walk(root, "", None, ""))


def definitions_below(root: Definition) -> Iterator[Definition]:
    """Yield the root and everything below it, depth first, in the order of definition."""
    yield root
    for child in () if type(root).__kind__ is Kind.STATE else root._labels.values():
        if type(child).__kind__ is Kind.STATE:
            yield child
        else:
            yield from definitions_below(child)


def definition_at(root: Definition, path: str) -> Definition:
    """Return the state or container at a path below the root."""
    for label in path.split("/")[1:]:
        root = root._labels[label]
    return root


def first_state(root: Definition) -> Definition:
    """Return the state that is active first; a container without states stands for itself."""
    while type(root).__kind__ is not Kind.STATE and root._labels:
        root = next(iter(root._labels.values()))
    return root


def first_path(root: Definition, path: str) -> str:
    """Return the path of the state that is active first in what is at `path`."""
    while type(root).__kind__ is not Kind.STATE and root._labels:
        label, root = next(iter(root._labels.items()))
        path = f"{path}/{label}"
    return path


def _walk(definition: Definition, path: str, parent: Definition, label: str) -> Iterator[Part]:
    is_container = type(definition).__kind__ is not Kind.STATE
    children = tuple(definition._labels) if is_container else ()
    outcomes = tuple(definition._outcomes)
    transitions = parent._transitions[label] if parent else {}
    autonomy = parent._autonomy.get(label, {}) if parent else {}
    yield Part(
        path,
        children,
        outcomes,
        tuple(transitions.get(outcome, "") for outcome in outcomes) if parent else (),
        autonomy=tuple(autonomy.get(outcome, 0) for outcome in outcomes) if parent else (),
    )
    for child in children:
        yield from _walk(definition._labels[child], f"{path}/{child}", definition, child)
