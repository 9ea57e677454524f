"""Leave to the supervisor the faults that it is to handle first."""

from __future__ import annotations

from dataclasses import replace

from flexbe_synthesizer.core.chart.error_routes import ABOVE_BEHAVIOR, SERIOUS
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Chart,
    Connection,
    ErrorRoute,
    State,
    Transition,
)
from remodel_tasks.core.task_charts.task_chart import marked

_FAILED, _REFUSED = "failed", "command_error"


def escalating(chart: Chart) -> Chart:
    """Return a task's chart in which what a supervisor handles first is not tried again.

    Such failures lead to where the state is given up: to where a goal leads that is refused. Where
    a failure is undone before the state is tried again, such as an insertion by an extraction, it
    is undone before the state is given up as well: a wire that is jammed in its terminal cannot be
    carried away. What is serious is left as it is: the arm may be blocked, or its server
    unreliable.
    """
    nodes = {node.id: node for node in chart.nodes}
    leaving: list[AnyNode] = []
    last: dict[str, State] = {}
    for node in chart.nodes:
        undoing = _undoing(node, nodes)
        if undoing is not None:
            last[undoing.id] = _at_last(undoing)
        leaving.append(_leaving(node, last[undoing.id].id if undoing else ""))
    connections = tuple(
        Connection(each.output_state_id, each.output, last[each.input_state_id].id, each.input)
        for each in chart.connections
        if each.input_state_id in last
    )
    return marked(
        replace(
            chart,
            nodes=(*leaving, *last.values()),
            connections=(*chart.connections, *connections),
        )
    )


def _undoing(node: AnyNode, nodes: dict[str, AnyNode]) -> State | None:
    """Return the state that undoes the failure of a state before it is tried again, if any.

    It stands beside the sequence: it has no outputs, and is given up where the failed one is.
    """
    if not isinstance(node, State):
        return None
    targets = _targets(node)
    undoing = nodes.get(targets.get(_FAILED, ""))
    if not isinstance(undoing, State) or undoing.outputs:
        return None
    up = targets.get(_REFUSED)
    goes_on = set(_targets(undoing).values()) - {up}
    return undoing if goes_on and _targets(undoing).get(_FAILED) == up else None


def _at_last(undoing: State) -> State:
    """Return a state that undoes a failure, after which the task is given up."""
    up = _targets(undoing)[_FAILED]
    transitions = tuple(Transition(each.event, up) for each in undoing.transitions)
    return replace(undoing, id=f"{undoing.id} and give up", transitions=transitions)


def _leaving(node: AnyNode, undo: str) -> AnyNode:
    """Return a node that is left with such codes; through the node `undo` if there is one."""
    if not isinstance(node, State) or node.on_error:
        return node
    targets = _targets(node)
    up = targets.get(_REFUSED)
    if up is None or _FAILED not in targets or targets[_FAILED] == up:
        return node
    if not undo:
        return replace(node, on_error=(ErrorRoute(ABOVE_BEHAVIOR, up),))
    routes = (ErrorRoute(SERIOUS, up), ErrorRoute(ABOVE_BEHAVIOR, undo))
    return replace(node, on_error=routes)


def _targets(node: State) -> dict[str, str]:
    return {transition.event: transition.target for transition in node.transitions}
