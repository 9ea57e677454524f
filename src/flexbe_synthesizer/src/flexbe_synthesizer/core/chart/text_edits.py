"""Edits of an XML text in place, and where its markup stands, byte by byte.

What is added is laid out as what stands around it: on lines of its own where that does, else
within the line.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from xml.parsers import expat

from flexbe_synthesizer.core.chart.chart_writer import Part, Style, attribute, part_lines
from flexbe_synthesizer.core.chart.grammar import EXTENSION
from flexbe_synthesizer.core.chart.xml_tree import attributes_of, declared_prefix

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
            prefix = declared_prefix(raw)
            if prefix is not None:
                self._namespaces.setdefault(prefix, []).append(value)
                declared.append(prefix)
        if parent is None:
            self.prefixes = {prefix: spaces[-1] for prefix, spaces in self._namespaces.items()}
        self._open.append((markup, declared))
        self._read_head(markup)

    def _read_head(self, markup: Markup) -> None:
        """Find the attributes and the end of a start tag."""
        for found in attributes_of(self.data, markup.start):
            span = AttributeSpan(found.start(), found.start(2) + 1, found.end())
            markup.attributes[self._known(found[1].decode())] = span
        at = markup.attributes_end
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


@dataclass(frozen=True)
class Place:
    """Where elements are added.

    Attributes:
        at: place in the text.
        indent: blanks before each line; None: within the line.
        newline: end of each line.
        lead: what stands before an element within the line.
        trail: what stands behind one.
        filled: element without content that they become the content of.
    """

    at: int
    indent: str | None = None
    newline: str = "\n"
    lead: str = ""
    trail: str = ""
    filled: Markup | None = None


@dataclass(frozen=True)
class _Edit:
    """Bytes to put in place of those from `start` to `end`."""

    start: int
    end: int
    text: str


@dataclass
class Edits:
    """Edits that are collected, and applied together.

    Attributes:
        uses_extension: something that was added needs the extension's namespace.
    """

    layout: XmlLayout
    style: Style
    uses_extension: bool = False
    _edits: list[_Edit] = field(default_factory=list)
    _fills: dict[Markup, list[str]] = field(default_factory=dict)
    _removed: set[Markup] = field(default_factory=set)

    def is_removed(self, markup: Markup) -> bool:
        """Return whether an element has been removed."""
        return markup in self._removed

    def replace(self, start: int, end: int, text: str) -> None:
        """Put a text in place of another one."""
        self._edits.append(_Edit(start, end, text))

    def rename(self, markup: Markup, tag: str) -> None:
        """Give an element another name."""
        self.uses_extension |= tag.startswith("ext:")
        length = len(markup.name.encode())
        starts = [markup.start + 1] if markup.is_empty_tag else [markup.start + 1, markup.tail + 2]
        for start in starts:
            self.replace(start, start + length, self.style.spelled(tag))

    def add_attribute(self, markup: Markup, name: str, value: str) -> None:
        """Add an attribute behind the others, on a line of its own if the last one has one."""
        self.uses_extension |= name.startswith("ext:")
        data, spans = self.layout.data, markup.attributes.values()
        last = max(spans, key=lambda span: span.end, default=None)
        lead = " "
        if last is not None:
            given = data[last.start : last.end]
            blanks = given[: len(given) - len(given.lstrip())]
            lead = blanks.decode() if b"\n" in blanks else " "
        at = markup.attributes_end
        self.replace(at, at, lead + attribute(name, value, self.style))

    def declare_extension(self) -> None:
        """Declare the extension's namespace if it is needed and is not declared."""
        root = self.layout.root
        if self.uses_extension and self.layout.extension_prefix is None:
            self.add_attribute(root, f"xmlns:{self.style.prefix}", EXTENSION)

    def remove(self, markup: Markup) -> None:
        """Remove an element: its lines, if nothing else stands on them."""
        self._removed.add(markup)
        layout, start, end = self.layout, markup.start, markup.end
        next_line = layout.next_line(end)
        if layout.begins_line(start):
            start = layout.line_start(start) if next_line is not None else start
            end = next_line if next_line is not None else layout.blanks_after(end)
        else:
            start = layout.blanks_before(start)
        self.replace(start, end, "")

    def after(self, markup: Markup) -> Place:
        """Return the place behind an element."""
        layout, end = self.layout, markup.end
        next_line = layout.next_line_behind_comments(end)
        if layout.begins_line(markup.start) and next_line is not None:
            return Place(next_line, layout.indentation(markup.start), layout.newline(next_line))
        return Place(end, lead=self._gap(markup))

    def before(self, markup: Markup) -> Place:
        """Return the place before an element."""
        layout, start = self.layout, markup.start
        if layout.begins_line(start) and layout.next_line_behind_comments(markup.end) is not None:
            at = layout.line_start(start)
            return Place(at, layout.indentation(start), layout.newline(start))
        return Place(start, trail=self._gap(markup))

    def inside(self, markup: Markup) -> Place:
        """Return the place behind all that is in an element."""
        layout = self.layout
        is_blank = markup.is_empty_tag or layout.data[markup.head_end : markup.tail].strip() == b""
        has_lines = not markup.is_empty_tag and layout.begins_line(markup.tail)
        if has_lines:
            at = layout.line_start(markup.tail)
            return Place(at, self._inner_indent(markup), layout.newline(markup.tail))
        if not is_blank:
            return Place(markup.tail)
        stands_alone = layout.begins_line(markup.start) and (
            layout.next_line_behind_comments(markup.end) is not None
        )
        indent = self._inner_indent(markup) if stands_alone else None
        return Place(markup.tail, indent, layout.newline(markup.end), filled=markup)

    def add(self, part: Part, place: Place) -> None:
        """Add an element."""
        self.uses_extension |= part.is_extended()
        if place.indent is None:
            self.add_text("".join(line.lstrip() for line in part_lines(part, self.style)), place)
        else:
            joint = place.newline + place.indent
            self.add_text(joint.join(part_lines(part, self.style)), place)

    def add_text(self, text: str, place: Place) -> None:
        """Add an element that is written already."""
        if place.filled is not None:
            lead = "" if place.indent is None else place.newline + place.indent
            self._fills.setdefault(place.filled, []).append(lead + text)
        elif place.indent is None:
            self.replace(place.at, place.at, place.lead + text + place.trail)
        else:
            self.replace(place.at, place.at, place.indent + text + place.newline)

    def fill(self, markup: Markup, tag: str) -> None:
        """Put what was added to an element without content into it."""
        texts = self._fills.pop(markup, None)
        if texts is None:
            return
        layout, text = self.layout, "".join(texts)
        if "\n" in text:
            text += layout.newline(markup.end) + layout.indentation(markup.start)
        if markup.is_empty_tag:
            self.replace(markup.tail, markup.end, f">{text}</{self.style.spelled(tag)}>")
        else:
            self.replace(markup.head_end, markup.tail, text)

    def applied(self, start: int = 0, end: int | None = None) -> str:
        """Return the text, or what is between two places, with all edits made."""
        data, parts, at = self.layout.data, [], start
        order = sorted(self._edits, key=lambda edit: (edit.start, edit.end > edit.start))
        for edit in order:
            parts += [data[at : max(at, edit.start)], edit.text.encode()]
            at = max(at, edit.end)
        parts.append(data[at : len(data) if end is None else end])
        return b"".join(parts).decode()

    def _gap(self, markup: Markup) -> str:
        """Return the blanks between an element and its neighbours on the line."""
        layout, start = self.layout, markup.start
        if not layout.begins_line(start):
            return layout.data[layout.blanks_before(start) : start].decode()
        return layout.data[markup.end : layout.blanks_after(markup.end)].decode()

    def _inner_indent(self, markup: Markup) -> str:
        """Return the blanks before a line in an element."""
        for child in markup.children:
            if self.layout.begins_line(child.start):
                return self.layout.indentation(child.start)
        return self.layout.indentation(markup.start) + self.style.indent


def style_of(layout: XmlLayout) -> Style:
    """Return how the elements of a text are written."""
    data, root = layout.data, layout.root
    indent = Style.indent
    for child in root.children:
        blanks = layout.indentation(child.start).removeprefix(layout.indentation(root.start))
        if layout.begins_line(child.start) and blanks:
            indent = blanks
            break
    quotes = [chr(data[span.value_end]) for span in root.attributes.values()]
    has_blank = 2 * data.count(b" />") > data.count(b"/>")
    prefix = layout.extension_prefix or ("ext" if "ext" not in layout.prefixes else "chart_ext")
    return Style(indent, (quotes or ['"'])[-1], " />" if has_blank else "/>", prefix)
