"""Have behaviors leave to their supervisor what it is to handle first."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Chart,
    Connection,
    ErrorRoute,
    State,
    Transition,
)
from remodel_planner.core.use_case.task_chart import marked

_FAILED, _REFUSED = "failed", "command_error"


def escalating(chart: Chart, codes: Collection[int], undone: Collection[int] = ()) -> Chart:
    """Return a task's chart in which failures with some error codes are not tried again.

    They lead to where the state is given up: to where a goal leads that is refused. Where a failure
    is undone before the state is tried again, such as an insertion by an extraction, it is undone
    before the state is given up as well: nobody carries away a wire that is jammed in its terminal.

    Args:
        chart: of a task.
        codes: remodel_msgs/ErrorCode.
        undone: those of them that are undone first, where the chart says how.
    """
    nodes = {node.id: node for node in chart.nodes}
    leaving: list[AnyNode] = []
    last: dict[str, State] = {}
    for node in chart.nodes:
        undoing = _undoing(node, nodes) if set(undone) & set(codes) else None
        if undoing is not None:
            last[undoing.id] = _at_last(undoing)
        leaving.append(_leaving(node, codes, undone, last[undoing.id].id if undoing else ""))
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


def _leaving(node: AnyNode, codes: Collection[int], undone: Collection[int], undo: str) -> AnyNode:
    """Return a node that leaves with some codes; by way of the node `undo` if there is one."""
    if not isinstance(node, State) or node.on_error:
        return node
    targets = _targets(node)
    up = targets.get(_REFUSED)
    if up is None or _FAILED not in targets or targets[_FAILED] == up:
        return node
    first = set(undone) & set(codes) if undo else set()
    routes = [ErrorRoute(low, high, up) for low, high in _ranges(set(codes) - first)]
    routes += [ErrorRoute(low, high, undo) for low, high in _ranges(first)]
    return replace(node, on_error=tuple(sorted(routes, key=lambda route: route.first)))


def _targets(node: State) -> dict[str, str]:
    return {transition.event: transition.target for transition in node.transitions}


def _ranges(codes: Collection[int]) -> Iterator[tuple[int, int]]:
    """Yield first and last of each row of numbers without a gap."""
    first = None
    for code in sorted(codes):
        if first is None:
            first = code
        if code + 1 not in codes:
            yield first, code
            first = None
