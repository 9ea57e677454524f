"""The one reader of the chart language; its writer is in `chart_writer`.

Reading reports everything that does not fit the grammar and goes on with the rest; a required
attribute that is missing reads as the empty string, which the checks pass over.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

from flexbe_synthesizer.core import names
from flexbe_synthesizer.core.chart_writer import write_chart
from flexbe_synthesizer.core.error_routes import ROUTES_RULE, parse_routes
from flexbe_synthesizer.core.grammar import (
    CONDITION,
    EXTENSION,
    NODE,
    OUTCOME,
    PORT,
    STATEMACHINE,
    TRANSITION,
    WHEN,
    Shape,
    homes,
)
from flexbe_synthesizer.core.literal import parse_literal
from flexbe_synthesizer.core.model import (
    AnyNode,
    Autonomy,
    Behavior,
    Chart,
    Condition,
    Connection,
    Container,
    ErrorRoute,
    Input,
    Outcome,
    Output,
    Param,
    Source,
    State,
    Transition,
    When,
)
from flexbe_synthesizer.core.problem import ChartError, Code, Position, Problem, errors_in
from flexbe_synthesizer.core.xml_reader import XmlElement, read_xml

__all__ = ["EXTENSION", "parse_chart", "read_chart", "write_chart"]

_SCHEMA_INSTANCE = "http://www.w3.org/2001/XMLSchema-instance"  # an editor's pointer to a schema
DEEPEST = 16  # containers inside each other; who needs more has lost the overview of the chart
_MAY_BE_EMPTY = ("value",)
_NODES = {"state", "behavior", "ext:container", "ext:concurrency", "ext:priority"}
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
    return f"<{_tag(element)}>{inside}"


class _ChartReader:
    """Turns elements into a chart and collects what does not fit the grammar."""

    def __init__(self, file: str) -> None:
        self._file = file
        self._depth = 0
        self.problems: list[Problem] = []

    def report(self, position: Position, code: Code, message: str) -> None:
        self.problems.append(Problem(position, code, message))

    def chart(self, root: XmlElement, description: str) -> Chart:
        """Return the chart of the outermost element."""
        fields = self._fields(root, STATEMACHINE)
        name, source = fields.text("name"), fields.source
        chart = self._body(root, fields, STATEMACHINE, name, source)
        return replace(chart, description=description, file=self._file)

    def _body(
        self, element: XmlElement, fields: _Fields, shape: Shape, name: str, source: Source
    ) -> Chart:
        """Return what a chart or a container holds."""
        models = fields.children("datamodel")
        self._expect_parts(element, fields)
        data_shape = shape.children["datamodel"]
        data = [self._fields(model, data_shape) for model in models]
        wrappers = [
            self._fields(wrapper, data_shape.children["outcomes"])
            for model in data
            for wrapper in model.children("outcomes")
        ]
        outcomes = [e for part in (*data, *wrappers) for e in part.children("outcome")]
        inner = fields.nodes() if self._depth <= DEEPEST else ()
        nodes = tuple(self._node(e, shape.children[_tag(e)]) for e in inner)
        return Chart(
            name=name,
            initial=fields.text("initial"),
            outcomes=tuple(self._outcome(e) for e in sorted(outcomes, key=lambda e: e.position)),
            nodes=nodes,
            inputs=tuple(
                self._input(e, data_shape.children["input"])
                for part in data
                for e in part.children("input")
            ),
            outputs=tuple(self._output(e) for part in data for e in part.children("output")),
            connections=tuple(map(self._connection, fields.children("connection"))),
            conditions=tuple(map(self._condition, fields.children("ext:condition"))),
            source=source,
        )

    def _expect_parts(self, element: XmlElement, fields: _Fields) -> None:
        """Report a chart or container that lacks a datamodel, an outcome or a state."""
        models = fields.children("datamodel")
        what = "a chart" if element.name == "statemachine" else "a container"
        wrappers = [[w for w in m.children if _tag(w) == "outcomes"] for m in models]
        for first, *others in filter(None, (models, *wrappers)):
            for other in others:
                message = f"a second <{other.name}>; put what is in it into the one of line "
                message += f"{first.position.line}."
                self.report(other.position, Code.DUPLICATE_ELEMENT, message)
        if not models:
            message = f"no <datamodel>; {what} needs one, with its outcomes."
            self.report(element.position, Code.MISSING_ELEMENT, message)
        elif not any(_has_outcome(model) for model in models):
            message = f'no <outcome name="..."/>; {what} ends in at least one.'
            self.report(models[0].position, Code.MISSING_ELEMENT, message)
        if not fields.nodes():
            message = f"neither a <state> nor a <behavior>; {what} needs at least one."
            self.report(element.position, Code.MISSING_ELEMENT, message)

    def _outcome(self, element: XmlElement) -> Outcome:
        fields = self._fields(element, OUTCOME)
        return Outcome(fields.text("name"), source=fields.source)

    def _input(self, element: XmlElement, shape: Shape) -> Input:
        fields = self._fields(element, shape)
        default = parse_literal(fields.extensions.get("default", "null"))
        return Input(fields.text("name"), fields.get("type"), default, source=fields.source)

    def _output(self, element: XmlElement) -> Output:
        fields = self._fields(element, PORT)
        return Output(fields.text("name"), fields.get("type"), source=fields.source)

    def _param(self, element: XmlElement) -> Param:
        fields = self._fields(element, NODE["param"])
        return Param(fields.text("name"), parse_literal(fields.text("value")), source=fields.source)

    def _transition(self, element: XmlElement) -> Transition:
        fields = self._fields(element, TRANSITION)
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

    def _condition(self, element: XmlElement) -> Condition:
        fields = self._fields(element, CONDITION)
        whens = (self._fields(e, WHEN) for e in fields.children("ext:when"))
        all_of = tuple(When(w.text("state"), w.text("event"), source=w.source) for w in whens)
        if not all_of:
            message = "no <ext:when>; a condition needs at least one state and its event."
            self.report(element.position, Code.MISSING_ELEMENT, message)
        return Condition(fields.text("outcome"), all_of, source=fields.source)

    def _node(self, element: XmlElement, shape: Shape) -> AnyNode:
        fields = self._fields(element, shape)
        attempts = self._convert(fields, "attempts", _at_least_one, "an integer from 1", 1)
        timeout_s = self._convert(
            fields, "timeout_s", _positive, "a number of seconds above 0", 1.0
        )
        no_routes: tuple[ErrorRoute, ...] = ()
        on_error = self._convert(fields, "on_error", parse_routes, ROUTES_RULE, no_routes)
        limits = (attempts, timeout_s, on_error or no_routes)
        transitions = tuple(map(self._transition, fields.children("transition")))
        node_id = fields.text("id")
        if element.namespace:
            body = self._container_body(element, fields, shape)
            tag = element.name
            return Container(
                node_id, tag, transitions, (), (), (), *limits, body=body, source=fields.source
            )
        parts = (
            node_id,
            fields.text("type"),
            transitions,
            tuple(self._input(e, PORT) for e in fields.children("input")),
            tuple(map(self._output, fields.children("output"))),
            tuple(map(self._param, fields.children("param"))),
            *limits,
        )
        if element.name == "behavior":
            return Behavior(*parts, source=fields.source)
        return State(*parts, topic=fields.get("topic"), source=fields.source)

    def _container_body(self, element: XmlElement, fields: _Fields, shape: Shape) -> Chart:
        """Return what a container holds; nothing of one that lies too deep."""
        if self._depth == DEEPEST:
            message = f"more than {DEEPEST} containers inside each other; make an inner one a "
            message += "chart of its own, and name its file in a <behavior>."
            self.report(element.position, Code.NESTED_TOO_DEEPLY, message)
        places = {**fields.source.attributes, "name": fields.source.place("id")}
        source = Source(element.position, places)
        self._depth += 1
        body = self._body(element, fields, shape, fields.text("id"), source)
        self._depth -= 1
        return body

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
                message = f"{attribute.name} of <{_tag(element)}> is empty; give it a value."
                self.report(attribute.position, Code.MISSING_ATTRIBUTE, message)
                plain[attribute.name] = ""
            else:
                plain[attribute.name] = attribute.value
                places[attribute.name] = attribute.position
        for name in shape.required:
            if name not in plain:
                message = f"<{_tag(element)}> has no attribute {name}; it needs " + ", ".join(
                    shape.required
                )
                self.report(element.position, Code.MISSING_ATTRIBUTE, message + ".")
        if element.text is not None:
            message = f"text inside <{_tag(element)}>; a chart holds elements and comments only."
            self.report(element.text, Code.UNEXPECTED_TEXT, message)
        for child in element.children:
            self._expect_child(child, element, shape)
        return _Fields(plain, extensions, Source(element.position, places), element.children)

    def _report_extension(
        self, position: Position, found: str, element: XmlElement, shape: Shape
    ) -> None:
        has = ", ".join(f"ext:{name}" for name in shape.extensions) or "none"
        message = f"{found} is no extension of <{_tag(element)}>; it has: {has}."
        self.report(position, Code.UNKNOWN_EXTENSION, message)

    def _report_attribute(
        self, position: Position, found: str, element: XmlElement, shape: Shape
    ) -> None:
        if found in shape.extensions:
            hint = f'it is an extension: write ext:{found}, with xmlns:ext="{EXTENSION}" on top.'
        else:
            hint = names.allowed(found, shape.attributes)
        message = f"<{_tag(element)}> has no attribute '{found}'; {hint}"
        self.report(position, Code.UNKNOWN_ATTRIBUTE, message)

    def _expect_child(self, child: XmlElement, element: XmlElement, shape: Shape) -> None:
        """Report a child element that the shape does not have."""
        tag = _tag(child)
        if tag in shape.children:
            return
        places = homes(tag)
        if places:
            message = f"<{tag}> does not belong in <{_tag(element)}>, but in "
            message += " or ".join(f"<{home}>" for home in places) + "."
            self.report(child.position, Code.MISPLACED_ELEMENT, message)
        elif child.namespace == EXTENSION:
            hint = names.allowed(tag, (name for name in shape.children if name.startswith("ext:")))
            message = f"the extension has no element <{tag}> in <{_tag(element)}>; {hint}"
            self.report(child.position, Code.UNKNOWN_EXTENSION, message)
        elif child.namespace:
            message = f"{_shown(child)}; the elements of a chart have no namespace: drop the xmlns."
            self.report(child.position, Code.UNKNOWN_ELEMENT, message)
        else:
            hint = names.allowed(child.name, shape.children)
            message = f"<{child.name}> in <{_tag(element)}> is unknown; {hint}"
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

    def children(self, tag: str) -> tuple[XmlElement, ...]:
        return tuple(child for child in self.elements if _tag(child) == tag)

    def nodes(self) -> tuple[XmlElement, ...]:
        return tuple(child for child in self.elements if _tag(child) in _NODES)


def _tag(element: XmlElement) -> str:
    """Return the element's name as the grammar spells it; one of another namespace has none."""
    if not element.namespace:
        return element.name
    return f"ext:{element.name}" if element.namespace == EXTENSION else f"{{}}{element.name}"


def _has_outcome(model: XmlElement) -> bool:
    """Tell whether a datamodel holds an outcome, directly or in a wrapper."""
    wrappers = [child for child in model.children if _tag(child) == "outcomes"]
    within = (*model.children, *(child for wrapper in wrappers for child in wrapper.children))
    return any(_tag(child) == "outcome" for child in within)


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
