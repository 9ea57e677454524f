"""The one reader and writer of the chart language.

Reading reports everything that does not fit the grammar and goes on with the rest; a required
attribute that is missing reads as the empty string, which the checks pass over.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeVar

from lxml import etree

from flexbe_synthesizer.core import names
from flexbe_synthesizer.core.grammar import (
    EXTENSION,
    NODE_CHILDREN,
    OUTCOME,
    PORT,
    STATEMACHINE,
    Shape,
    homes,
)
from flexbe_synthesizer.core.literal import format_literal, parse_literal
from flexbe_synthesizer.core.model import (
    Autonomy,
    Behavior,
    Chart,
    Connection,
    Input,
    Outcome,
    Output,
    Param,
    Source,
    State,
    Transition,
)
from flexbe_synthesizer.core.problem import ChartError, Code, Position, Problem, errors_in
from flexbe_synthesizer.core.xml_reader import XmlElement, read_xml

_SCHEMA_INSTANCE = "http://www.w3.org/2001/XMLSchema-instance"  # an editor's pointer to a schema
_MAY_BE_EMPTY = ("value",)
_Value = TypeVar("_Value")


def parse_chart(source: str | bytes, file: str = "<chart>") -> Chart:
    """Return the chart that an XML text holds, as far as its form goes; `check` proves the rest.

    Raises:
        ChartError: if the text does not have the form of a chart.
    """
    chart, problems = read_chart(source, file)
    if chart is None or errors_in(problems):
        raise ChartError(problems)
    return chart


def read_chart(source: str | bytes, file: str) -> tuple[Chart | None, tuple[Problem, ...]]:
    """Return what can be read of the chart, if anything, and what is wrong with its form."""
    try:
        document = read_xml(source, file)
    except ChartError as error:
        return None, error.problems
    reader = _ChartReader(file)
    reader.problems.extend(document.problems)
    root = document.root
    if (root.namespace, root.name) != ("", "statemachine"):
        message = f"found {_shown(root)}; a chart's outermost element is <statemachine>."
        reader.report(root.position, Code.UNKNOWN_ELEMENT, message)
        return None, tuple(reader.problems)
    description = root.comment or document.comment or ""
    return reader.chart(root, description), tuple(reader.problems)


def _shown(element: XmlElement) -> str:
    """Return the element's tag as a message shows it."""
    inside = f" in namespace '{element.namespace}'" if element.namespace else ""
    return f"<{element.name}>{inside}"


