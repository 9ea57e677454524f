"""Place the states of a behavior on the canvas of the FlexBE App: columns by distance, no overlap.

A state stands in the column of its distance from the initial state, in the row that suits those
that lead to it; outcomes stand in the last column.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from flexbe_synthesizer.core.machine.machine import BehaviorUse, Child, Container, StateUse

ORIGIN = (30, 40)  # where the App puts what has no position [pixels]
_GRID = 50  # the App's own grid [pixels]
_ROW = 100  # between rows; a box is about 50 high [pixels]
_LETTER = 8  # a generous letter of the App's font [pixels]
_MARGIN = 100  # beside the text of a box: its padding, and room for the transitions [pixels]

Point = tuple[int, int]


@dataclass(frozen=True)
class Layout:
    """Positions [pixels] of the children and of the outcomes of each container, by its path."""

    children: Mapping[str, Mapping[str, Point]]
    outcomes: Mapping[str, Mapping[str, Point]]


def lay_out(root: Container) -> Layout:
    """Return positions for everything in a root container."""
    children: dict[str, Mapping[str, Point]] = {}
    outcomes: dict[str, Mapping[str, Point]] = {}
    waiting = [("", root)]
    while waiting:
        path, container = waiting.pop()
        children[path], outcomes[path] = _place(container)
        for child in container.children:
            if isinstance(child.content, Container):
                waiting.append((f"{path}/{child.label}", child.content))
    return Layout(children, outcomes)


def _place(container: Container) -> tuple[Mapping[str, Point], Mapping[str, Point]]:
    """Return the positions of a container's children and of its outcomes."""
    placed: dict[str, Point] = {}
    x = ORIGIN[0]
    for column in _columns(container):
        width = 0
        for row, child in enumerate(column):
            placed[child.label] = (x, ORIGIN[1] + row * _ROW)
            width = max(width, _width(child))
        x += width
    ends = {name: (x, ORIGIN[1] + row * _ROW) for row, name in enumerate(container.outcomes)}
    return placed, ends


def _columns(container: Container) -> list[list[Child]]:
    """Return the children by distance from the initial one, each column in its order."""
    if container.conditions:
        return [list(container.children)]  # concurrent children have no order
    unseen = {child.label: child for child in container.children}
    columns = []
    column = [unseen.pop(container.children[0].label)]
    while column:
        columns.append(column)
        # In the order of those that lead there, which keeps the lines short and few crossing.
        column = [
            unseen.pop(target)
            for child in column
            for _outcome, target, _autonomy in child.exits
            if target in unseen
        ]
    return [*columns, list(unseen.values())] if unseen else columns


def _width(child: Child) -> int:
    """Return the width of a child's column on the grid [pixels]."""
    content = child.content
    second = ""
    if isinstance(content, StateUse):
        second = content.state.name
    elif isinstance(content, BehaviorUse):
        second = content.behavior.name
    width = max(len(child.label), len(second)) * _LETTER + _MARGIN
    return -(-width // _GRID) * _GRID
