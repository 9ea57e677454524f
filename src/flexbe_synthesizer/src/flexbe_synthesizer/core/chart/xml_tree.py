"""Read XML into elements: fast, or with the line and column of each when something is wrong.

The standard library's expat is used, since lxml knows no columns and no places of attributes.
Namespaces are resolved here rather than by expat, so that an undeclared prefix, or an attribute
that stands twice, is one problem among others and does not hide the rest of the file. Document
types are refused, and with them entity bombs, external entities and default attributes.

`xml.etree` builds its tree in C and knows no places; `read_utf8` knows every place and takes ten
times as long. Both are expat underneath, so they agree on what is well-formed. What is not, or has
a document type or an undeclared prefix, goes to `read_utf8` at once, which says what is wrong.
The first place that is asked for costs a pass that finds where each tag begins.
"""

from __future__ import annotations

import codecs
import contextlib
import re
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple
from xml.etree.ElementTree import Element, ParseError, TreeBuilder, XMLParser
from xml.parsers import expat

from flexbe_synthesizer.core.chart.problem import ChartError, Position, Problem, ProblemKind

XML_NAMESPACE = "http://www.w3.org/XML/1998/namespace"
_MOST_DUPLICATES = 100  # each costs a pass over the file; this many are enough to begin with
_ENCODINGS = {"utf-8", "us-ascii", "ascii", "iso-8859-1", "latin-1", "windows-1252"}
_DECLARATION = re.compile(rb"""<\?xml\s[^>]*?encoding\s*=\s*["']([\w.:-]+)""")
_TAG_NAME = re.compile(rb"<[^\s/>]+")
_ATTRIBUTE = re.compile(rb"""\s*([^\s=/>]+)\s*=\s*("[^"]*"|'[^']*')""")
_LINE_END = r"\r\n?|\n"


@dataclass
class Places:
    """Where an element stands, its attributes by name, and the first text in it, if any."""

    element: Position
    attributes: Mapping[str, Position]
    text: Position | None = None


@dataclass(frozen=True)
class Document:
    """The root element, all places in document order, and what was wrong without being fatal.

    Tags and attributes are spelled `{namespace}name`.
    """

    root: Element
    places: tuple[Places, ...]
    problems: tuple[Problem, ...]


def read_utf8(data: bytes, file: str) -> Document:
    """Return the document that `as_utf8` gave the bytes of.

    Raises:
        ChartError: if it is not well-formed XML, or has a DOCTYPE.
    """
    duplicates: list[Problem] = []
    while len(duplicates) < _MOST_DUPLICATES:
        try:
            document = _Reading(data, file).document()
        except _DuplicateAttributeError as found:
            duplicates.append(found.problem)
            data = found.mended
        except ChartError as error:
            raise ChartError((*duplicates, *error.problems)) from error
        else:
            return replace(document, problems=(*duplicates, *document.problems))
    raise ChartError(duplicates)


def read_description(data: bytes) -> str:
    """Return the first comment in the root before any element, else the last before the root.

    Args:
        data: a document in UTF-8; it is read as far as its second element.
    """
    _root, before, inside = _read_head(data)
    return (*inside, *before[-1:], "")[0]


def read_root(data: bytes) -> tuple[str, dict[str, str]]:
    """Return name and attributes of the outermost element as they are spelled; "" if there is none.

    Args:
        data: a document in UTF-8; it is read as far as its second element.
    """
    return (*_read_head(data)[0], ("", {}))[0]


def _read_head(data: bytes) -> tuple[list[tuple[str, dict[str, str]]], list[str], list[str]]:
    """Return the outermost element, if any, and the comments before and at once in it."""
    root: list[tuple[str, dict[str, str]]] = []
    before, inside = list[str](), list[str]()

    def start(name: str, attributes: dict[str, str]) -> None:
        if root:
            raise _HeadReadError
        root.append((name, attributes))

    def refuse(*_found: object) -> None:
        raise _HeadReadError

    parser = expat.ParserCreate(encoding="utf-8")
    parser.StartElementHandler = start
    parser.EndElementHandler = refuse
    parser.StartDoctypeDeclHandler = refuse
    parser.CommentHandler = lambda text: (inside if root else before).append(text)
    with contextlib.suppress(_HeadReadError, expat.ExpatError):
        parser.Parse(data, True)
    return root, before, inside


