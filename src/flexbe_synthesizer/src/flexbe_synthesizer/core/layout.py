"""Place the states of a behavior on the canvas of the FlexBE App: columns by distance, no overlap.

A state stands in the column of its distance from the initial state, in the row that suits those
that lead to it; outcomes stand in the last column.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from flexbe_synthesizer.core.machine import BehaviorUse, Child, Container, StateUse, walk

ORIGIN = (30, 40)  # where the App puts what has no position [pixels]
_GRID = 50  # the App's own grid [pixels]
_ROW = 100  # between rows; a box is about 50 high [pixels]
_LETTER = 8  # a generous letter of the App's font [pixels]
_MARGIN = 100  # beside the text of a box: its padding, and room for the transitions [pixels]

Point = tuple[int, int]


@dataclass(frozen=True)
class Layout:
    """Positions [pixels]: of each child by its path, of each container's outcomes by its path."""

    children: Mapping[str, Point]
    outcomes: Mapping[str, Mapping[str, Point]]


def lay_out(root: Container) -> Layout:
    """Return positions for everything in a root container."""
    children: dict[str, Point] = {}
    outcomes: dict[str, Mapping[str, Point]] = {}
    containers = {"": root} | {
        path: child.content for path, child in walk(root) if isinstance(child.content, Container)
    }
    for path, container in containers.items():
        placed, outcomes[path] = _place(container)
        children.update({f"{path}/{label}": point for label, point in placed.items()})
    return Layout(children, outcomes)


def _place(container: Container) -> tuple[Mapping[str, Point], Mapping[str, Point]]:
    """Return the positions of a container's children and of its outcomes."""
    by_label = {child.label: child for child in container.children}
    placed: dict[str, Point] = {}
    x = ORIGIN[0]
    for column in _columns(container):
        for row, label in enumerate(column):
            placed[label] = (x, ORIGIN[1] + row * _ROW)
        x += max(_width(by_label[label]) for label in column)
    ends = {name: (x, ORIGIN[1] + row * _ROW) for row, name in enumerate(container.outcomes)}
    return placed, ends


def _columns(container: Container) -> list[list[str]]:
    """Return the labels by distance from the initial child, each column in its order."""
    targets = {child.label: [exit_.target for exit_ in child.exits] for child in container.children}
    columns = [[container.children[0].label]]
    seen = set(columns[0])
    if container.conditions:
        return [list(targets)]  # concurrent children have no order
    while columns[-1]:
        # In the order of those that lead there, which keeps the lines short and few crossing.
        led_to = (target for label in columns[-1] for target in targets[label])
        found = dict.fromkeys(t for t in led_to if t in targets and t not in seen)
        seen.update(found)
        columns.append(list(found))
    left = [label for label in targets if label not in seen]
    return [column for column in (*columns, left) if column]


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
