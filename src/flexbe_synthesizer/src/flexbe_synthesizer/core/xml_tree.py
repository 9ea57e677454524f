"""Read XML fast, and find out where something stands only when that is asked.

`xml.etree` builds its tree in C and knows no places; `xml_reader` knows every place and takes ten
times as long. Both are expat underneath, so they agree on what is well-formed. What is not, or has
a document type or an undeclared prefix, goes to `xml_reader` at once, which says what is wrong.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from xml.etree.ElementTree import Element, ParseError, TreeBuilder, XMLParser

from flexbe_synthesizer.core.problem import Position, Problem
from flexbe_synthesizer.core.xml_reader import (
    Document,
    XmlElement,
    as_utf8,
    read_description,
    read_utf8,
)


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
        exact = self._places[id(element)]
        same = [a for a in exact.attributes if a.name == attribute]
        same.sort(key=lambda a: a.namespace != "")  # xsi:type is not the type
        return same[0].position if same else exact.position

    def text_place(self, element: Element) -> Position | None:
        """Return where the first text in the element stands that is not blank."""
        return self._places[id(element)].text

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
        parser.feed(data)
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
