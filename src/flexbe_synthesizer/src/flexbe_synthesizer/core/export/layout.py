"""A behavior for the FlexBE App: its states placed on the canvas, and as a server returns them.

A state stands in the column of its distance from the initial state, in the row that suits those
that lead to it; outcomes stand in the last column.

The list has the fields of `flexbe_msgs/StateInstantiation`. Paths are relative to the synthesized
container, whose own entry is `/`. Such a list cannot carry default userdata, so what a behavior
starts with (the counts of attempts) is written by states put before the initial one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.model import Autonomy
from flexbe_synthesizer.core.library.signature import StateClass
from flexbe_synthesizer.core.machine.machine import (
    BehaviorUse,
    Child,
    Container,
    Exit,
    Kind,
    Pair,
    StateUse,
    python_value,
    walk,
)

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


WRITER = ("flexbe_states", "UserDataState")
_CLASSES = {
    Kind.STATE_MACHINE: ":STATEMACHINE",
    Kind.CONCURRENCY: ":CONCURRENCY",
    Kind.PRIORITY: ":PRIORITY",
}
_BEHAVIOR = ":BEHAVIOR"
_LEVELS = {Autonomy.OFF: 0, Autonomy.LOW: 1, Autonomy.HIGH: 2, Autonomy.FULL: 3}
_INHERIT = -1


@dataclass(frozen=True)
class Instantiation:
    """One state or container, field by field a `flexbe_msgs/StateInstantiation`.

    `cond_transition` holds the (state, outcome)s of each condition, in the order of `cond_outcome`.
    """

    state_path: str
    state_class: str
    initial_state_name: str = ""
    input_keys: tuple[str, ...] = ()
    output_keys: tuple[str, ...] = ()
    cond_outcome: tuple[str, ...] = ()
    cond_transition: tuple[tuple[tuple[str, str], ...], ...] = ()
    behavior_class: str = ""
    parameter_names: tuple[str, ...] = ()
    parameter_values: tuple[str, ...] = ()
    position: tuple[float, float] = (0.0, 0.0)
    outcomes: tuple[str, ...] = ()
    transitions: tuple[str, ...] = ()
    autonomy: tuple[int, ...] = ()
    userdata_keys: tuple[str, ...] = ()
    userdata_remapping: tuple[str, ...] = ()


def presets(root: Container) -> tuple[Pair, ...]:
    """Return the userdata that a container starts with and that no caller can give it."""
    interface = (*root.input_keys, *root.output_keys)
    return tuple(pair for pair in root.userdata if pair.name not in interface)


def with_presets_written(root: Container, writer: StateClass) -> Container:
    """Return the container with a state at its beginning for each value that it starts with."""
    labels = {child.label for child in root.children} | set(root.outcomes)
    children = list(root.children)
    for key, value in presets(root):
        label = names.take_unused(f"Set {key}", labels)
        labels.add(label)
        use = StateUse(writer, writer.name, (Pair("data", value),))
        exit_ = Exit("done", children[0].label)
        children.insert(0, Child(label, use, (exit_,), (("data", key),)))
    return Container(
        root.kind, root.outcomes, root.input_keys, root.output_keys, children=tuple(children)
    )


def instantiate(root: Container, layout: Layout) -> tuple[Instantiation, ...]:
    """Return the entries of a root container, itself first."""
    whole = Instantiation(
        state_path="/",
        state_class=_CLASSES[root.kind],
        initial_state_name=root.children[0].label,
        input_keys=root.input_keys,
        output_keys=root.output_keys,
        outcomes=root.outcomes,
    )
    return (whole, *(_entry(path, child, layout) for path, child in walk(root)))


def _entry(path: str, child: Child, layout: Layout) -> Instantiation:
    content = child.content
    container = content if isinstance(content, Container) else None
    parameters: tuple[Pair, ...] = ()
    state_class, behavior_class = _BEHAVIOR, ""
    if isinstance(content, Container):
        state_class = _CLASSES[content.kind]
    elif isinstance(content, StateUse):
        state_class, parameters = content.alias, content.arguments
    else:
        behavior_class, parameters = content.behavior.name, content.parameters
    above, _, label = path.rpartition("/")
    x, y = layout.children[above][label]
    return Instantiation(
        state_path=path,
        state_class=state_class,
        initial_state_name=container.children[0].label if container else "",
        input_keys=container.input_keys if container else (),
        output_keys=container.output_keys if container else (),
        cond_outcome=tuple(c.outcome for c in container.conditions) if container else (),
        cond_transition=tuple(c.pairs for c in container.conditions) if container else (),
        behavior_class=behavior_class,
        parameter_names=tuple(pair.name for pair in parameters),
        parameter_values=tuple(python_value(pair.value) for pair in parameters),
        position=(float(x - ORIGIN[0]), float(y - ORIGIN[1])),
        outcomes=tuple(exit_.outcome for exit_ in child.exits),
        transitions=tuple(exit_.target for exit_ in child.exits),
        autonomy=tuple(_level(exit_, child) for exit_ in child.exits),
        userdata_keys=tuple(key for key, _home in child.remapping),
        userdata_remapping=tuple(home for _key, home in child.remapping),
    )


def _level(exit_: Exit, child: Child) -> int:
    if exit_.autonomy is not None:
        return _LEVELS[exit_.autonomy]
    return _LEVELS[Autonomy.OFF] if isinstance(child.content, StateUse) else _INHERIT
