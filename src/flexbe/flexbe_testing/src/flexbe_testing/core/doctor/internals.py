"""Uses of an engine's inside, which is another one here."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from flexbe_testing.core.doctor.finding import Finding, Severity
from flexbe_testing.core.doctor.module import FlexbeClass, Kind, Module, is_self_attribute

# Attributes of stock FlexBE's states and containers that users may have come to rely on.
_OF_BOTH = {"_force_transition", "_stored_outcome", "_last_requested_outcome", "_entering"}
_OF_BOTH |= {"_skipped", "_paused", "_last_active_container", "_preempted_name", "_locked"}
_OF_BOTH |= {"_is_controlled"}
_OF_CONTAINERS = {"_inner_sync_request", "_last_exception", "_current_state", "_userdata"}
_OF_CONTAINERS |= {"_own_userdata", "_labels", "_states", "_transitions", "_remappings"}
_OF_CONTAINERS |= {"_autonomy", "_returned_outcomes"}
_PRIVATE = {Kind.STATE: _OF_BOTH, Kind.MACHINE: _OF_BOTH | _OF_CONTAINERS, Kind.BEHAVIOR: set()}
_TOPICS = {
    f"_{name}_topic"
    for name in (
        *("feedback", "transition", "lock", "unlock", "preempt", "outcome", "request"),
        *("debug", "repeat", "pause"),
    )
}

# Methods that stock FlexBE calls in a run and this engine does not: an override has no effect.
OVERRIDES = {
    Kind.STATE: {"sleep", "is_locked", "_notify_skipped"},
    Kind.MACHINE: {
        *("execute", "sleep", "is_locked", "transition_allowed", "is_transition_allowed"),
        *("get_deep_state", "get_required_autonomy", "_execute_current_state", "_notify_skipped"),
    },
    Kind.BEHAVIOR: {"prepare_for_switch"},
}

# State of stock FlexBE's process that belongs to a run here.
_PROCESS_WIDE = {
    "OperatableStateMachine.autonomy_level": "the level belongs to a behavior",
    "PreemptableState.preempt": "a preempt belongs to a behavior; call its preempt()",
    "LockableStateMachine.path_for_switch": "a switch is asked for with a start request",
    "PriorityContainer.active_container": "priority belongs to a behavior",
}


def check_internals(module: Module, attributes: frozenset[str]) -> Iterator[Finding]:
    """Find what relies on the inside of stock FlexBE.

    Args:
        module: a user's file.
        attributes: names that states and containers of this engine have.
    """
    for found in module.classes:
        yield from _check_overrides(module, found)
        yield from _check_private(module, found, attributes)
    yield from _check_process(module)


def _check_overrides(module: Module, found: FlexbeClass) -> Iterator[Finding]:
    for name in sorted(OVERRIDES[found.kind] & set(found.methods)):
        text = (
            f"{found.node.name} overrides {name}() of a {found.kind.value}, which this engine does "
            "not call in a run; use on_start, on_enter, execute, on_exit and on_stop of states"
        )
        yield module.finding(found.methods[name], "override", Severity.ERROR, text)
    for node in ast.walk(found.node):
        targets = node.targets if isinstance(node, ast.Assign) else []
        if any(is_self_attribute(target) and target.attr == "execute" for target in targets):
            text = "self.execute is replaced: this engine calls the method of the class"
            yield module.finding(node, "override", Severity.ERROR, text)


def _check_private(
    module: Module, found: FlexbeClass, attributes: frozenset[str]
) -> Iterator[Finding]:
    nodes = [node for node in ast.walk(found.node) if is_self_attribute(node)]
    own = {node.attr for node in nodes if isinstance(node.ctx, ast.Store)}
    for node in nodes:
        is_read = isinstance(node.ctx, ast.Load)
        if is_read and node.attr in _PRIVATE[found.kind] - attributes - own:
            text = f"self.{node.attr} is stock FlexBE's own, and not there on this engine"
            yield module.finding(node, "private", Severity.ERROR, text)
        elif not is_read and node.attr in _PRIVATE[found.kind]:
            text = f"self.{node.attr} is FlexBE's own: setting it acts differently here; rename it"
            yield module.finding(node, "private", Severity.WARNING, text)
        elif not is_read and node.attr in _TOPICS and found.kind is Kind.STATE:
            text = f"self.{node.attr} breaks the state on stock FlexBE; rename it"
            yield module.finding(node, "private", Severity.NOTE, text)


def _check_process(module: Module) -> Iterator[Finding]:
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            name = ".".join(module.dotted(node).split(".")[-2:])
            if name in _PROCESS_WIDE:
                text = f"{name} is set for the whole process: {_PROCESS_WIDE[name]}"
                yield module.finding(node, "process-wide", Severity.WARNING, text)
