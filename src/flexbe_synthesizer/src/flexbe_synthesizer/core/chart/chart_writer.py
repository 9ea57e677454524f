"""Write charts as XML: a whole new file, or the lines of an element that joins one."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element as XmlElement

from flexbe_synthesizer.core.chart.error_routes import format_routes
from flexbe_synthesizer.core.chart.grammar import EXTENSION
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Chart,
    Condition,
    Connection,
    Container,
    ContainerKind,
    Element,
    Input,
    Outcome,
    Output,
    Point,
    State,
    Transition,
    format_literal,
)

_ESCAPED = {"&": "&amp;", "<": "&lt;", ">": "&gt;", "\n": "&#10;", "\t": "&#9;", "\r": "&#13;"}
_TO_ESCAPE = re.compile(r"""[&<>\n\t\r"']""")
_NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@dataclass(frozen=True)
class Style:
    """How elements are written.

    Attributes:
        indent: blanks of one level.
        quote: what attributes stand in.
        end: how an element without content ends.
        prefix: prefix of the extension's namespace.
    """

    indent: str = "  "
    quote: str = '"'
    end: str = "/>"
    prefix: str = "ext"

    def spelled(self, name: str) -> str:
        """Return the name of an element or attribute with the prefix that the file has."""
        return f"{self.prefix}:{name[4:]}" if name.startswith("ext:") else name


def write_chart(chart: Chart) -> str:
    """Return the XML text of a chart; `parse_chart` reads it as an equal one.

    Raises:
        ValueError: if it holds a character that no XML file can.
    """
    root, style = chart_part(chart), Style()
    declared = f' xmlns:ext="{EXTENSION}"' if root.is_extended() else ""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>']
    lines.append(f"<statemachine{declared}{_attributes(root, style)}>")
    if chart.description:
        lines.append(style.indent + comment(chart.description, f"\n{' ' * 7}"))
    for child in root.children:
        lines += (style.indent + line for line in part_lines(child, style))
    lines.append("</statemachine>\n")
    return expect_xml("\n".join(lines))


def part_lines(part: Part, style: Style) -> Iterator[str]:
    """Yield the lines of an element, the first one without blanks before it."""
    tag = style.spelled(part.tag)
    head = f"<{tag}{_attributes(part, style)}"
    if not part.children:
        yield head + style.end
        return
    yield f"{head}>"
    for child in part.children:
        yield from (style.indent + line for line in part_lines(child, style))
    yield f"</{tag}>"


def comment(description: str, newline: str) -> str:
    """Return the comment of a description; `newline` is what its lines are joined with."""
    aligned = description.replace("\n", newline)
    return expect_xml(f"<!-- {aligned} -->")


def attribute(name: str, value: str, style: Style) -> str:
    """Return an attribute and its value, quoted."""
    return f"{style.spelled(name)}={style.quote}{escaped(value, style.quote)}{style.quote}"


def escaped(value: str, quote: str) -> str:
    """Return an attribute's value as it stands between such quotes.

    Raises:
        ValueError: if it holds a character that no XML file can.
    """
    names = _ESCAPED | {quote: "&quot;" if quote == '"' else "&apos;"}
    return expect_xml(_TO_ESCAPE.sub(lambda found: names.get(found[0], found[0]), value))


def expect_xml(text: str) -> str:
    """Return the text.

    Raises:
        ValueError: if it holds a character that no XML file can.
    """
    found = _NO_XML.search(text)
    if found:
        raise ValueError(
            f"the character U+{ord(found[0]):04X} cannot stand in an XML file; delete it"
        )
    return text


def _attributes(part: Part, style: Style) -> str:
    return "".join(f" {attribute(*given, style)}" for given in part.attributes.items())


# A chart as the XML elements that spell it, in the order of the language, free of any layout


