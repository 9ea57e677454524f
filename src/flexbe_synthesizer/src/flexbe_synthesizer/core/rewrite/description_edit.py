"""Change the comment that describes a chart, in place."""

from __future__ import annotations

from flexbe_synthesizer.core.chart.chart_writer import Style, comment, expect_xml
from flexbe_synthesizer.core.rewrite.xml_layout import XmlLayout


def description_edit(
    layout: XmlLayout, style: Style, old: str, new: str
) -> tuple[int, int, str] | None:
    """Return the edit (start, end, text) that makes one description another; None: there is none.

    Lines that are added go below those that are there, which stay as they are.
    """
    if old == new:
        return None
    span = layout.description
    if span is None:
        return _added(layout, style, new)
    start, end = span
    newline = layout.newline(end)
    if not new:
        next_line = layout.next_line(end)
        if layout.begins_line(start) and next_line is not None:
            return layout.line_start(start), next_line, ""
        return start, end, ""
    if old and new.startswith(f"{old}\n"):
        text_end = start + len(layout.data[start : end - 3].rstrip())
        margin = _margin(layout, start, text_end)
        lines = new[len(old) + 1 :].split("\n")
        text = "".join(f"{newline}{margin}{line}".rstrip() for line in lines)
        return text_end, text_end, expect_xml(text)
    margin = " " * (start - layout.line_start(start) + len("<!-- "))
    return start, end, comment(new, newline + margin)


def _added(layout: XmlLayout, style: Style, new: str) -> tuple[int, int, str]:
    """Return the edit that adds a description where there is none."""
    root = layout.root
    newline, indent = layout.newline(root.head_end), ""
    lead = ""
    if layout.next_line(root.head_end) is not None:
        indent = layout.indentation(root.start) + style.indent
        lead = newline + indent
    text = comment(new, newline + indent + " " * len("<!-- "))
    return root.head_end, root.head_end, lead + text


def _margin(layout: XmlLayout, start: int, text_end: int) -> str:
    """Return the blanks before the lines of a comment, as far as all but the first have them."""
    lines = layout.data[start:text_end].decode().split("\n")[1:]
    blanks = [line[: len(line) - len(line.lstrip())] for line in lines if line.strip()]
    if blanks:
        return min(blanks, key=len)
    return " " * (start - layout.line_start(start) + len("<!-- "))
