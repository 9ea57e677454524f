"""Requests to a synthesis server, and what it returns as a chart.

The latter is the inverse of the synthesizer's `instantiate`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from flexbe_synthesizer.core.chart.model import Autonomy, Chart, freeze
from flexbe_synthesizer.core.export.layout import WRITER, Instantiation
from flexbe_synthesizer.core.library.signature import BehaviorClass, Library, StateClass
from flexbe_synthesizer.core.machine.lift import lift
from flexbe_synthesizer.core.machine.machine import (
    BehaviorUse,
    Child,
    Condition,
    Container,
    Exit,
    Expression,
    Kind,
    Machine,
    Pair,
    StateUse,
    Value,
)
from remodel_console.errors import CommandError

_KINDS = {
    ":STATEMACHINE": Kind.STATE_MACHINE,
    ":CONCURRENCY": Kind.CONCURRENCY,
    ":PRIORITY": Kind.PRIORITY,
}
_BEHAVIOR = ":BEHAVIOR"
_LEVELS = (None, Autonomy.LOW, Autonomy.HIGH, Autonomy.FULL)  # off is the default of states


@dataclass(frozen=True)
class ServerRequest:
    """A request to a synthesis server.

    Attributes:
        topic: name of its action.
        system: name of the robot system; may be empty.
        path: of the container to fill, such as `/Place/Insert`.
        initial: where it starts; empty for where the chart itself does.
        goal: path of the chart.
    """

    topic: str
    system: str
    path: str
    initial: str
    goal: str


def chart_from_states(states: Iterable[Instantiation], name: str, library: Library) -> Chart:
    """Return the chart that a server's states are.

    Args:
        states: as the server returned them, the root `/` among them.
        name: of the chart, which is the id of the container that it goes into.
        library: the states and behaviors that are installed.

    Raises:
        CommandError: if they are no machine, name what is not installed, or no chart can say it.
    """
    by_path = {state.state_path: state for state in states}
    if "/" not in by_path:
        raise CommandError("the synthesis server returned no container '/'")
    try:
        root = _container(by_path, "/", library)
        return lift(Machine(name, "", "", _without_presets(root)), f"container {name}")
    except ValueError as error:
        text = f"what the synthesis server returned cannot be used: {error}"
        raise CommandError(text) from error


def _container(by_path: dict[str, Instantiation], path: str, library: Library) -> Container:
    entry = by_path[path]
    if entry.state_class not in _KINDS:
        raise ValueError(f"'{path}' is a '{entry.state_class}', which is no container")
    inside = [
        _child(by_path, one, library)
        for one in by_path
        if one != "/" and one.rpartition("/")[0] == path.rstrip("/")
    ]
    inside.sort(key=lambda child: child.label != entry.initial_state_name)
    conditions = zip(entry.cond_outcome, entry.cond_transition, strict=True)
    return Container(
        _KINDS[entry.state_class],
        entry.outcomes,
        entry.input_keys,
        entry.output_keys,
        children=tuple(inside),
        conditions=tuple(Condition(outcome, pairs) for outcome, pairs in conditions),
    )


def _child(by_path: dict[str, Instantiation], path: str, library: Library) -> Child:
    entry = by_path[path]
    exits = tuple(_exits(entry))
    homes = tuple(zip(entry.userdata_keys, entry.userdata_remapping, strict=True))
    values = zip(entry.parameter_names, entry.parameter_values, strict=True)
    pairs = tuple(Pair(name, _value(text)) for name, text in values)
    label = path.rpartition("/")[2]
    if entry.state_class in _KINDS:
        container = _container(by_path, path, library)
        own = replace(container, outcomes=container.outcomes or entry.outcomes)
        return Child(label, own, exits, homes)
    if entry.state_class == _BEHAVIOR:
        behavior = library.find_behaviors(entry.behavior_class)
        if len(behavior) != 1 or not isinstance(behavior[0], BehaviorClass):
            raise ValueError(f"'{label}' is the behavior '{entry.behavior_class}', not found here")
        return Child(label, BehaviorUse(behavior[0], pairs, ()), exits, homes)
    state = library.find_states(entry.state_class)
    if len(state) != 1 or not isinstance(state[0], StateClass):
        raise ValueError(
            f"'{label}' is a '{entry.state_class}', which is not installed in exactly one package"
        )
    return Child(label, StateUse(state[0], entry.state_class, pairs), exits, homes)


def _exits(entry: Instantiation) -> Iterator[Exit]:
    levels = entry.autonomy or (0,) * len(entry.outcomes)
    for outcome, target, level in zip(entry.outcomes, entry.transitions, levels, strict=True):
        yield Exit(outcome, target, _LEVELS[level] if 0 < level < len(_LEVELS) else None)


def _value(text: str) -> Value:
    """Return a value spelled in Python; a function stays text, which `lift` takes if it is ours."""
    try:
        node = ast.parse(text, mode="eval").body
        return Expression(ast.unparse(node)) if isinstance(node, ast.Lambda) else _literal(node)
    except SyntaxError as error:
        raise ValueError(f"{text!r} is no value") from error


def _literal(node: ast.expr) -> Value:
    try:
        return freeze(ast.literal_eval(node))
    except (TypeError, RecursionError) as error:
        raise ValueError(f"{ast.unparse(node)!r} is no literal") from error


def _without_presets(root: Container) -> Container:
    """Return the root with default userdata in place of the states that set it at its start."""
    children, userdata = list(root.children), []
    while children and (found := _preset(children[0])) is not None:
        userdata.append(found)
        children.pop(0)
    return replace(root, children=tuple(children), userdata=tuple(userdata))


def _preset(child: Child) -> Pair | None:
    content = child.content
    if not isinstance(content, StateUse) or len(child.remapping) != 1:
        return None
    key = child.remapping[0][1]
    is_ours = (content.state.package, content.state.name) == WRITER and child.label == f"Set {key}"
    return Pair(key, content.arguments[0].value) if is_ours else None
