"""Write charts as XML: the one writer of the chart language."""

from __future__ import annotations

from lxml import etree

from flexbe_synthesizer.core.error_routes import format_routes
from flexbe_synthesizer.core.grammar import EXTENSION
from flexbe_synthesizer.core.literal import format_literal
from flexbe_synthesizer.core.model import AnyNode, Chart, Container, Input, Output, State


def write_chart(chart: Chart) -> str:
    """Return the XML text of a chart; `parse_chart` reads it as an equal one."""
    root = etree.Element("statemachine", nsmap={"ext": EXTENSION} if _is_extended(chart) else None)
    _set(root, name=chart.name, initial=chart.initial)
    if chart.description:
        aligned = chart.description.replace("\n", "\n       ")
        root.append(etree.Comment(f" {aligned} "))
    _add_parts(root, chart)
    etree.indent(root)
    text: str = etree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _is_extended(chart: Chart) -> bool:
    """Tell whether the chart says anything that only the extension can say."""
    return any(port.default is not None for port in chart.inputs) or any(
        isinstance(node, Container)
        or node.attempts is not None
        or node.timeout_s is not None
        or node.on_error
        or any(transition.autonomy for transition in node.transitions)
        for node in chart.nodes
    )


def _add_parts(parent: etree._Element, chart: Chart) -> None:
    """Append the datamodel, the nodes, the conditions and the connections of a chart."""
    model = etree.SubElement(parent, "datamodel")
    for outcome in chart.outcomes:
        _set(etree.SubElement(model, "outcome"), name=outcome.name)
    for port in chart.inputs:
        default = None if port.default is None else format_literal(port.default)
        _set_extended(_add_port(model, "input", port), default=default)
    for output in chart.outputs:
        _add_port(model, "output", output)
    for node in chart.nodes:
        _add_node(parent, node)
    for condition in chart.conditions:
        element = etree.SubElement(parent, f"{{{EXTENSION}}}condition", outcome=condition.outcome)
        for when in condition.all_of:
            _set(
                etree.SubElement(element, f"{{{EXTENSION}}}when"),
                state=when.state,
                event=when.event,
            )
    for flow in chart.connections:
        _set(
            etree.SubElement(parent, "connection"),
            output_state_id=flow.output_state_id,
            output=flow.output,
            input_state_id=flow.input_state_id,
            input=flow.input,
        )


def _add_node(parent: etree._Element, node: AnyNode) -> None:
    """Append a state, behavior or container."""
    if isinstance(node, Container):
        element = etree.SubElement(parent, f"{{{EXTENSION}}}{node.type}")
        _set(element, id=node.id, initial=node.body.initial or None)
    else:
        element = etree.SubElement(parent, node.kind)
        topic = node.topic if isinstance(node, State) else None
        _set(element, id=node.id, type=node.type, topic=topic)
    attempts = None if node.attempts is None else str(node.attempts)
    timeout = None if node.timeout_s is None else format_literal(node.timeout_s)
    on_error = format_routes(node.on_error) if node.on_error else None
    _set_extended(element, attempts=attempts, timeout_s=timeout, on_error=on_error)
    if isinstance(node, Container):
        _add_parts(element, node.body)
    for port in node.inputs:
        _add_port(element, "input", port)
    for output in node.outputs:
        _add_port(element, "output", output)
    for param in node.params:
        value = format_literal(param.value)
        _set(etree.SubElement(element, "param"), name=param.name, value=value)
    for transition in node.transitions:
        child = etree.SubElement(element, "transition")
        _set(child, event=transition.event, target=transition.target)
        _set_extended(child, autonomy=transition.autonomy.value if transition.autonomy else None)


def _add_port(parent: etree._Element, tag: str, port: Input | Output) -> etree._Element:
    element = etree.SubElement(parent, tag)
    _set(element, name=port.name, type=port.type)
    return element


def _set(element: etree._Element, **attributes: str | None) -> None:
    for name, value in attributes.items():
        if value is not None:
            element.set(name, value)


def _set_extended(element: etree._Element, **attributes: str | None) -> None:
    for name, value in attributes.items():
        if value is not None:
            element.set(f"{{{EXTENSION}}}{name}", value)
