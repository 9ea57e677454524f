"""The one reader of the chart language; its writer is in `chart_writer`.

Reading reports everything that does not fit the grammar and goes on with the rest; a required
attribute that is missing reads as the empty string, which the checks skip.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from sys import intern
from typing import Generic, TypeAlias, TypeVar
from xml.etree.ElementTree import Element

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.error_routes import ROUTES_RULE, parse_routes
from flexbe_synthesizer.core.chart.grammar import (
    CONDITION,
    EXTENSION,
    NODE,
    OUTCOME,
    PORT,
    STATEMACHINE,
    TRANSITION,
    WHEN,
    ElementReader,
    Fields,
    Shape,
    TooManyErrorsError,
    shown,
    split_name,
)
from flexbe_synthesizer.core.chart.model import (
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
    Point,
    Source,
    State,
    Transition,
    When,
    as_declared,
    parse_literal,
)
from flexbe_synthesizer.core.chart.problem import (
    ChartError,
    Position,
    Problem,
    ProblemKind,
    errors_in,
)
from flexbe_synthesizer.core.chart.xml_tree import XmlTree, as_utf8, read_root

DEEPEST = 16  # containers inside each other; who needs more has lost the overview of the chart
_NODES = {"state": "state", "behavior": "behavior"} | {
    f"{{{EXTENSION}}}{kind}": f"ext:{kind}" for kind in ("container", "concurrency", "priority")
}
_PARAM, _CONNECTION = NODE["param"], STATEMACHINE.children["connection"]
_Limits: TypeAlias = "tuple[int | None, float | None, tuple[ErrorRoute, ...], Point | None]"
_POINT = re.compile(r"\s*(-?[0-9]{1,5})\s+(-?[0-9]{1,5})\s*\Z")
_UNLIMITED: _Limits = (None, None, (), None)
_Value = TypeVar("_Value")


@dataclass(frozen=True)
class _Extension(Generic[_Value]):
    """What an extension attribute holds.

    Attributes:
        name: of the attribute.
        convert: returns the value that a text spells; raises ValueError if it spells none.
        allowed: which texts spell one, in words.
        instead: stands for one that is not allowed, so that the rest is checked as if mended.
    """

    name: str
    convert: Callable[[str], _Value]
    allowed: str
    instead: _Value


def _read_point(text: str) -> Point:
    found = _POINT.match(text)
    if found is None:
        raise ValueError(text)
    return int(found[1]), int(found[2])


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


_LEVELS = f"one of {names.quoted(level.value for level in Autonomy)}"
_AUTONOMY = _Extension("autonomy", Autonomy, _LEVELS, Autonomy.OFF)
_ATTEMPTS = _Extension("attempts", _at_least_one, "an integer from 1", 1)
_TIMEOUT = _Extension("timeout_s", _positive, "a number of seconds above 0", 1.0)
_ROUTES = _Extension[tuple[ErrorRoute, ...]]("on_error", parse_routes, ROUTES_RULE, ())
_PLACE = "two whole numbers of at most 5 digits, right and down, such as '120 40'"
_AT = _Extension("at", _read_point, _PLACE, (0, 0))


def parse_chart(source: str | bytes, file: str = "<chart>") -> Chart:
    """Return the chart that an XML text holds, as far as its form goes; `check` proves the rest.

    Raises:
        ChartError: if the text does not have the form of a chart.
    """
    chart, problems = read_chart(source, file)
    if chart is None or errors_in(problems):
        raise ChartError(problems)
    return chart


def read_chart(
    source: str | bytes, file: str, expect_time: Callable[[], None] = lambda: None
) -> tuple[Chart | None, tuple[Problem, ...]]:
    """Return what can be read of the chart, if anything, and what is wrong with its form.

    Args:
        source: the text.
        file: its path.
        expect_time: called again and again; what it raises ends the reading.
    """
    try:
        tree = XmlTree(source, file)
    except ChartError as error:
        return None, error.problems
    elements = ElementReader(tree, expect_time)
    try:
        for problem in tree.problems:
            elements.take(problem)
        chart = _ChartReader(elements, tree, file, expect_time).read()
    except TooManyErrorsError:
        chart = None
    return chart, tuple(elements.problems)


def read_chart_name(source: bytes) -> str | None:
    """Return the name of the chart that a file begins; None if it is none."""
    try:
        tag, attributes = read_root(as_utf8(source, ""))
    except ChartError:
        return None
    return attributes.get("name") if tag == "statemachine" else None


class _ChartReader:
    """Turns elements into a chart."""

    def __init__(
        self, elements: ElementReader, tree: XmlTree, file: str, expect_time: Callable[[], None]
    ) -> None:
        self._elements = elements
        self._tree = tree
        self._file = file
        self._depth = 0
        self._expect_time = expect_time

    def read(self) -> Chart | None:
        """Return the chart, None if the document is none."""
        root = self._tree.root
        if root.tag == "statemachine":
            return self.chart(root)
        message = f"found {shown(root)}; a chart's outermost element is <statemachine>."
        self._elements.report(self._tree.place(root), ProblemKind.UNKNOWN_ELEMENT, message)
        return None

    def chart(self, root: Element) -> Chart:
        """Return the chart of the outermost element."""
        fields = self._elements.fields(root, STATEMACHINE)
        source = (self._tree, root)
        chart = self._body(root, fields, STATEMACHINE, fields.text("name"), source=source)
        return replace(
            chart,
            description=self._tree.description,
            file=self._file,
            author=fields.extensions.get("author", ""),
            tags=fields.extensions.get("tags", ""),
        )

    def _body(
        self, element: Element, fields: Fields, shape: Shape, name: str, source: Source
    ) -> Chart:
        """Return what a chart or a container holds."""
        models = fields.children("datamodel")
        inner = _nodes(element)
        self._expect_parts(element, fields, inner)
        data_shape = shape.children["datamodel"]
        data = [self._elements.fields(model, data_shape) for model in models]
        wrappers = {
            wrapper: self._elements.fields(wrapper, data_shape.children["outcomes"])
            for model in data
            for wrapper in model.children("outcomes")
        }
        outcomes = [
            outcome
            for model in models
            for child in model
            for outcome in (wrappers[child].children("outcome") if child in wrappers else (child,))
            if outcome.tag == "outcome"
        ]
        inner = inner if self._depth <= DEEPEST else []
        return Chart(
            name=name,
            initial=fields.text("initial"),
            outcomes=tuple(map(self._outcome, outcomes)),
            nodes=tuple([self._node(e, shape.children[tag]) for tag, e in inner]),
            inputs=tuple(
                self._input(e, data_shape.children["input"])
                for part in data
                for e in part.children("input")
            ),
            outputs=tuple(self._output(e) for part in data for e in part.children("output")),
            connections=self._connections(fields.children("connection")),
            conditions=tuple(map(self._condition, fields.children("ext:condition"))),
            source=source,
        )

    def _expect_parts(self, element: Element, fields: Fields, nodes: Sequence[object]) -> None:
        """Report a chart or container that lacks a datamodel, an outcome or a state."""
        models = fields.children("datamodel")
        what = "a chart" if element.tag == "statemachine" else "a container"
        wrappers = [model.findall("outcomes") for model in models]
        for first, *others in filter(None, (models, *wrappers)):
            for other in others:
                message = f"a second <{other.tag}>; put what is in it into the one of line "
                message += f"{self._tree.place(first).line}."
                self._elements.report(
                    self._tree.place(other), ProblemKind.DUPLICATE_ELEMENT, message
                )
        if not models:
            message = f"no <datamodel>; {what} needs one, with its outcomes."
            self._elements.report(self._tree.place(element), ProblemKind.MISSING_ELEMENT, message)
        elif not any(_has_outcome(model) for model in models):
            message = f'no <outcome name="..."/>; {what} ends in at least one.'
            self._elements.report(self._tree.place(models[0]), ProblemKind.MISSING_ELEMENT, message)
        if not nodes:
            message = f"neither a <state> nor a <behavior>; {what} needs at least one."
            self._elements.report(self._tree.place(element), ProblemKind.MISSING_ELEMENT, message)

    def _outcome(self, element: Element) -> Outcome:
        given, extensions = self._elements.leaf(element, OUTCOME)
        at = self._convert(element, extensions, _AT) if extensions else None
        return Outcome(given.get("name", ""), at, source=(self._tree, element))

    def _input(self, element: Element, shape: Shape) -> Input:
        given, extensions = self._elements.leaf(element, shape)
        kind = given.get("type") or None
        default = as_declared(extensions.get("default", "null"), kind)
        return Input(given.get("name", ""), kind, default, source=(self._tree, element))

    def _output(self, element: Element) -> Output:
        given, _extensions = self._elements.leaf(element, PORT)
        source = (self._tree, element)
        return Output(given.get("name", ""), given.get("type") or None, source=source)

    # Names are interned: one string for all that name a state is found faster, in less memory.

    def _params(self, elements: Sequence[Element]) -> tuple[Param, ...]:
        tree = self._tree
        return tuple(
            [
                Param(
                    intern(given.get("name", "")),
                    parse_literal(text := given.get("value", "")),
                    text,
                    source=(tree, element),
                )
                for element, given, _extensions in self._elements.leaves(elements, _PARAM)
            ]
        )

    def _transitions(self, elements: Sequence[Element]) -> tuple[Transition, ...]:
        tree = self._tree
        return tuple(
            [
                Transition(
                    intern(given.get("event", "")),
                    intern(given.get("target", "")),
                    self._convert(element, extensions, _AUTONOMY) if extensions else None,
                    source=(tree, element),
                )
                for element, given, extensions in self._elements.leaves(elements, TRANSITION)
            ]
        )

    def _connections(self, elements: Sequence[Element]) -> tuple[Connection, ...]:
        tree = self._tree
        return tuple(
            [
                Connection(
                    intern(given.get("output_state_id", "")),
                    intern(given.get("output", "")),
                    intern(given.get("input_state_id", "")),
                    intern(given.get("input", "")),
                    source=(tree, element),
                )
                for element, given, _extensions in self._elements.leaves(elements, _CONNECTION)
            ]
        )

    def _condition(self, element: Element) -> Condition:
        fields = self._elements.fields(element, CONDITION)
        all_of = tuple(map(self._when, fields.children("ext:when")))
        if not all_of:
            message = "no <ext:when>; a condition needs at least one state and its event."
            self._elements.report(self._tree.place(element), ProblemKind.MISSING_ELEMENT, message)
        return Condition(fields.text("outcome"), all_of, source=(self._tree, element))

    def _when(self, element: Element) -> When:
        given, _extensions = self._elements.leaf(element, WHEN)
        source = (self._tree, element)
        return When(given.get("state", ""), given.get("event", ""), source=source)

    def _node(self, element: Element, shape: Shape) -> AnyNode:
        self._expect_time()
        fields = self._elements.fields(element, shape)
        limits = self._limits(element, fields.extensions) if fields.extensions else _UNLIMITED
        parts = fields.parts
        transitions = self._transitions(parts.get("transition", ()))
        node_id, source = intern(fields.text("id")), (self._tree, element)
        if element.tag not in ("state", "behavior"):
            body = self._container_body(element, fields, shape)
            tag = split_name(element.tag)[1]
            return Container(
                node_id, tag, transitions, (), (), (), *limits, body=body, source=source
            )
        given = (
            node_id,
            intern(fields.text("type")),
            transitions,
            tuple([self._input(e, PORT) for e in parts["input"]]) if "input" in parts else (),
            tuple([self._output(e) for e in parts["output"]]) if "output" in parts else (),
            self._params(parts["param"]) if "param" in parts else (),
            *limits,
        )
        if element.tag == "behavior":
            return Behavior(*given, source=source)
        return State(*given, topic=fields.text("topic") or None, source=source)

    def _limits(self, element: Element, extensions: Mapping[str, str]) -> _Limits:
        """Return the attempts, the timeout, the error routes and the place of a node."""
        return (
            self._convert(element, extensions, _ATTEMPTS),
            self._convert(element, extensions, _TIMEOUT),
            self._convert(element, extensions, _ROUTES) or (),
            self._convert(element, extensions, _AT),
        )

    def _container_body(self, element: Element, fields: Fields, shape: Shape) -> Chart:
        """Return what a container holds; nothing of one that lies too deep."""
        if self._depth == DEEPEST:
            message = f"more than {DEEPEST} containers inside each other; make an inner one a "
            message += "chart of its own, and name its file in a <behavior>."
            self._elements.report(self._tree.place(element), ProblemKind.NESTED_TOO_DEEPLY, message)

        source = (_IdForName(self._tree), element)
        self._depth += 1
        body = self._body(element, fields, shape, fields.text("id"), source=source)
        self._depth -= 1
        return body

    def _convert(
        self, element: Element, extensions: Mapping[str, str], wanted: _Extension[_Value]
    ) -> _Value | None:
        """Return the value of an extension attribute; None if it is absent."""
        text = extensions.get(wanted.name)
        if text is None:
            return None
        try:
            return wanted.convert(text)
        except ValueError:
            message = f"{wanted.name}='{text}' is not allowed; give {wanted.allowed}."
            place = self._tree.place(element, wanted.name)
            self._elements.report(place, ProblemKind.INVALID_VALUE, message)
            return wanted.instead


class _IdForName:
    """The places in a container, whose content has the container's id as its name."""

    def __init__(self, tree: XmlTree) -> None:
        self._tree = tree

    def place(self, element: Element, attribute: str) -> Position:
        return self._tree.place(element, "id" if attribute == "name" else attribute)


def _nodes(element: Element) -> list[tuple[str, Element]]:
    """Return the states, behaviors and containers in an element with their tags, in order."""
    return [(_NODES[child.tag], child) for child in element if child.tag in _NODES]


def _has_outcome(model: Element) -> bool:
    """Return whether a datamodel holds an outcome, directly or in a wrapper."""
    return model.find("outcome") is not None or model.find("outcomes/outcome") is not None
