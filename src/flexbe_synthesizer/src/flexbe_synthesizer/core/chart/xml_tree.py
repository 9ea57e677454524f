"""Read XML fast, and find out where something stands only when that is asked.

`xml.etree` builds its tree in C and knows no places; `xml_reader` knows every place and takes ten
times as long. Both are expat underneath, so they agree on what is well-formed. What is not, or has
a document type or an undeclared prefix, goes to `xml_reader` at once, which says what is wrong.
The first place that is asked for costs a pass that finds where each tag begins.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from functools import cached_property
from xml.etree.ElementTree import Element, ParseError, TreeBuilder, XMLParser
from xml.parsers import expat

from flexbe_synthesizer.core.chart.problem import Position, Problem
from flexbe_synthesizer.core.chart.xml_reader import (
    ATTRIBUTE,
    TAG_NAME,
    Document,
    XmlElement,
    as_utf8,
    read_description,
    read_utf8,
)

_LINE_END = re.compile(rb"\r\n?|\n")
# Between tags, or in a comment or a text, none of which changes the elements and what is in them.
_INDENTATION = re.compile(rb">[ \t\r\n]+<")


class XmlTree:
    """The elements of a document, with tags and attributes spelled `{namespace}name`.

    Attributes:
        root: the outermost element.
        problems: what is wrong with it as XML without being fatal.
        has_text: text that is not blank stands somewhere between the tags.
    """

    def __init__(self, source: str | bytes, file: str) -> None:
        """Read the source.

        Raises:
            ChartError: if it is not well-formed XML in a known encoding, or has a DOCTYPE.
        """
        self._data = as_utf8(source, file)
        self._file = file
        root = _parse(self._data)
        self.problems: tuple[Problem, ...] = ()
        self._is_fast = root is not None
        if root is None:
            self.problems = self._exact.problems
            root = _built(self._exact.root)
        self.root = root
        text = "".join(self.root.itertext())
        self.has_text = bool(text) and not text.isspace()

    @property
    def description(self) -> str:
        """Return the first comment in the root before any element, else the one before the root."""
        return read_description(self._data)

    def place(self, element: Element, attribute: str = "") -> Position:
        """Return where an attribute of the element stands, else where the element does."""
        if not self._is_fast:
            return self._exact_place(element, attribute)
        start = self._starts[id(element)]
        found = dict(self._attributes(start)) if attribute else {}
        spelled = [n for n in found if n.rpartition(":")[2] == attribute]
        spelled.sort(key=lambda name: ":" in name)  # xsi:type is not the type
        return self._position(found[spelled[0]] if spelled else start)

    def text_place(self, element: Element) -> Position | None:
        """Return where the first text in the element stands that is not blank."""
        return self._places[id(element)].text

    def _attributes(self, start: int) -> Iterator[tuple[str, int]]:
        """Yield name and place of each attribute of the tag that begins at a byte."""
        tag = TAG_NAME.match(self._data, start)
        at = tag.end() if tag else start
        while (found := ATTRIBUTE.match(self._data, at)) is not None:
            name = found[1].decode()
            if name != "xmlns" and not name.startswith("xmlns:"):
                yield name, found.start(1)
            at = found.end()

    def _position(self, at: int) -> Position:
        """Return the place of a byte."""
        line = bisect_right(self._line_starts, at)
        before = self._data[self._line_starts[line - 1] : at]
        return Position(self._file, line, len(before.decode()) + 1)

    @cached_property
    def _line_starts(self) -> list[int]:
        return [0, *(end.end() for end in _LINE_END.finditer(self._data))]

    @cached_property
    def _starts(self) -> Mapping[int, int]:
        """Return the byte that the tag of each element begins at, by the element's identity."""
        starts: list[int] = []
        parser = expat.ParserCreate(encoding="utf-8")
        parser.ordered_attributes = True  # a list is made faster than a dictionary
        parser.StartElementHandler = lambda _name, _given: starts.append(parser.CurrentByteIndex)
        parser.Parse(self._data, True)
        return dict(zip(map(id, self.root.iter()), starts, strict=True))

    def _exact_place(self, element: Element, attribute: str) -> Position:
        exact = self._places[id(element)]
        same = [a for a in exact.attributes if a.name == attribute]
        same.sort(key=lambda a: a.namespace != "")
        return same[0].position if same else exact.position

    @cached_property
    def _exact(self) -> Document:
        return read_utf8(self._data, self._file)

    @cached_property
    def _places(self) -> dict[int, XmlElement]:
        """Return for each element, by identity, the same one with its places."""
        exact = _in_order(self._exact.root)
        return {id(element): next(exact) for element in self.root.iter()}


def _parse(data: bytes) -> Element | None:
    """Return the root element, None if only `xml_reader` can say what is there."""
    if b"<!DOCTYPE" in data:
        return None
    parser = XMLParser(target=TreeBuilder(), encoding="utf-8")
    try:
        parser.feed(_INDENTATION.sub(b"><", data))  # each would become a string in the tree
        root: Element = parser.close()
    except ParseError:
        return None
    return root


def _built(exact: XmlElement) -> Element:
    """Return the tree of an element that was read with its places."""
    root = Element("")
    waiting = [(exact, root)]
    while waiting:
        read, made = waiting.pop()
        made.tag = _spelled(read.namespace, read.name)
        made.attrib.update((_spelled(a.namespace, a.name), a.value) for a in read.attributes)
        made.text = None if read.text is None else "text"
        made.extend([Element("") for _child in read.children])
        waiting.extend(zip(read.children, made, strict=True))
    return root


def _spelled(namespace: str, name: str) -> str:
    return f"{{{namespace}}}{name}" if namespace else name


def _in_order(root: XmlElement) -> Iterator[XmlElement]:
    """Yield the element and all below it, in the order of the document."""
    waiting = [root]
    while waiting:
        element = waiting.pop()
        yield element
        waiting.extend(reversed(element.children))
