"""Change the parameters of a task's states, for another attempt."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Behavior,
    Chart,
    Container,
    ContainerKind,
    Param,
    State,
)
from remodel_planning.core.task_charts.state_path import step_of
from remodel_planning.core.task_charts.task_chart import marked
from remodel_supervision.core.recovery.decide import VIEW

_INTEGERS = ("int", "uint")


@dataclass(frozen=True)
class Adjustable:
    """Whose parameters can be changed.

    Attributes:
        parameters: ability -> its goal's parameters by name, with their ROS types.
        nested: charts of the behaviors that tasks nest, by name.
    """

    parameters: Mapping[str, Mapping[str, str]]
    nested: Mapping[str, Chart]


def with_parameters(
    chart: Chart, state_path: str, values: Mapping[str, float], adjustable: Adjustable
) -> Chart:
    """Return a task's chart with other parameters of the node that has failed.

    A behavior nested there becomes a container with the same states, under the same names.

    Args:
        chart: of the task.
        state_path: of the state that failed.
        values: parameter -> value.
        adjustable: see Adjustable.
    """
    failed = step_of(state_path)
    nodes = tuple(
        _changed(node, values, adjustable) if node.id == failed else node for node in chart.nodes
    )
    return marked(replace(chart, nodes=nodes))


def observing_from(chart: Chart, view: int, adjustable: Adjustable) -> Chart:
    """Return a task's chart in which everything is observed from another viewpoint.

    All observations change, not only those of the step that failed: a step often fails by what
    another one before it has seen. Behaviors that nest observations become containers.

    Args:
        chart: of the task.
        view: 0 the usual viewpoint, 1 and up others.
        adjustable: see Adjustable.
    """
    nodes = tuple(_changed(node, {VIEW: view}, adjustable) for node in chart.nodes)
    return marked(replace(chart, nodes=nodes))


def _changed(node: AnyNode, values: Mapping[str, float], adjustable: Adjustable) -> AnyNode:
    if isinstance(node, State):
        taken = adjustable.parameters.get(node.type.removesuffix("State"), {})
        new = tuple(
            Param(name, _literal(value, taken[name]))
            for name, value in values.items()
            if name in taken
        )
        kept = tuple(p for p in node.params if p.name not in {param.name for param in new})
        return replace(node, params=(*kept, *new))
    if isinstance(node, Behavior) and node.type in adjustable.nested:
        inner = adjustable.nested[node.type]
        nodes = tuple(_changed(each, values, adjustable) for each in inner.nodes)
        if nodes == inner.nodes:
            return node
        body = replace(
            inner,
            name=node.id,
            description="",
            inputs=tuple(replace(each, default=None) for each in inner.inputs),
            nodes=nodes,
        )
        return Container(
            node.id,
            ContainerKind.SEQUENCE.value,
            node.transitions,
            attempts=node.attempts,
            timeout_s=node.timeout_s,
            on_error=node.on_error,
            body=body,
        )
    if isinstance(node, Container):
        inside = tuple(_changed(each, values, adjustable) for each in node.body.nodes)
        return replace(node, body=replace(node.body, nodes=inside))
    return node


def _literal(value: float, ros_type: str) -> float:
    """Return a value as a field of a ROS type takes it: whole numbers where it takes no others."""
    return int(value) if ros_type.startswith(_INTEGERS) else value