class _ChartReader:
    """Turns elements into a chart and collects what does not fit the grammar."""

    def __init__(self, file: str) -> None:
        self._file = file
        self.problems: list[Problem] = []

    def report(self, position: Position, code: Code, message: str) -> None:
        self.problems.append(Problem(position, code, message))

    def chart(self, root: XmlElement, description: str) -> Chart:
        root_fields = self._fields(root, STATEMACHINE)
        models = root_fields.children("datamodel")
        self._expect_parts(root, root_fields)
        data = [self._fields(model, STATEMACHINE.children["datamodel"]) for model in models]
        wrappers = [
            self._fields(wrapper, STATEMACHINE.children["datamodel"].children["outcomes"])
            for model in data
            for wrapper in model.children("outcomes")
        ]
        outcomes = [e for part in (*data, *wrappers) for e in part.children("outcome")]
        return Chart(
            name=root_fields.text("name"),
            initial=root_fields.text("initial"),
            outcomes=tuple(self._outcome(e) for e in sorted(outcomes, key=lambda e: e.position)),
            nodes=tuple(
                self._node(e) for e in root.children if _is_plain(e, ("state", "behavior"))
            ),
            inputs=tuple(self._machine_input(e) for part in data for e in part.children("input")),
            outputs=tuple(self._output(e) for part in data for e in part.children("output")),
            connections=tuple(self._connection(e) for e in root_fields.children("connection")),
            description=description,
            file=self._file,
            source=root_fields.source,
        )

    def _expect_parts(self, root: XmlElement, root_fields: _Fields) -> None:
        """Report a chart that lacks its parts: a datamodel, an outcome, a state or behavior."""
        models = root_fields.children("datamodel")
        wrappers = [[w for w in m.children if _is_plain(w, ("outcomes",))] for m in models]
        for first, *others in filter(None, (models, *wrappers)):
            for other in others:
                message = f"a second <{other.name}>; put what is in it into the one of line "
                message += f"{first.position.line}."
                self.report(other.position, Code.DUPLICATE_ELEMENT, message)
        if not models:
            message = "no <datamodel>; a chart needs one, with its outcomes."
            self.report(root.position, Code.MISSING_ELEMENT, message)
        elif not any(_has_outcome(model) for model in models):
            message = 'no <outcome name="..."/>; a chart ends in at least one.'
            self.report(models[0].position, Code.MISSING_ELEMENT, message)
        if not (root_fields.children("state") or root_fields.children("behavior")):
            message = "neither a <state> nor a <behavior>; a chart needs at least one."
            self.report(root.position, Code.MISSING_ELEMENT, message)

    def _outcome(self, element: XmlElement) -> Outcome:
        fields = self._fields(element, OUTCOME)
        return Outcome(fields.text("name"), source=fields.source)

    def _machine_input(self, element: XmlElement) -> Input:
        shape = STATEMACHINE.children["datamodel"].children["input"]
        fields = self._fields(element, shape)
        default = parse_literal(fields.extensions.get("default", "null"))
        return Input(fields.text("name"), fields.get("type"), default, source=fields.source)

    def _input(self, element: XmlElement) -> Input:
        fields = self._fields(element, PORT)
        return Input(fields.text("name"), fields.get("type"), source=fields.source)

    def _output(self, element: XmlElement) -> Output:
        fields = self._fields(element, PORT)
        return Output(fields.text("name"), fields.get("type"), source=fields.source)

    def _param(self, element: XmlElement) -> Param:
        fields = self._fields(element, NODE_CHILDREN["param"])
        return Param(fields.text("name"), parse_literal(fields.text("value")), source=fields.source)

    def _transition(self, element: XmlElement) -> Transition:
        fields = self._fields(element, NODE_CHILDREN["transition"])
        levels = f"one of {names.quoted(level.value for level in Autonomy)}"
        autonomy = self._convert(fields, "autonomy", Autonomy, levels, Autonomy.OFF)
        return Transition(
            fields.text("event"), fields.text("target"), autonomy, source=fields.source
        )

    def _connection(self, element: XmlElement) -> Connection:
        fields = self._fields(element, STATEMACHINE.children["connection"])
        return Connection(
            fields.text("output_state_id"),
            fields.text("output"),
            fields.text("input_state_id"),
            fields.text("input"),
            source=fields.source,
        )

    def _node(self, element: XmlElement) -> State | Behavior:
        fields = self._fields(element, STATEMACHINE.children[element.name])
        attempts = self._convert(fields, "attempts", _at_least_one, "an integer from 1", 1)
        timeout_s = self._convert(
            fields, "timeout_s", _positive, "a number of seconds above 0", 1.0
        )
        parts = (
            fields.text("id"),
            fields.text("type"),
            tuple(map(self._transition, fields.children("transition"))),
            tuple(map(self._input, fields.children("input"))),
            tuple(map(self._output, fields.children("output"))),
            tuple(map(self._param, fields.children("param"))),
            attempts,
            timeout_s,
        )
        if element.name == "behavior":
            return Behavior(*parts, source=fields.source)
        return State(*parts, topic=fields.get("topic"), source=fields.source)

    def _convert(
        self,
        fields: _Fields,
        name: str,
        convert: Callable[[str], _Value],
        allowed: str,
        instead: _Value,
    ) -> _Value | None:
        """Return an extension attribute's value, None if it is absent.

        One that is not allowed is reported and replaced, so that the rest is checked as if mended.
        """
        text = fields.extensions.get(name)
        if text is None:
            return None
        try:
            return convert(text)
        except ValueError:
            message = f"{name}='{text}' is not allowed; give {allowed}."
            self.report(fields.source.attributes[name], Code.INVALID_VALUE, message)
            return instead

    def _fields(self, element: XmlElement, shape: Shape) -> _Fields:
        """Return the element's parts, and report those that its shape does not have."""
        plain: dict[str, str] = {}
        extensions: dict[str, str] = {}
        places: dict[str, Position] = {}
        for attribute in element.attributes:
            if attribute.namespace == EXTENSION and attribute.name in shape.extensions:
                extensions[attribute.name] = attribute.value
                places[attribute.name] = attribute.position
            elif attribute.namespace == EXTENSION:
                self._report_extension(attribute.position, f"ext:{attribute.name}", element, shape)
            elif attribute.namespace == _SCHEMA_INSTANCE:
                continue
            elif attribute.namespace or attribute.name not in shape.attributes:
                self._report_attribute(attribute.position, attribute.name, element, shape)
            elif attribute.value == "" and attribute.name not in _MAY_BE_EMPTY:
                message = f"{attribute.name} of <{element.name}> is empty; give it a value."
                self.report(attribute.position, Code.MISSING_ATTRIBUTE, message)
                plain[attribute.name] = ""
            else:
                plain[attribute.name] = attribute.value
                places[attribute.name] = attribute.position
        for name in shape.required:
            if name not in plain:
                message = f"<{element.name}> has no attribute {name}; it needs " + ", ".join(
                    shape.required
                )
                self.report(element.position, Code.MISSING_ATTRIBUTE, message + ".")
        if element.text is not None:
            message = f"text inside <{element.name}>; a chart holds elements and comments only."
            self.report(element.text, Code.UNEXPECTED_TEXT, message)
        for child in element.children:
            self._expect_child(child, element, shape)
        return _Fields(plain, extensions, Source(element.position, places), element.children)

    def _report_extension(
        self, position: Position, found: str, element: XmlElement, shape: Shape
    ) -> None:
        has = ", ".join(f"ext:{name}" for name in shape.extensions) or "none"
        message = f"{found} is no extension of <{element.name}>; it has: {has}."
        self.report(position, Code.UNKNOWN_EXTENSION, message)

    def _report_attribute(
        self, position: Position, found: str, element: XmlElement, shape: Shape
    ) -> None:
        if found in shape.extensions:
            hint = f'it is an extension: write ext:{found}, with xmlns:ext="{EXTENSION}" on top.'
        else:
            hint = names.allowed(found, shape.attributes)
        message = f"<{element.name}> has no attribute '{found}'; {hint}"
        self.report(position, Code.UNKNOWN_ATTRIBUTE, message)

    def _expect_child(self, child: XmlElement, element: XmlElement, shape: Shape) -> None:
        """Report a child element that the shape does not have."""
        if child.namespace == EXTENSION:
            message = f"the extension has no element <{child.name}>, only attributes: ext:attempts"
            message += ", ext:timeout_s, ext:default, ext:autonomy."
            self.report(child.position, Code.UNKNOWN_EXTENSION, message)
        elif child.namespace:
            message = f"{_shown(child)}; the elements of a chart have no namespace: drop the xmlns."
            self.report(child.position, Code.UNKNOWN_ELEMENT, message)
        elif child.name not in shape.children:
            places = homes(child.name)
            if places:
                message = f"<{child.name}> does not belong in <{element.name}>, but in "
                message += " or ".join(f"<{home}>" for home in places) + "."
                self.report(child.position, Code.MISPLACED_ELEMENT, message)
            else:
                hint = names.allowed(child.name, shape.children)
                message = f"<{child.name}> in <{element.name}> is unknown; {hint}"
                self.report(child.position, Code.UNKNOWN_ELEMENT, message)


