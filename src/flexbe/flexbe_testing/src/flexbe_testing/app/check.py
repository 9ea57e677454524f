"""What the App demands of a behavior before it saves it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping

from flexbe_testing.app.behavior import AppBehavior, Child, Container, StateUse
from flexbe_testing.app.text import is_balanced


def check_behavior(behavior: AppBehavior) -> Iterator[str]:
    """Yield why the App refuses to save a behavior."""
    for what in ("name", "description", "author"):
        if not getattr(behavior, what):
            yield f"the behavior has no {what}"
    for key in dict.fromkeys((*behavior.root.input_keys, *behavior.root.output_keys)):
        if key not in behavior.userdata:
            yield f"no default userdata for the key '{key}' of the interface"
    yield from _check_container(behavior.root, "", behavior.userdata)


def _check_container(container: Container, path: str, available: Collection[str]) -> Iterator[str]:
    title = path or "/"
    if not container.outcomes:
        yield f"container '{title}' has no outcomes"
    if not container.children:
        yield f"container '{title}' has no states"
    for label, count in Counter(child.label for child in container.children).items():
        if count > 1 or label in container.outcomes:
            yield f"'{label}' in '{title}' is used more than once there"
    writers = _writers_before(container)
    for child in container.children:
        inner = f"{path}/{child.label}"
        yield from _check_child(child, inner)
        written = {home for other in writers[child.label] for home in _written(other)}
        for key in child.content.input_keys:
            home = child.remapping[key]
            if home not in written and home not in available:
                yield f"input '{key}' of '{inner}': nothing before it writes '{home}'"
        if isinstance(child.content, Container):
            yield from _check_container(child.content, inner, child.content.input_keys)
    if container.is_concurrent:
        yield from _check_conditions(container, title)


def _check_child(child: Child, path: str) -> Iterator[str]:
    if not child.content.outcomes:
        yield f"'{path}' has no outcomes that the App can read"
    for outcome in child.content.outcomes:
        if outcome not in child.transitions:
            yield f"outcome '{outcome}' of '{path}' is not connected"
    for key in (*child.remapping, *child.remapping.values()):
        if not key.isidentifier():
            yield f"the key '{key}' of '{path}' is not an identifier"
    if isinstance(child.content, StateUse):
        for name in child.content.definition.parameters:
            value = child.content.value(name)
            if not value:
                yield (
                    f"parameter '{name}' of '{path}' is empty: the App takes `()`, and what "
                    "follows a trailing comma, for an empty first value; give one by name"
                )
            elif not is_balanced(value):
                yield (
                    f"parameter '{name}' of '{path}' has a bracket or quote that does not close: "
                    f"{value}"
                )
    elif isinstance(child.content, Container) and not _variable_part(child.label).isidentifier():
        yield (
            f"it would name a variable '{_variable_part(child.label)}_0' after container "
            f"'{path}', which is not Python"
        )


def _variable_part(label: str) -> str:
    return "_sm_" + label.lower().replace(" ", "_")


def _check_conditions(container: Container, title: str) -> Iterator[str]:
    listed = [pair for _outcome, pairs in container.conditions for pair in pairs]
    for pair, count in Counter(listed).items():
        if count > 1:
            yield f"outcome '{pair[1]}' of '{title}/{pair[0]}' is in two conditions"
    for _outcome, pairs in container.conditions:
        states = [state for state, _ in pairs]
        if len(set(states)) < len(states):
            yield f"a condition of '{title}' has two outcomes of one state"
    leads_to = {pair: outcome for outcome, pairs in container.conditions for pair in pairs}
    for child in container.children:
        for outcome, target in child.transitions.items():
            if leads_to.get((child.label, outcome)) != target:
                yield (
                    f"outcome '{outcome}' of '{title}/{child.label}' leads to '{target}', and its "
                    f"condition to '{leads_to.get((child.label, outcome))}'"
                )


def _written(child: Child) -> Iterator[str]:
    return (child.remapping[key] for key in child.content.output_keys)


def _writers_before(container: Container) -> Mapping[str, tuple[Child, ...]]:
    """Return, by label, all children from which transitions lead to one."""
    by_label = {child.label: child for child in container.children}
    before: dict[str, set[str]] = {label: set() for label in by_label}
    if not container.is_concurrent:
        for child in container.children:
            for target in child.transitions.values():
                before.get(target, set()).add(child.label)
    found = {}
    for label in by_label:
        reached, left = set(before[label]), list(before[label])
        while left:
            new = before[left.pop()] - reached
            reached |= new
            left += new
        found[label] = tuple(by_label[other] for other in reached)
    return found
