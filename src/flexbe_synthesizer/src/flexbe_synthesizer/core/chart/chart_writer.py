"""Write charts as XML: a whole new file, or the lines of an element that joins one."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from flexbe_synthesizer.core.chart.chart_parts import Part, chart_part
from flexbe_synthesizer.core.chart.grammar import EXTENSION
from flexbe_synthesizer.core.chart.model import Chart

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
