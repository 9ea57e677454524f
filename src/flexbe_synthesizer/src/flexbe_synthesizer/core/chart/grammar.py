"""The grammar of the chart language, and elements read against it.

`STATEMACHINE` follows chapter 6 of Deliverable 5.1. What chapter 6 lacks stands in the namespace
`EXTENSION`, so that a plain chart stays valid; its elements have the prefix `ext:` here and in
messages. The published schemas, in `schema/`, say the same to XML editors.

`chart_reader` makes the parts of a chart of the elements.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import NamedTuple
from xml.etree.ElementTree import Element

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.problem import Position, Problem, ProblemKind, ProblemList
from flexbe_synthesizer.core.chart.xml_tree import XmlTree

EXTENSION = "urn:remodel:statechart:ext:1"


@dataclass(frozen=True)
class Shape:
    """What an element may hold: attributes, attributes of the extension, and elements."""

    required: tuple[str, ...] = ()
    optional: tuple[str, ...] = ()
    extensions: tuple[str, ...] = ()
    children: Mapping[str, Shape] = field(default_factory=dict)

    def is_all(self, given: Mapping[str, str]) -> bool:
        """Return whether all required attributes have a value, and there are no others."""
        return len(given) == len(self.required) and all(map(given.get, self.required))

    @property
    def attributes(self) -> tuple[str, ...]:
        """Return the names of the attributes without namespace."""
        return self.required + self.optional


LIMITS = ("attempts", "timeout_s", "on_error", "at")
PORT = Shape(("name",), ("type",))
OUTCOME = Shape(("name",), (), ("at",))
TRANSITION = Shape(("event", "target"), (), ("autonomy",))
WHEN = Shape(("state", "event"))
CONDITION = Shape(("outcome",), children={"ext:when": WHEN})
NODE = {"input": PORT, "output": PORT, "param": Shape(("name", "value")), "transition": TRANSITION}


def _data_model(*input_extensions: str) -> Shape:
    outcomes = Shape(children={"outcome": OUTCOME})
    given = Shape(("name",), ("type",), input_extensions)
    return Shape(
        children={"outcome": OUTCOME, "outcomes": outcomes, "input": given, "output": PORT}
    )


# A container may hold containers, so the two tables of what it holds are filled in below.
_SEQUENCE: dict[str, Shape] = {}
_CONCURRENCY: dict[str, Shape] = {}
_PARTS = {
    "state": Shape(("id", "type"), ("topic",), LIMITS, NODE),
    "behavior": Shape(("id", "type"), (), LIMITS, NODE),
    "connection": Shape(("output_state_id", "output", "input_state_id", "input")),
    "ext:container": Shape(("id", "initial"), (), LIMITS, _SEQUENCE),
    "ext:concurrency": Shape(("id",), (), LIMITS, _CONCURRENCY),
    "ext:priority": Shape(("id", "initial"), (), LIMITS, _SEQUENCE),
}
_SEQUENCE |= _PARTS | {"datamodel": _data_model(), "transition": TRANSITION}
_CONCURRENCY |= _SEQUENCE | {"ext:condition": CONDITION}
STATEMACHINE = Shape(
    ("name", "initial"),
    extensions=("author", "tags"),
    children={"datamodel": _data_model("default"), **_PARTS},
)


def homes(name: str) -> tuple[str, ...]:
    """Return the elements that may hold an element of that name."""
    found: list[str] = []
    shapes = {"statemachine": STATEMACHINE}
    waiting = list(shapes)
    for parent in waiting:
        children = shapes[parent].children
        if name in children:
            found.append(parent)
        for tag, child in children.items():
            if tag not in shapes:
                shapes[tag] = child
                waiting.append(tag)
    return tuple(found)


_SCHEMA_INSTANCE = "http://www.w3.org/2001/XMLSchema-instance"  # an editor's pointer to a schema
_MOST_UNKNOWN = 20  # attributes of one element that are reported one by one
_MAY_BE_EMPTY = ("value",)
_NO_EXTENSIONS: Mapping[str, str] = MappingProxyType({})


class TooManyErrorsError(Exception):
    """No more of a chart is to be read."""


class Fields(NamedTuple):
    """The parts of one element: its attributes, those of the extension, its children by tag."""

    plain: Mapping[str, str]
    extensions: Mapping[str, str]
    parts: Mapping[str, list[Element]]

    def text(self, name: str) -> str:
        """Return an attribute, the empty string if it is absent."""
        return self.plain.get(name, "")

    def children(self, tag: str) -> Sequence[Element]:
        """Return the children of a tag."""
        return self.parts.get(tag, ())


class ElementReader:
    """Reads the elements of one document and collects what is wrong with them.

    Attributes:
        problems: what was reported so far.
    """

    def __init__(self, tree: XmlTree, expect_time: Callable[[], None]) -> None:
        """Read the elements of a tree; what `expect_time` raises ends the reading."""
        self._tree = tree
        self.problems = ProblemList(expect_time)

    def report(self, position: Position, code: ProblemKind, message: str) -> None:
        """Take a problem."""
        self.take(Problem(position, code, message))

    def take(self, problem: Problem) -> None:
        """Take a problem.

        Raises:
            TooManyErrorsError: if it is the last one that is reported.
        """
        self.problems.take(problem)
        if self.problems.is_full:
            raise TooManyErrorsError

    def leaf(self, element: Element, shape: Shape) -> tuple[Mapping[str, str], Mapping[str, str]]:
        """Return the attributes of an element without children, and those of the extension."""
        ((_element, given, extensions),) = self.leaves((element,), shape)
        return given, extensions

    def leaves(
        self, elements: Sequence[Element], shape: Shape
    ) -> Iterator[tuple[Element, Mapping[str, str], Mapping[str, str]]]:
        """Yield elements without children, their attributes, and those of the extension.

        Most have all that they need and nothing else, and are let through at once. The element
        keeps its place only: fresh memory is a good part of the time that reading takes.
        """
        required, count = shape.required, len(shape.required)
        for element in elements:
            given: Mapping[str, str] = element.attrib
            if (
                len(given) == count
                and all(map(given.get, required))
                and not len(element)
                and not self._tree.has_text
            ):
                element.clear()
                yield element, given, _NO_EXTENSIONS
            else:
                fields = self.fields(element, shape)
                yield element, fields.plain, fields.extensions

    def fields(self, element: Element, shape: Shape) -> Fields:
        """Return the element's parts, and report those that its shape does not have."""
        plain: Mapping[str, str] = element.attrib
        extensions = _NO_EXTENSIONS
        if not shape.is_all(plain):
            plain, extensions = self._sorted_attributes(element, shape)
        if self._tree.has_text and (place := self._tree.text_place(element)) is not None:
            message = (
                f"text inside <{tag_name(element)}>; a chart holds elements and comments only."
            )
            self.report(place, ProblemKind.UNEXPECTED_TEXT, message)
        parts: dict[str, list[Element]] = {}
        for child in element:
            tag = child.tag
            if tag not in parts:
                tag = tag if tag in shape.children else tag_name(child)
            if tag in parts:
                parts[tag].append(child)
            elif tag in shape.children:
                parts[tag] = [child]
            else:
                self._report_child(child, element, shape)
        return Fields(plain, extensions, parts)

    def _sorted_attributes(
        self, element: Element, shape: Shape
    ) -> tuple[dict[str, str], dict[str, str]]:
        """Return the attributes without namespace and those of the extension."""
        plain: dict[str, str] = {}
        extensions: dict[str, str] = {}
        unknown: list[str] = []
        for spelled, value in element.attrib.items():
            namespace, name = split_name(spelled)
            if not namespace and name in shape.attributes:
                plain[name] = value
                if value == "" and name not in _MAY_BE_EMPTY:
                    message = f"{name} of <{tag_name(element)}> is empty; give it a value."
                    self.report(
                        self._tree.place(element, name), ProblemKind.MISSING_ATTRIBUTE, message
                    )
            elif namespace == EXTENSION and name in shape.extensions:
                extensions[name] = value
            elif namespace != _SCHEMA_INSTANCE:
                unknown.append(spelled)
        self._report_attributes(element, unknown, shape)
        for name in shape.required:
            if name not in plain:
                message = f"<{tag_name(element)}> has no attribute {name}; it needs " + ", ".join(
                    shape.required
                )
                self.report(self._tree.place(element), ProblemKind.MISSING_ATTRIBUTE, message + ".")
        return plain, extensions

    def _report_attributes(self, element: Element, unknown: Sequence[str], shape: Shape) -> None:
        """Report the attributes that the shape does not have; of very many only the first."""
        tag = tag_name(element)
        for spelled in unknown[:_MOST_UNKNOWN]:
            namespace, found = split_name(spelled)
            kind = ProblemKind.UNKNOWN_ATTRIBUTE
            if namespace == EXTENSION:
                has = ", ".join(f"ext:{name}" for name in shape.extensions) or "none"
                kind = ProblemKind.UNKNOWN_EXTENSION
                message = f"ext:{found} is no extension of <{tag}>; it has: {has}."
            elif namespace:
                message = f"<{tag}> has no attribute '{found}' of the namespace '{namespace}'; "
                message += "delete it, or its prefix if the chart's own attribute is meant."
            elif found in shape.extensions:
                message = f"<{tag}> has no attribute '{found}'; it is an extension: write "
                message += f'ext:{found}, with xmlns:ext="{EXTENSION}" on top.'
            else:
                hint = names.allowed(found, shape.attributes)
                message = f"<{tag}> has no attribute '{found}'; {hint}"
            self.report(self._tree.place(element, spelled), kind, message)
        more = len(unknown) - _MOST_UNKNOWN
        if more > 0:
            message = f"<{tag}> has {more} more attributes that are unknown; delete them."
            self.report(self._tree.place(element), ProblemKind.UNKNOWN_ATTRIBUTE, message)

    def _report_child(self, child: Element, element: Element, shape: Shape) -> None:
        """Report a child element that the shape does not have."""
        tag = tag_name(child)
        namespace, name = split_name(child.tag)
        position = self._tree.place(child)
        places = homes(tag)
        if places:
            message = f"<{tag}> does not belong in <{tag_name(element)}>, but in "
            message += " or ".join(f"<{home}>" for home in places) + "."
            self.report(position, ProblemKind.MISPLACED_ELEMENT, message)
        elif namespace == EXTENSION:
            hint = names.allowed(tag, (name for name in shape.children if name.startswith("ext:")))
            message = f"the extension has no element <{tag}> in <{tag_name(element)}>; {hint}"
            self.report(position, ProblemKind.UNKNOWN_EXTENSION, message)
        elif namespace:
            message = f"{shown(child)}; the elements of a chart have no namespace: drop the xmlns."
            self.report(position, ProblemKind.UNKNOWN_ELEMENT, message)
        else:
            hint = names.allowed(name, shape.children)
            message = f"<{name}> in <{tag_name(element)}> is unknown; {hint}"
            self.report(position, ProblemKind.UNKNOWN_ELEMENT, message)


def shown(element: Element) -> str:
    """Return the element's tag as a message shows it."""
    namespace, name = split_name(element.tag)
    return f"<{tag_name(element)}>" if not namespace else f"<{name}> in namespace '{namespace}'"


def split_name(spelled: str) -> tuple[str, str]:
    """Return namespace and name of `{namespace}name`."""
    namespace, _, name = spelled.rpartition("}")
    return namespace[1:], name


def tag_name(element: Element) -> str:
    """Return the element's name as the grammar spells it; one of another namespace has none."""
    tag: str = element.tag
    if not tag.startswith("{"):  # as it is spelled, which may be nothing: `<prefix:>`
        return tag
    namespace, name = split_name(tag)
    return f"ext:{name}" if namespace == EXTENSION else f"{{}}{name}"