@dataclass(frozen=True)
class _Fields:
    """The parts of one element."""

    plain: Mapping[str, str]
    extensions: Mapping[str, str]
    source: Source
    elements: tuple[XmlElement, ...]

    def text(self, name: str) -> str:
        return self.plain.get(name, "")

    def get(self, name: str) -> str | None:
        return self.plain.get(name) or None

    def children(self, name: str) -> tuple[XmlElement, ...]:
        return tuple(child for child in self.elements if _is_plain(child, (name,)))


def _is_plain(element: XmlElement, tags: tuple[str, ...]) -> bool:
    return not element.namespace and element.name in tags


def _has_outcome(model: XmlElement) -> bool:
    """Tell whether a datamodel holds an outcome, directly or in a wrapper."""
    wrappers = [child for child in model.children if _is_plain(child, ("outcomes",))]
    within = (*model.children, *(child for wrapper in wrappers for child in wrapper.children))
    return any(_is_plain(child, ("outcome",)) for child in within)


def _at_least_one(text: str) -> int:
    value = parse_literal(text)
    if type(value) is not int or value < 1:
        raise ValueError(text)
    return value


def _positive(text: str) -> float:
    value = parse_literal(text)
    if type(value) not in (int, float) or not 0 < float(text) < math.inf:
        raise ValueError(text)
    return float(text)


def write_chart(chart: Chart) -> str:
    """Return the XML text of a chart; `parse_chart` reads it as an equal one."""
    root = etree.Element("statemachine", nsmap={"ext": EXTENSION} if _is_extended(chart) else None)
    _set(root, name=chart.name, initial=chart.initial)
    if chart.description:
        aligned = chart.description.replace("\n", "\n       ")
        root.append(etree.Comment(f" {aligned} "))
    model = etree.SubElement(root, "datamodel")
    for outcome in chart.outcomes:
        _set(etree.SubElement(model, "outcome"), name=outcome.name)
    for port in chart.inputs:
        default = None if port.default is None else format_literal(port.default)
        _set_extended(_add_port(model, "input", port), default=default)
    for output in chart.outputs:
        _add_port(model, "output", output)
    for node in chart.nodes:
        _add_node(root, node)
    for flow in chart.connections:
        _set(
            etree.SubElement(root, "connection"),
            output_state_id=flow.output_state_id,
            output=flow.output,
            input_state_id=flow.input_state_id,
            input=flow.input,
        )
    etree.indent(root)
    text: str = etree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _is_extended(chart: Chart) -> bool:
    """Tell whether the chart says anything that only the extension can say."""
    return any(port.default is not None for port in chart.inputs) or any(
        node.attempts is not None
        or node.timeout_s is not None
        or any(transition.autonomy for transition in node.transitions)
        for node in chart.nodes
    )


def _add_node(root: etree._Element, node: State | Behavior) -> None:
    """Append a state or behavior to the root element."""
    element = etree.SubElement(root, "state" if isinstance(node, State) else "behavior")
    topic = node.topic if isinstance(node, State) else None
    _set(element, id=node.id, type=node.type, topic=topic)
    attempts = None if node.attempts is None else str(node.attempts)
    timeout = None if node.timeout_s is None else format_literal(node.timeout_s)
    _set_extended(element, attempts=attempts, timeout_s=timeout)
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