class _HeadReadError(Exception):
    """The head of a document has been read, and the rest is not wanted."""


def as_utf8(source: str | bytes, file: str) -> bytes:
    """Return the source in UTF-8, whatever its byte order mark or declaration says it is in.

    Half characters of a text stay in it for expat to find.

    Raises:
        ChartError: if the encoding is not known, or not that of the bytes.
    """
    return _without_nul(source if isinstance(source, str) else decoded(source, file), file)


def decoded(source: bytes, file: str) -> str:
    """Return the text of a source, whatever its byte order mark or declaration says it is in.

    Raises:
        ChartError: if the encoding is not known, or not that of the bytes.
    """
    encoding = _encoding(source, file)
    try:
        return source.decode(encoding)
    except UnicodeDecodeError as error:  # it counts from behind the byte order mark of UTF-8
        before, byte = error.object[: error.start], error.object[error.start]
        place = _place_behind(before.decode(encoding, "replace"), file)
        expected = encoding.removesuffix("-sig")
        message = f"byte {byte:#04x} is not {expected}; save the file as UTF-8."
        raise ChartError([Problem(place, ProblemKind.NOT_XML, message)]) from error


def encoded(text: str, file: str, like: bytes) -> bytes:
    """Return a text as a file in its place is encoded, characters that cannot be as references.

    Args:
        text: what `decoded` reads from the bytes that are returned.
        file: path of the file, for messages.
        like: the bytes that were there before; empty if there were none.

    Raises:
        ChartError: if the text declares an encoding that is not known.
    """
    marks = {codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
    if like[:2] in marks:
        return like[:2] + text.encode(marks[like[:2]])
    if b"\0" in like[:2]:
        return text.encode(_encoding(like, file))
    is_marked = like.startswith(codecs.BOM_UTF8)
    encoding = "utf-8" if is_marked else _encoding(text.encode(), file).removesuffix("-sig")
    mark = codecs.BOM_UTF8 if is_marked else b""
    return mark + text.encode(encoding, "xmlcharrefreplace")


def _encoding(data: bytes, file: str) -> str:
    """Return the encoding by the byte order mark, the first letter or the declaration."""
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    if data.startswith((b"<\0", b"\0<")):
        return "utf-16-le" if data.startswith(b"<") else "utf-16-be"
    declared = _DECLARATION.match(data)
    if declared is None:
        return "utf-8-sig"
    name = declared[1].decode().lower()
    if name not in _ENCODINGS:
        message = f"the file says that it is in {name!r}, which is not read here; save it as UTF-8."
        raise ChartError([Problem(Position(file, 1, 1), ProblemKind.NOT_XML, message)])
    return name


def _without_nul(text: str, file: str) -> bytes:
    """Return the text in UTF-8; expat would take one with NUL characters for UTF-16."""
    before, nul, _after = text.partition("\0")
    if nul:
        message = "a NUL character, which no XML file holds; save the file as UTF-8."
        raise ChartError([Problem(_place_behind(before, file), ProblemKind.NOT_XML, message)])
    return text.encode("utf-8", "surrogatepass")


def _place_behind(text: str, file: str) -> Position:
    """Return the place behind the text that a file begins with."""
    lines = re.split(_LINE_END, text)
    return Position(file, len(lines), len(lines[-1]) + 1)


def attributes_of(data: bytes, start: int) -> Iterator[re.Match[bytes]]:
    """Yield the attributes of the tag that begins at a byte: blanks, (1) name, (2) quoted value."""
    tag = _TAG_NAME.match(data, start)
    at = tag.end() if tag else start
    while (found := _ATTRIBUTE.match(data, at)) is not None:
        yield found
        at = found.end()


def declared_prefix(name: str) -> str | None:
    """Return the prefix that an attribute declares, empty: the default; None: it is another one."""
    word, _, prefix = name.partition(":")
    return prefix if word == "xmlns" else None


class _DuplicateAttributeError(Exception):
    """An attribute stands twice; `mended` is the source with the second one blanked out."""

    def __init__(self, problem: Problem, mended: bytes) -> None:
        super().__init__(str(problem))
        self.problem = problem
        self.mended = mended


class _Open(NamedTuple):
    """An element whose end has not been read yet, and the prefixes that it declares."""

    name: str
    element: Element
    places: Places
    prefixes: list[str]


class _Reading:
    """One pass of expat over a source in UTF-8."""

    def __init__(self, data: bytes, file: str) -> None:
        self._data = data
        self._file = file
        self._problems: list[Problem] = []
        self._open: list[_Open] = []
        self._places: list[Places] = []
        self._namespaces: dict[str, list[str]] = {"xml": [XML_NAMESPACE]}
        self._root: Element | None = None
        self._parser = expat.ParserCreate(encoding="utf-8")
        self._parser.ordered_attributes = True
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._take_text
        self._parser.StartDoctypeDeclHandler = self._refuse_doctype

    def document(self) -> Document:
        try:
            self._parser.Parse(self._data, True)
        except expat.ExpatError as error:
            raise self._explain(error) from error
        if self._root is None:
            raise AssertionError("expat accepted a document without an element")
        return Document(self._root, tuple(self._places), tuple(self._problems))

    def _here(self) -> Position:
        line, column = self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber
        return Position(self._file, line, column + 1)

    def _start(self, name: str, pairs: list[str]) -> None:
        here = self._here()
        found = dict(self._attribute_places(here))
        values = dict(zip(pairs[::2], pairs[1::2], strict=True))
        prefixes = []
        for raw, value in values.items():
            declared = declared_prefix(raw)
            if declared is not None:
                self._namespaces.setdefault(declared, []).append(value)
                prefixes.append(declared)
        attributes: dict[str, str] = {}
        places: dict[str, Position] = {}
        for raw, value in values.items():
            if declared_prefix(raw) is not None:
                continue
            prefix, _, local = raw.rpartition(":")
            namespace = self._namespace(prefix) if prefix else ""
            spelled = _spelled(namespace, local)
            if namespace is None:
                message = (
                    f"the prefix '{prefix}' is not declared; write "
                    f'xmlns:{prefix}="..." in the root element.'
                )
                self._problems.append(Problem(found[raw], ProblemKind.UNBOUND_PREFIX, message))
            elif spelled in attributes:  # by two prefixes of one namespace
                self._problems.append(_stands_twice(raw, found[raw]))
            else:
                attributes[spelled], places[spelled] = value, found[raw]
        prefix, _, local = name.rpartition(":")
        namespace = self._namespace(prefix)
        if namespace is None and prefix:
            message = f"the prefix '{prefix}' of <{name}> is not declared."
            self._problems.append(Problem(here, ProblemKind.UNBOUND_PREFIX, message))
        element = Element(_spelled(namespace, local), attributes)
        if self._open:
            self._open[-1].element.append(element)
        else:
            self._root = element
        self._places.append(Places(here, places))
        self._open.append(_Open(name, element, self._places[-1], prefixes))

    def _namespace(self, prefix: str) -> str | None:
        """Return what a prefix stands for in the element that is open; None: nothing."""
        declared = self._namespaces.get(prefix)
        return declared[-1] if declared else None

    def _attribute_places(self, here: Position) -> Iterator[tuple[str, Position]]:
        """Yield name and position of each attribute of the tag that expat stands at."""
        line, column, counted = here.line, here.column, self._parser.CurrentByteIndex
        for found in attributes_of(self._data, counted):
            *ended, rest = re.split(_LINE_END, self._data[counted : found.start(1)].decode())
            line, column = line + len(ended), len(rest) + (1 if ended else column)
            counted = found.start(1)
            yield found[1].decode(), Position(self._file, line, column)

    def _end(self, _name: str) -> None:
        for prefix in self._open.pop().prefixes:
            self._namespaces[prefix].pop()

    def _take_text(self, text: str) -> None:
        innermost = self._open[-1]
        if innermost.places.text is None and text.strip():
            file, line, column = self._here()
            blanks = len(text) - len(text.lstrip())
            innermost.places.text = Position(file, line, column + blanks)
            innermost.element.text = "text"

    def _refuse_doctype(self, *_declaration: object) -> None:
        message = "a chart has no document type and no entities; delete the <!DOCTYPE ...>."
        start = self._data.rfind(b"<!DOCTYPE", 0, self._parser.CurrentByteIndex + 1)
        place = _place_behind(self._data[: max(start, 0)].decode(), self._file)
        raise ChartError([Problem(place, ProblemKind.DOCTYPE, message)])

    def _explain(self, error: expat.ExpatError) -> Exception:
        """Return what to raise for a fault that expat found."""
        position = Position(self._file, error.lineno, error.offset + 1)
        at = self._parser.ErrorByteIndex
        if error.code == expat.errors.codes[expat.errors.XML_ERROR_DUPLICATE_ATTRIBUTE]:
            found = _ATTRIBUTE.match(self._data, at)
            if found is not None:
                blanked = re.sub(rb"[^\r\n]", b" ", found[0])
                mended = self._data[:at] + blanked + self._data[found.end() :]
                problem = _stands_twice(found[1].decode(), position)
                return _DuplicateAttributeError(problem, mended)
        message = f"not well-formed XML: {expat.ErrorString(error.code)}."
        if not self._data.strip():
            message = "the file is empty; a chart is one <statemachine> element."
        elif self._open:
            innermost = self._open[-1]
            message += f" <{innermost.name}> of line {innermost.places.element.line} is open here."
        return ChartError([Problem(position, ProblemKind.NOT_XML, message)])


def _stands_twice(name: str, position: Position) -> Problem:
    message = f"the attribute '{name}' stands twice in this element; delete one."
    return Problem(position, ProblemKind.DUPLICATE_ATTRIBUTE, message)


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
            root, self.problems = self._exact.root, self._exact.problems
        self.root = root
        text = "".join(self.root.itertext())
        self.has_text = bool(text) and not text.isspace()

    @property
    def description(self) -> str:
        """Return the first comment in the root before any element, else the one before the root."""
        return read_description(self._data)

    def place(self, element: Element, attribute: str = "") -> Position:
        """Return where an attribute of the element stands, else where the element does.

        Of two with one name it is the one without a prefix (xsi:type is not the type), unless the
        attribute is spelled with a namespace.
        """
        namespace, _, name = attribute.rpartition("}")
        if not self._is_fast:
            exact = self._places[id(element)]
            same = [n for n in exact.attributes if name and n.rpartition("}")[2] == name]
            same.sort(key=lambda spelled: spelled != attribute)
            return exact.attributes[same[0]] if same else exact.element
        start = self._starts[id(element)]
        found = [(m[1].decode(), m.start(1)) for m in attributes_of(self._data, start) if name]
        spelled = [s for s in found if s[0].rpartition(":")[2] == name]
        spelled = [s for s in spelled if declared_prefix(s[0]) is None]
        spelled.sort(key=lambda s: (":" in s[0]) is (namespace == ""))
        return self._position(spelled[0][1] if spelled else start)

    def text_place(self, element: Element) -> Position | None:
        """Return where the first text in the element stands that is not blank."""
        return self._places[id(element)].text

    def _position(self, at: int) -> Position:
        """Return the place of a byte."""
        line = bisect_right(self._line_starts, at)
        before = self._data[self._line_starts[line - 1] : at]
        return Position(self._file, line, len(before.decode()) + 1)

    @cached_property
    def _line_starts(self) -> list[int]:
        return [0, *(end.end() for end in re.finditer(_LINE_END.encode(), self._data))]

    @cached_property
    def _starts(self) -> Mapping[int, int]:
        """Return the byte that the tag of each element begins at, by the element's identity."""
        starts: list[int] = []
        parser = expat.ParserCreate(encoding="utf-8")
        parser.ordered_attributes = True  # a list is made faster than a dictionary
        parser.StartElementHandler = lambda _name, _given: starts.append(parser.CurrentByteIndex)
        parser.Parse(self._data, True)
        return dict(zip(map(id, self.root.iter()), starts, strict=True))

    @cached_property
    def _exact(self) -> Document:
        return read_utf8(self._data, self._file)

    @cached_property
    def _places(self) -> Mapping[int, Places]:
        """Return the places of each element and of what is in it, by the element's identity."""
        return dict(zip(map(id, self.root.iter()), self._exact.places, strict=True))


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


def _spelled(namespace: str | None, name: str) -> str:
    return f"{{{namespace}}}{name}" if namespace else name
