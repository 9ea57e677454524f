"""Where the markup of an XML text stands, byte by byte, so that it can be edited in place."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from xml.parsers import expat

from flexbe_synthesizer.core.chart.grammar import EXTENSION
from flexbe_synthesizer.core.chart.xml_reader import ATTRIBUTE, TAG_NAME

_HEAD_END = re.compile(rb"\s*/?>")
_BLANKS = b" \t"


@dataclass(frozen=True)
class AttributeSpan:
    """An attribute: from the blanks before it to its closing quote, and its value in between."""

    start: int
    value_start: int
    end: int

    @property
    def value_end(self) -> int:
        """Return where the closing quote stands."""
        return self.end - 1


@dataclass(eq=False)
class Markup:
    """An element's tags.

    Attributes:
        name: as it is spelled, with its prefix.
        parent: the element around it.
        attributes: by name as the grammar spells it, `ext:attempts`.
        start: of the start tag.
        head_end: behind the start tag.
        tail: of the end tag; where the start tag's `/>` begins if it has none.
        end: behind the element.
    """

    name: str
    parent: Markup | None
    start: int
    head_end: int = 0
    tail: int = 0
    end: int = 0
    attributes: dict[str, AttributeSpan] = field(default_factory=dict)
    children: list[Markup] = field(default_factory=list)

    @property
    def is_empty_tag(self) -> bool:
        """Return whether it is one tag, `<a/>`."""
        return self.tail < self.head_end

    @property
    def attributes_end(self) -> int:
        """Return where another attribute can be added."""
        ends = [span.end for span in self.attributes.values()]
        return max([self.start + 1 + len(self.name.encode()), *ends])


class XmlLayout:
    """The markup of a text in UTF-8.

    Attributes:
        data: the text.
        elements: all of it, in its order.
        prefixes: namespaces by the prefixes that the outermost element declares.
    """

    def __init__(self, data: bytes) -> None:
        """Read a text.

        Raises:
            ValueError: if it is not well-formed.
        """
        self.data = data
        self.elements: list[Markup] = []
        self.prefixes: dict[str, str] = {}
        self._open: list[tuple[Markup, list[str]]] = []
        self._namespaces: dict[str, list[str]] = {}
        self._before: list[int] = []
        self._inside: list[int] = []
        self._parser = expat.ParserCreate(encoding="utf-8")
        self._parser.ordered_attributes = True
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CommentHandler = self._comment
        try:
            self._parser.Parse(data, True)
        except expat.ExpatError as error:
            raise ValueError(str(error)) from error

    @property
    def root(self) -> Markup:
        """Return the outermost element."""
        return self.elements[0]

    @property
    def extension_prefix(self) -> str | None:
        """Return the prefix of the extension's namespace; None if it is not declared at once."""
        return next((p for p, space in self.prefixes.items() if p and space == EXTENSION), None)

    @property
    def description(self) -> tuple[int, int] | None:
        """Return where the comment stands that describes the chart, from `<!--` to behind `-->`."""
        starts = [*self._inside[:1], *self._before[-1:]]
        if not starts:
            return None
        return starts[0], self.data.index(b"-->", starts[0]) + 3

    def line_start(self, at: int) -> int:
        """Return where the line of a place begins."""
        return self.data.rfind(b"\n", 0, at) + 1

    def blanks_before(self, at: int) -> int:
        """Return where the blanks begin that stand before a place on its line."""
        while at and self.data[at - 1] in _BLANKS:
            at -= 1
        return at

    def blanks_after(self, at: int) -> int:
        """Return where the blanks end that stand behind a place on its line."""
        while at < len(self.data) and self.data[at] in _BLANKS:
            at += 1
        return at

    def begins_line(self, at: int) -> bool:
        """Return whether only blanks stand before a place on its line."""
        return self.blanks_before(at) == self.line_start(at)

    def next_line(self, at: int) -> int | None:
        """Return where the line behind a place begins; None if more than blanks stand between."""
        at = self.blanks_after(at)
        if self.data[at : at + 2] == b"\r\n":
            return at + 2
        return at + 1 if self.data[at : at + 1] == b"\n" else None

    def next_line_behind_comments(self, at: int) -> int | None:
        """Return the same, passing comments by."""
        while self.data.startswith(b"<!--", self.blanks_after(at)):
            at = self.data.index(b"-->", at) + 3
        return self.next_line(at)

    def indentation(self, at: int) -> str:
        """Return the blanks that the line of a place begins with."""
        start = self.line_start(at)
        return self.data[start : self.blanks_after(start)].decode()

    def newline(self, at: int) -> str:
        """Return how the line before a place ends, else how the first line does."""
        end = self.data.rfind(b"\n", 0, at)
        end = self.data.find(b"\n") if end < 0 else end
        return "\r\n" if end > 0 and self.data[end - 1 : end] == b"\r" else "\n"

    def _comment(self, _text: str) -> None:
        if not self.elements:
            self._before.append(self._parser.CurrentByteIndex)
        elif len(self.elements) == 1 and self._open:
            self._inside.append(self._parser.CurrentByteIndex)

    def _start(self, name: str, pairs: list[str]) -> None:
        parent = self._open[-1][0] if self._open else None
        markup = Markup(name, parent, self._parser.CurrentByteIndex)
        if parent is not None:
            parent.children.append(markup)
        self.elements.append(markup)
        declared = []
        for raw, value in zip(pairs[::2], pairs[1::2], strict=True):
            if raw == "xmlns" or raw.startswith("xmlns:"):
                prefix = raw.partition(":")[2]
                self._namespaces.setdefault(prefix, []).append(value)
                declared.append(prefix)
        if parent is None:
            self.prefixes = {prefix: spaces[-1] for prefix, spaces in self._namespaces.items()}
        self._open.append((markup, declared))
        self._read_head(markup)

    def _read_head(self, markup: Markup) -> None:
        """Find the attributes and the end of a start tag."""
        found = TAG_NAME.match(self.data, markup.start)
        at = found.end() if found else markup.start
        while (found := ATTRIBUTE.match(self.data, at)) is not None:
            span = AttributeSpan(at, found.start(2) + 1, found.end())
            markup.attributes[self._known(found[1].decode())] = span
            at = found.end()
        closing = _HEAD_END.match(self.data, at)
        markup.head_end = closing.end() if closing else at
        if closing and closing[0].endswith(b"/>"):
            markup.tail, markup.end = closing.start(), closing.end()

    def _known(self, raw: str) -> str:
        """Return an attribute's name as the grammar spells it."""
        prefix, _, local = raw.rpartition(":")
        spaces = self._namespaces.get(prefix) if prefix else None
        if spaces and spaces[-1] == EXTENSION:
            return f"ext:{local}"
        return f"other {raw}" if prefix == "ext" else raw

    def _end(self, _name: str) -> None:
        markup, declared = self._open.pop()
        for prefix in declared:
            self._namespaces[prefix].pop()
        if not markup.end:
            markup.tail = self._parser.CurrentByteIndex
            markup.end = self.data.index(b">", markup.tail) + 1
