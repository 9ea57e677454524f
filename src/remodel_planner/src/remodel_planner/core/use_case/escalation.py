"""Have behaviors leave to their supervisor what it is to handle first."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

from flexbe_synthesizer.core.model import AnyNode, Chart, ErrorRoute, State
from remodel_planner.core.use_case.task_chart import marked

_FAILED, _REFUSED = "failed", "command_error"


def escalating(chart: Chart, codes: Collection[int]) -> Chart:
    """Return a task's chart in which failures with some error codes are not tried again.

    They lead to where the state is given up: to where a goal leads that is refused.

    Args:
        chart: of a task.
        codes: remodel_msgs/ErrorCode.
    """
    return marked(replace(chart, nodes=tuple(_leaving(node, codes) for node in chart.nodes)))


def _leaving(node: AnyNode, codes: Collection[int]) -> AnyNode:
    if not isinstance(node, State) or node.on_error:
        return node
    targets = {transition.event: transition.target for transition in node.transitions}
    up = targets.get(_REFUSED)
    if up is None or _FAILED not in targets or targets[_FAILED] == up:
        return node
    routes = tuple(ErrorRoute(first, last, up) for first, last in _ranges(codes))
    return replace(node, on_error=routes)


def _ranges(codes: Collection[int]) -> Iterator[tuple[int, int]]:
    """Yield first and last of each row of numbers without a gap."""
    first = None
    for code in sorted(codes):
        if first is None:
            first = code
        if code + 1 not in codes:
            yield first, code
            first = None