@dataclass
class Part:
    """An element of a chart.

    Attributes:
        tag: its name as the grammar spells it, `state` or `ext:container`.
        attributes: values by name, those of the extension as `ext:attempts`.
        children: the elements in it.
        source: the element of a file that it was read from.
    """

    tag: str
    attributes: dict[str, str]
    children: list[Part] = field(default_factory=list)
    source: XmlElement | None = field(default=None, compare=False)

    def is_extended(self) -> bool:
        """Return whether the element, or one in it, needs the extension's namespace."""
        return (
            self.tag.startswith("ext:")
            or any(name.startswith("ext:") for name in self.attributes)
            or any(child.is_extended() for child in self.children)
        )


def chart_part(chart: Chart) -> Part:
    """Return the outermost element of a chart."""
    root = _part("statemachine", chart, name=chart.name, initial=chart.initial)
    about = {"ext:author": chart.author, "ext:tags": chart.tags}
    root.attributes |= {name: text for name, text in about.items() if text}
    root.children.extend(_body(chart))
    return root


def _body(chart: Chart) -> Iterator[Part]:
    """Yield what is in a chart or container: datamodel, nodes, conditions, connections."""
    model = Part("datamodel", {})
    model.children += map(_outcome, chart.outcomes)
    for port in chart.inputs:
        part = _port("input", port)
        if port.default is not None:
            part.attributes["ext:default"] = format_literal(port.default, port.type)
        model.children.append(part)
    model.children += (_port("output", port) for port in chart.outputs)
    yield model
    yield from map(_node, chart.nodes)
    yield from map(_condition, chart.conditions)
    yield from map(_connection, chart.connections)


def _outcome(outcome: Outcome) -> Part:
    part = _part("outcome", outcome, name=outcome.name)
    if outcome.at is not None:
        part.attributes["ext:at"] = _point_text(outcome.at)
    return part


def _point_text(point: Point) -> str:
    return f"{point[0]} {point[1]}"


def _node(node: AnyNode) -> Part:
    if isinstance(node, Container):
        starts = node.runs is not ContainerKind.CONCURRENCY  # else all that is in it does
        initial = (node.body.initial or None) if starts else None
        part = _part(f"ext:{node.type}", node, id=node.id, initial=initial)
    else:
        topic = node.topic if isinstance(node, State) else None
        part = _part(node.kind, node, id=node.id, type=node.type, topic=topic)
    limits = {
        "ext:attempts": None if node.attempts is None else str(node.attempts),
        "ext:timeout_s": None if node.timeout_s is None else format_literal(node.timeout_s),
        "ext:on_error": format_routes(node.on_error) if node.on_error else None,
        "ext:at": None if node.at is None else _point_text(node.at),
    }
    part.attributes |= {name: value for name, value in limits.items() if value is not None}
    if isinstance(node, Container):
        part.children += _body(node.body)
    part.children += (_port("input", port) for port in node.inputs)
    part.children += (_port("output", port) for port in node.outputs)
    part.children += (
        _part("param", param, name=param.name, value=param.text) for param in node.params
    )
    part.children += map(_transition, node.transitions)
    return part


def _transition(transition: Transition) -> Part:
    part = _part("transition", transition, event=transition.event, target=transition.target)
    if transition.autonomy:
        part.attributes["ext:autonomy"] = transition.autonomy.value
    return part


def _condition(condition: Condition) -> Part:
    part = _part("ext:condition", condition, outcome=condition.outcome)
    part.children += (
        _part("ext:when", when, state=when.state, event=when.event) for when in condition.all_of
    )
    return part


def _connection(flow: Connection) -> Part:
    return _part(
        "connection",
        flow,
        output_state_id=flow.output_state_id,
        output=flow.output,
        input_state_id=flow.input_state_id,
        input=flow.input,
    )


def _port(tag: str, port: Input | Output) -> Part:
    return _part(tag, port, name=port.name, type=port.type)


def _part(tag: str, element: Element, **attributes: str | None) -> Part:
    """Return the part of an element of the model, without the attributes that are None."""
    given = {name: value for name, value in attributes.items() if value is not None}
    return Part(tag, given, source=element.source[1] if element.source else None)
